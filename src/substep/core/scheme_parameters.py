"""The parameters of a scheme from those that are given: by a family's argument, decided by others, or by default."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array
from .entries import ParameterInfo, SchemeInfo
from .errors import unknown_name

# parameters that some programs count from the other end of the step -> how theirs become ours
OF_THE_NEW_STATE = {
    "alpha": 'ss.dialect("opensees.HHT", alpha=0.9)',
    "alpha_m": 'ss.dialect("opensees.GeneralizedAlpha", alphaM=1.1, alphaF=0.8)',
    "alpha_f": 'ss.dialect("opensees.GeneralizedAlpha", alphaM=1.1, alphaF=0.8)',
}


def completed(info: SchemeInfo, parameters: Mapping[str, ArrayLike]) -> tuple[dict[str, Array], dict[str, Array]]:
    """All parameters of a scheme in the order of its declaration, and those of them that these set.

    parameters: of the scheme, or arguments of its families. Raises ValueError as `substep.scheme` does.
    """
    given: dict[str, Array] = {}
    for key, value in parameters.items():
        if key in info.parameters:
            new = {key: _checked(info, info.parameters[key], value)}
        elif key in info.families:
            argument = _checked(info, info.families[key].argument, value)
            new = {own: np.asarray(function(argument)) for own, function in info.families[key].values.items()}
        elif not info.parameters:
            raise ValueError(f"{info.name} has no parameters: expected none, got {key!r}; leave it out")
        else:
            raise unknown_name(f"a parameter of {info.name}", key, [*info.parameters, *info.families])
        if twice := sorted(new.keys() & given.keys()):
            raise ValueError(
                f"expected {twice[0]} of {info.name} once, got it by itself and through a family; drop one of the two"
            )
        given |= new
    complete: dict[str, Array] = {}
    for key, parameter in info.parameters.items():
        value = given[key] if key in given else parameter.default_of(info.name, complete)
        complete[key] = value if key in parameters else _checked(info, parameter, value)
    for key, (by, function) in info.decided.items():
        if by in given:
            complete[key] = _decided(info, key, by, function(complete[by]), given.get(key))
            given.pop(key, None)
    return complete, given


def _decided(info: SchemeInfo, key: str, by: str, follows: ArrayLike, given: Array | None) -> Array:
    """The value that another parameter decides. Raises ValueError for another one given, or outside the interval."""
    value, parameter = np.asarray(follows, dtype=np.float64), info.parameters[key]
    if given is not None and not np.allclose(value, given, rtol=0, atol=1e-8):
        raise ValueError(
            f"expected {key} or {by} of {info.name}, which decides it, got both: {key} = {given} and a {by} for "
            f"which it is {value}; drop one of the two"
        )
    for end in (parameter.low, parameter.high):
        value = value if end is None else np.where(abs(value - end) < 1e-12, end, value)
    return _checked(info, parameter, value, f" (which {by} decides)")


def _checked(info: SchemeInfo, parameter: ParameterInfo, value: ArrayLike, why: str = "") -> Array:
    try:
        array = parameter.inside(f"parameter {parameter.name} of {info.name}{why}", value).copy()
    except ValueError as error:
        if parameter.name not in OF_THE_NEW_STATE:
            raise
        raise ValueError(f"{error}; of programs that count it from 1: {OF_THE_NEW_STATE[parameter.name]}") from None
    array.flags.writeable = False
    return array
