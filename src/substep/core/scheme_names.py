"""The catalogue's index of schemes, and which of them is meant by a name."""

import re
import unicodedata
from collections.abc import Collection, Mapping, Sequence
from functools import cache
from types import MappingProxyType
from typing import Any

from .elsewhere import ELSEWHERE
from .errors import meant, unknown_name
from .kernel_modules import loaded

SCHEMES: Mapping[str, Mapping[str, Any]] = loaded("index").SCHEMES


def named(name: str) -> str:
    """The catalogue's name of the scheme that is meant by a name, or by a synonym, however it is written.

    Raises ValueError for a synonym of several schemes, for a method that the catalogue does not have, with the reason,
    and for an unknown name.
    """
    if name in SCHEMES:
        return name
    synonyms, apart = _synonyms(), re.sub(r"(?<=[a-z])(?=[A-Z])|(?<=[A-Z])(?=[A-Z][a-z])", "_", name)
    for asked in (*_written(name), *_written(apart)):
        if asked in SCHEMES:
            return asked
        if len(meant := synonyms.get(asked, ())) == 1:
            own, _, values = meant[0].partition(": ")
            if values:
                raise ValueError(
                    f"expected a scheme's name, got '{name}', which is {own} at {values}; write "
                    f"ss.scheme('{own}', {values})"
                )
            return own
        if meant:
            raise ValueError(f"expected one scheme, got '{name}', which may be {' or '.join(meant)}; write which")
        if asked in ELSEWHERE:
            raise ValueError(f"expected a scheme of the catalogue, got '{name}', which is none: {ELSEWHERE[asked]}")
    raise unknown_name("a scheme", name, (*SCHEMES, *synonyms), "substep.schemes(), or `substep schemes`, lists all")


def found(name: str, text: str) -> bool:
    """Whether a text is in the name, a synonym or the reference of a scheme of the catalogue, as words are written."""
    entry, asked = SCHEMES[name], _written(text)[0]
    return any(asked in _written(words)[0] for words in (name, entry["reference"], *entry.get("synonyms", ())))


def unknown_argument(
    what: str, name: str, known: Sequence[str], scheme: Any, others: Mapping[str, Collection[str]]
) -> ValueError:
    """The error for an argument that a march does not have, which says who has it, of schemes first the one given.

    others: by calls, with {} for an argument, the arguments that each has.
    """
    given = getattr(scheme, "name", scheme)
    schemes = {**({given: SCHEMES[given]} if given in SCHEMES else {}), **SCHEMES}
    takes = {of: [x[0] for x in entry["parameters"]] + [*entry.get("families", ())] for of, entry in schemes.items()}
    own = meant(name, known)
    for call, names in {**others, **{f"ss.scheme('{of}', {{}}=...)": names for of, names in takes.items()}}.items():
        how = "" if name in names else meant(name, names)
        if name in names or (how and not own):
            ours = re.split(r"\W", how)[0] or name
            here = f"; here it is {own or how}" if own or how else ""
            return ValueError(f"expected {what}, got '{name}'{here}; {ours} is an argument of {call.format(ours)}")
    return unknown_name(what, name, known)


def _written(name: str) -> tuple[str, str]:
    """A name in small letters with words joined by _, and the same without a last word such as method."""
    dashed = re.sub("[\u2010-\u2015]", "-", re.sub("['’]s?", "", name.lower()))  # of Crank–Nicolson as papers print it
    plain = unicodedata.normalize("NFKD", dashed).encode("ascii", "ignore").decode()
    written = re.sub(r"[\W_]+", "_", plain).strip("_")
    return written, re.sub("_(method|scheme|algorithm)$", "", written)


@cache
def _synonyms() -> Mapping[str, tuple[str, ...]]:
    """Names of schemes by each synonym, with the parameters for which it stands, if it does."""
    found: dict[str, tuple[str, ...]] = {}
    for name, entry in SCHEMES.items():
        for synonym in entry.get("synonyms", ()):
            known, _, values = synonym.partition(": ")
            found[known] = (*found.get(known, ()), f"{name}: {values}" if values else name)
    return MappingProxyType(found)
