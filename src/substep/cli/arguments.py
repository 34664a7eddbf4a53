"""Options whose names are parameters of schemes and scenes, which the command line does not know in advance."""

import re
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from fractions import Fraction
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console

from ..core.scene_by_name import scene
from ..core.scene_catalogue import scenes
from ..core.scenes import Scene
from ..core.schemes import Scheme, scheme, schemes

if TYPE_CHECKING:
    from ..derived.modules import Declaration

StartOption = Annotated[str, typer.Option(help="initial acceleration: consistent, or numbers as -19.6,0")]
StrainOption = Annotated[str, typer.Option(help="elastic_pendulum: green_lagrange or engineering")]


def known_schemes(incomplete: str) -> list[str]:
    """The names of schemes that begin so, for the completion of the shell."""
    return [name for name in schemes() if name.startswith(incomplete)]


def known_scenes(incomplete: str) -> list[str]:
    """The names of scenes that begin so, likewise."""
    return [name for name in scenes() if name.startswith(incomplete)]


A_SCHEME = (
    "a name listed by `substep schemes`, or file.py:name of a declaration of your own; "
    "parameters may follow it as newmark:beta=1/4,gamma=.5"
)
A_SCENE = "a name listed by `substep scenes`"
SchemeArgument = Annotated[str, typer.Argument(help=A_SCHEME, autocompletion=known_schemes)]
SchemeOfRun = Annotated[str, typer.Argument(metavar="SCHEME", help=A_SCHEME, autocompletion=known_schemes)]
SchemeOption = Annotated[str, typer.Option("--scheme", help=A_SCHEME, autocompletion=known_schemes)]
SceneArgument = Annotated[str, typer.Argument(metavar="SCENE", help=A_SCENE, autocompletion=known_scenes)]


NONE: Mapping[str, str] = MappingProxyType({})


@contextmanager
def working(what: str) -> Iterator[None]:
    """Shows what is being worked on, on a terminal's stderr, while it lasts."""
    with Console(stderr=True).status(what):
        yield


def scene_of(name: str, a0: str, strain: str, parameters: dict[str, float]) -> Scene:
    """The scene that the options describe; a0 and strain are empty where they were not given."""
    options: dict[str, object] = {"strain": strain} if strain else {}
    if a0:
        options["a0"] = a0 if a0 == "consistent" else [number("--a0", x) for x in a0.split(",")]
    return scene(name, **options, **parameters)


def given_of(context: typer.Context, options: Iterable[str]) -> list[str]:
    """Those of the command's options, by the names of its arguments, that were given."""
    sources = ((name, context.get_parameter_source(name)) for name in options)
    return [name for name, source in sources if source is not None and source.name != "DEFAULT"]


def refuse(context: typer.Context, options: Iterable[str], where: str) -> None:
    """Raise ValueError for an option that was given and that nothing is made of; where: that is so, in words."""
    for name in given_of(context, options):
        option = next(p.opts[0] for p in context.command.params if p.name == name)
        raise ValueError(f"expected no {option} {where}, of which nothing is made there, got it; leave it out")


def require_files(*files: Path | None) -> None:
    """Raise ValueError for a file to be read that is not there."""
    for file in files:
        if file is not None and not file.is_file():
            kind = "is a folder" if file.is_dir() else "is not there"
            raise ValueError(f"expected a file to read, got {file}, which {kind}; correct the path")


def as_options(message: str, *names: str) -> str:
    """A message of the Python API as one of the command: its arguments of these names as options."""
    return re.sub(rf"(?<![\w-])({'|'.join(names)})=", r"--\1=", message)


def require_folders(*files: Path | None) -> None:
    """Raise ValueError for a file that cannot be written because its folder is missing, before any work is done."""
    for file in files:
        if file is not None and not file.parent.is_dir():
            raise ValueError(f"expected a folder that is there for {file}, got {file.parent}; make it first")


def names(text: str) -> list[str] | None:
    """The parts of a text as bathe,rk4; None for an empty one, which means that nothing was chosen."""
    return [name.strip() for name in text.split(",") if name.strip()] or None


def schemes_of(text: str) -> list[Scheme] | None:
    """The handles of schemes named as for `source_of`, with commas between, as newmark:beta=1/4,gamma=.5,rk4.

    A comma begins a parameter where = follows before the next : or comma. None for an empty text, which means that
    nothing was chosen. Raises ValueError as `scheme_of`.
    """
    return [scheme_of(name.strip()) for name in re.split(r",(?![^:,]*=)", text) if name.strip()] or None


def integers(name: str, text: str) -> list[int]:
    """The numbers of a text as 0,3. Raises ValueError, with the option's name, where one is none."""
    try:
        return [int(part) for part in names(text) or []]
    except ValueError as error:
        raise ValueError(f"expected numbers of degrees of freedom as 0,3 for {name}, got '{text}'") from error


def number(name: str, text: str) -> float:
    """The text of the option `name`, a decimal or a fraction, as a number. Raises ValueError where it is none."""
    try:
        return float(Fraction(text))
    except (ValueError, ZeroDivisionError) as error:
        raise ValueError(f"expected a number such as 0.2 or 1/5 for {name}, got '{text}'; correct it") from error


def source_of(text: str, options: Mapping[str, str] = NONE) -> "tuple[str | Declaration, dict[str, str]]":
    """The name or declaration, and the parameters, of a text such as bathe, newmark:beta=1/4 or file.py:mine:gamma=.7.

    options: further parameters, from `exact_options`. Raises ValueError for a file that is not there or does not
    declare the scheme, and for parameters that are not written so.
    """
    from ..derived import facade  # noqa: PLC0415 (on first use)

    if text.endswith(".py"):
        raise ValueError(f"expected the name of a declaration in the file too, got '{text}'; write {text}:NAME")
    file, is_file, own = text.rpartition(".py:")
    name, _, rest = (own if is_file else text).partition(":")
    pairs = [part.partition("=") for part in rest.split(",") if part]
    if not all(equals and value for _, equals, value in pairs):
        raise ValueError(f"expected parameters as {name}:beta=1/4,gamma=.5, got '{text}'; write name=value")
    given = {key.replace("-", "_"): value for key, _, value in pairs} | dict(options)
    if not is_file:
        return name, given
    path = Path(f"{file}.py")
    require_files(path)
    return facade.declaration(path, name), given


def scheme_of(text: str, options: Mapping[str, str] = NONE) -> Scheme:
    """The handle of a scheme that is named as for `source_of`. Raises ValueError as this and `substep.scheme` do."""
    source, given = source_of(text, options)
    return scheme(source, **{key: number(key, value) for key, value in given.items()})


def declared(text: str) -> "Declaration":
    """The declaration, with parameters fixed, of a scheme named as for `source_of`; raises ValueError as this."""
    from ..derived import facade  # noqa: PLC0415 (on first use)

    source, given = source_of(text)
    return facade.derived(source, **given).scheme


def numbers(arguments: list[str]) -> dict[str, float]:
    """`exact_options` with values as numbers."""
    return {key: number(f"--{key.replace('_', '-')}", text) for key, text in exact_options(arguments).items()}


def exact_options(arguments: list[str]) -> dict[str, str]:
    """Values by name, as text, of --name value or --name=value; a dash in the name stands for an underscore."""
    values: dict[str, str] = {}
    rest = iter(arguments)
    for argument in rest:
        if not argument.startswith("--"):
            raise ValueError(f"expected a parameter such as --gamma-t 1/5, got '{argument}'")
        key, joined, value = argument[2:].partition("=")
        if not joined:
            value = next(rest, "")
        if not value:
            raise ValueError(f"expected a number after --{key}, got none")
        name = key.replace("-", "_")
        if name in values:
            raise ValueError(f"expected --{key} once, got it twice, {values[name]} and {value}; drop one of the two")
        values[name] = value
    return values
