"""Options of the command line: parameters of schemes and scenes, which are not known before they are read."""

from pathlib import Path

from ..core.scenes import Scene, scene


def scene_of(name: str, a0: str, strain: str, parameters: dict[str, float]) -> Scene:
    """The scene of these options, empty where they were not given."""
    options: dict[str, object] = {"strain": strain} if strain else {}
    if a0:
        options["a0"] = a0 if a0 == "consistent" else [number("--a0", x) for x in a0.split(",")]
    return scene(name, **options, **parameters)


def room_for(*files: Path | None) -> None:
    """Raises ValueError for a file whose folder is not there, before work is done for it."""
    for file in files:
        if file is not None and not file.parent.is_dir():
            raise ValueError(f"expected a folder that is there for {file}, got {file.parent}; make it first")


def number(name: str, text: str) -> float:
    """The number of the option of that name. Raises ValueError for what is none."""
    try:
        return float(text)
    except ValueError as error:
        raise ValueError(f"expected a number such as 0.2 for {name}, got '{text}'; correct it") from error


def numbers(arguments: list[str]) -> dict[str, float]:
    """--name value, as numbers."""
    return {key: number(f"--{key.replace('_', '-')}", text) for key, text in exact_options(arguments).items()}


def exact_options(arguments: list[str]) -> dict[str, str]:
    """--name value or --name=value, a dash in the name standing for an underscore; values stay text."""
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
        values[key.replace("-", "_")] = value
    return values
