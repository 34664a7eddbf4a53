"""What is given of a structure beside its matrices: names, degrees of freedom, loads; checked."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array
from ...core.errors import real_array, real_number, unknown_name
from ...core.loads import Load
from ..solvers.matrices import Matrix

Dof = int | str
LoadPair = tuple[ArrayLike | Mapping[Dof, float], Load]


def loads_of(T: Matrix, names: tuple[str, ...], load: LoadPair | Iterable[LoadPair]) -> tuple[tuple[Array, Load], ...]:
    """Loads in the free degrees of freedom from what `structure` takes as load; T, names: of a `Model`."""
    moving = np.asarray(abs(T).sum(axis=1)).ravel()
    held = np.flatnonzero(moving == 0.0).tolist()
    return tuple((T.T @ _shape(P, names, held, T.shape[0]), _function(g)) for P, g in _pairs(load))


def names_of(names: Sequence[str], N: int) -> tuple[str, ...]:
    """Names of all N degrees of freedom, or none. Raises ValueError for what is no list of N different strings."""
    known = tuple(names)
    if isinstance(names, str):
        raise ValueError(f"expected names as a list, one for each degree of freedom, got {names!r}; give a list")
    if known and len(known) != N:
        raise ValueError(f"expected {N} different names, one for each degree of freedom, got {len(known)}")
    for name, times in Counter(known).items():
        if not isinstance(name, str):
            raise ValueError(f"expected names of degrees of freedom as strings, got {name!r}; or leave names out")
        if times > 1:
            raise ValueError(f"expected {N} different names, got {name!r} {times} times; rename all but one")
    return known


def numbered(names: Iterable[str]) -> dict[str, int]:
    """The number of each degree of freedom, by name."""
    return {name: number for number, name in enumerate(names)}


def place_of(dof: Dof, numbers: Mapping[str, int], N: int) -> int:
    """The number of a degree of freedom, by name or number. Raises ValueError for one that is not there.

    numbers: of all N by their names, or empty.
    """
    if isinstance(dof, str):
        if not numbers:
            raise ValueError(
                f"expected a degree of freedom from 0 to {N - 1}, got {dof!r}; to ask by name, give names= to it"
            )
        if dof not in numbers:
            raise unknown_name("a degree of freedom", dof, numbers)
        return numbers[dof]
    if isinstance(dof, bool) or not isinstance(dof, int | np.integer) or not 0 <= dof < N:
        raise ValueError(f"expected a degree of freedom from 0 to {N - 1} or its name, got {dof!r}")
    return int(dof)


def by_dof(what: str, given: Mapping[Dof, float], names: Sequence[str], N: int) -> Array:
    """The vector (N,) of numbers by degrees of freedom, 0 elsewhere; what: that of which they are components.

    Raises ValueError for a degree of freedom that is there twice, by name and by number.
    """
    numbers = numbered(names)
    places = [place_of(dof, numbers, N) for dof in given]
    if len(set(places)) < len(places):
        again = next(dof for k, dof in enumerate(given) if places[k] in places[:k])
        raise ValueError(f"expected each degree of freedom once in {what}, got {again!r} again; add up its parts")
    found = np.zeros(N)
    found[places] = [real_number(f"a component of {what}", value) for value in given.values()]
    return found


def _pairs(load: LoadPair | Iterable[LoadPair]) -> list[LoadPair]:
    if isinstance(load, tuple) and len(load) == 2 and callable(load[1]) and not callable(load[0]):
        return [cast("LoadPair", load)]
    pairs: list[LoadPair] = list(cast("Iterable[LoadPair]", load)) if isinstance(load, Iterable) else [load]
    for pair in pairs:
        if not isinstance(pair, tuple) or len(pair) != 2:
            raise ValueError(
                f"expected load as pairs (P, g) of a vector and a function of time, got {repr(pair)[:60]} in place of "
                f"a pair; {_pair_of(load)}"
            )
    return pairs


def _pair_of(load: Any) -> str:
    """How to make pairs of what was given as load in their place."""
    if callable(load):
        return "give (P, g), where P says how much of this function g each degree of freedom takes, as {0: 1.0}"
    if isinstance(load, np.ndarray) and load.ndim == 2:
        return (
            "of a matrix F (N, n) of samples at steps of dt give a pair for each degree of freedom that is loaded: "
            "[({i: 1.0}, ss.Record(dt, F[i])) for i in range(N)]"
        )
    if isinstance(load, np.ndarray):
        return "give (P, g), as (P, ss.Step(1.0)) for a vector P (N,) that stays, or ({0: 1.0}, ss.Record(dt, samples))"
    return "give a list of tuples"


def _shape(P: ArrayLike | Mapping[Dof, float], names: tuple[str, ...], held: Sequence[int], N: int) -> Array:
    if isinstance(P, Mapping):
        shape = by_dof("a load", P, names, N)
    else:
        shape = real_array("load", P).copy()
        if shape.shape != (N,):
            raise ValueError(f"expected a load with {N} components, one for each degree of freedom, got {shape.shape}")
    if loaded := [dof for dof in held if shape[dof] != 0.0]:
        name = f"'{names[loaded[0]]}'" if names else loaded[0]
        raise ValueError(f"expected no load on the fixed degree of freedom {name}, got {shape[loaded[0]]}; remove it")
    return shape


def _function(g: Any) -> Load:
    if not callable(g):
        raise ValueError(
            f"expected a function of time such as ss.Step or ss.Record with each load vector, got {type(g).__name__}"
        )
    return g
