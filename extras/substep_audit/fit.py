"""Parameters of a scheme solved for, such that a residual vanishes, and recognised as exact numbers."""

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np

from substep.core.arrays import Array
from substep.core.schemes import Scheme

from .linear_step import Candidate, Oscillators, with_parameters

Residual = Callable[[Candidate], Array]
EXACT = 1e-14  # a residual beyond which other values may do better: of two equal steps one rounds less
TRIES = 5  # starting points
ROUGH = 1e-4  # relative decrease of the squares in a step of least squares, below which a residual will not vanish
FLAT = 1e-7  # how far a solution may be off where the residual is flat, as at a double root: sqrt(1e-14)
SURE = 3.0  # times what the largest entry of the residual, had it the same size everywhere, would move a parameter by
WORST = 1e6  # a residual in place of one that is not finite
IRRATIONAL = {
    "sqrt(2)": 2.0**0.5, "2 - sqrt(2)": 2.0 - 2.0**0.5, "1 - sqrt(2)/2": 1.0 - 0.5**0.5,
    "1 + sqrt(2)/2": 1.0 + 0.5**0.5,
    "(3 + sqrt(3))/6": (3.0 + 3.0**0.5) / 6.0, "(3 - sqrt(3))/6": (3.0 - 3.0**0.5) / 6.0,
}  # fmt: skip


def free_parameters(scheme: Scheme) -> Sequence[str]:
    """Names of the parameters that enter the step: not those that another one decides."""
    return [name for name in scheme.parameters if name not in scheme.info.decided]


@dataclass(frozen=True)
class Fitted:
    """A scheme, the largest entry of the residual at its parameters, and how far the noise may have moved these."""

    scheme: Scheme
    error: float
    unsure: float = 0.0


def solve(scheme: Scheme, names: Sequence[str], at: Oscillators, residual: Residual, worth: float = math.inf) -> Fitted:
    """The scheme with the named parameters such that the residual is least.

    The parameters enter a step rationally, so that a residual that can vanish does so from one of a few starts. worth:
    see `solutions`.
    """
    best = Fitted(scheme, np.inf)
    for found in solutions(scheme, names, at, residual, worth):
        if found.error < best.error:
            best = found
        if best.error <= EXACT:
            break
    return best


def solutions(
    scheme: Scheme, names: Sequence[str], at: Oscillators, residual: Residual, worth: float = math.inf
) -> Iterator[Fitted]:
    """What is found from each start: other values may do the same.

    worth: a residual beyond which a solution is left as it is once the squares decrease slowly. Near values at which
    the residual vanishes they decrease fast; most schemes are not the one that is looked for.
    """
    fit = _Fit(scheme, tuple(names), at, residual)
    if not names:
        yield Fitted(scheme, largest(fit.at_values(np.zeros(0))))
        return
    if len(fit.compared) < len(names):
        return
    for x0 in fit.guesses:
        found = fit.least(x0, ROUGH)
        if largest(found.fun) > worth:
            yield fit.measured(found)
        else:
            yield fit.recognised(fit.least(found.x, 1e-15))


@dataclass(frozen=True)
class _Fit:
    scheme: Scheme
    names: tuple[str, ...]
    at: Oscillators
    residual: Residual

    def of(self, x: Array) -> Scheme:
        values = dict(zip(self.names, x.tolist(), strict=True))
        for name, (by, function) in self.scheme.info.decided.items():
            if by in values:
                values[name] = float(function(np.float64(values[by])))
        return with_parameters(self.scheme, values)

    def at_values(self, x: Array) -> Array:
        """The residual; infinite where the scheme has no step at these values."""
        try:
            with np.errstate(all="ignore"):
                return self.residual(Candidate(self.of(x), self.at))
        except (ZeroDivisionError, np.linalg.LinAlgError):
            return np.full(1, np.inf)

    def vector(self, x: Array) -> Array:
        """The entries of the residual that are compared; large where one is not finite."""
        values = self.at_values(x)
        if values.size == 1:
            return np.full(len(self.compared), WORST)
        found = values.ravel()[self.compared]
        return np.where(np.isfinite(found), np.clip(found, -WORST, WORST), WORST)

    @cached_property
    def compared(self) -> Array:
        """Places of the residual that are numbers for some values: it is NaN where there is no output to compare."""
        rng = np.random.default_rng(1)
        for _ in range(20):
            values = self.at_values(rng.uniform(0.2, 0.8, len(self.names)))
            if values.size > 1:
                return np.flatnonzero(~np.isnan(values.ravel()))
        return np.zeros(0, np.int64)

    @property
    def guesses(self) -> Iterator[Array]:
        """The values that the scheme has, then some of the intervals."""
        yield np.array([float(self.scheme.parameters[name]) for name in self.names])
        rng = np.random.default_rng(0)
        low, high = (np.array(x) for x in zip(*(self._interval(name) for name in self.names), strict=True))
        for _ in range(TRIES - 1):
            yield rng.uniform(low, high)

    def _interval(self, name: str) -> tuple[float, float]:
        info = self.scheme.info.parameters[name]
        low = 0.0 if info.low is None else info.low
        return low, low + 1.0 if info.high is None else info.high

    def least(self, x0: Array, ftol: float) -> Any:
        """The solution of least squares from a start, ended by that relative decrease of the squares."""
        from scipy.optimize import least_squares  # noqa: PLC0415 (slow to import)

        return least_squares(self.vector, x0, method="lm", xtol=1e-15, ftol=ftol, gtol=1e-15, max_nfev=40 * len(x0))

    def measured(self, solution: Any) -> Fitted:
        """A solution of least squares as it is."""
        error = largest(self.at_values(solution.x))
        unsure = SURE * error * float(np.sqrt(np.diag(np.linalg.pinv(solution.jac.T @ solution.jac)).max()))
        return Fitted(self.of(solution.x), error, unsure)

    def recognised(self, solution: Any) -> Fitted:
        """At simple numbers near a solution of least squares where the residual is no larger there, else at it."""
        found = self.measured(solution)
        for tolerance in (max(FLAT, found.unsure), max(1e-9, found.unsure)):
            exact = self.simple(solution.x, tolerance)
            there = largest(self.at_values(exact))
            if there <= 3.0 * found.error + EXACT:
                return Fitted(self.of(exact), there, found.unsure)
        return found

    def simple(self, x: Array, tolerance: float) -> Array:
        """The simple numbers within a tolerance; a parameter's default where that is near and irrational."""
        near = dict(self.scheme.parameters)
        for name, value in zip(self.names, x.tolist(), strict=True):
            default = default_of(self.scheme, name, near)
            simple, text = recognise(value, tolerance)
            follows = default is not None and abs(default - value) <= tolerance and not rational(text)
            near[name] = np.float64(default if follows else simple)
        return np.array([float(near[name]) for name in self.names])


def largest(residual: Array) -> float:
    """The largest modulus; infinite where nothing could be compared."""
    known = residual[~np.isnan(residual)]
    return float(np.abs(known).max()) if known.size else np.inf


def default_of(scheme: Scheme, name: str, values: Mapping[str, Any]) -> float | None:
    """What a parameter is by default, given those before it; None for one that has none."""
    parameters = scheme.info.parameters
    earlier = {key: values[key] for key in list(parameters)[: list(parameters).index(name)]}
    try:
        with np.errstate(all="ignore"):
            default = float(parameters[name].default_of(scheme.name, earlier))
    except ValueError:
        return None
    return default if np.isfinite(default) else None


def described(scheme: Scheme, unsure: float = 0.0) -> str:
    """The scheme with its parameters as exact numbers, by the argument of a family where there is one.

    Such as newmark(beta = 1/4, gamma = 1/2); a parameter that is the root that it is by default is left out. unsure: by
    how much the parameters may be off, beyond which no digits are written.
    """
    values = {name: recognise(x, 1e-8)[1] for name, x in family_of(scheme).items()}
    if not values:
        for name in free_parameters(scheme):
            x = float(scheme.parameters[name])
            text, default = number(x, unsure), default_of(scheme, name, scheme.parameters)
            if rational(text) or default is None or abs(default - x) > 1e-9:
                values[name] = text
    inner = ", ".join(f"{name} = {value}" for name, value in values.items())
    return f"{scheme.name}({inner})" if inner else scheme.name


def stated(scheme: Scheme) -> str:
    """The scheme with the values that were given for it, and no other."""
    if set(scheme.given) == set(scheme.parameters):
        return described(scheme)
    inner = ", ".join(f"{name} = {recognise(float(x), 1e-9)[1]}" for name, x in scheme.given.items())
    return f"{scheme.name}({inner})" if inner else scheme.name


def family_of(scheme: Scheme) -> dict[str, float]:
    """The argument of a family that gives the parameters the values they have; empty where there is none.

    Those that the family does not name have then their defaults.
    """
    from scipy.optimize import least_squares  # noqa: PLC0415 (slow to import)

    for argument, family in scheme.info.families.items():

        def off(x: Array, values: Mapping[str, Any] = family.values) -> Array:
            return np.array(
                [float(function(x[0])) - float(scheme.parameters[name]) for name, function in values.items()]
            )

        found = least_squares(off, [0.5], xtol=1e-15, ftol=1e-15, gtol=1e-15)
        low, high = family.argument.low or 0.0, 1.0 if family.argument.high is None else family.argument.high
        others = [name for name in free_parameters(scheme) if name not in family.values]
        defaults = [default_of(scheme, name, scheme.parameters) for name in others]
        follow = all(
            x is not None and abs(x - float(scheme.parameters[name])) <= 1e-8
            for name, x in zip(others, defaults, strict=True)
        )
        if follow and np.abs(found.fun).max() <= 1e-8 and low - 1e-8 <= found.x[0] <= high + 1e-8:
            return {argument: float(found.x[0])}
    return {}


def number(x: float, unsure: float) -> str:
    """An exact number as such, and another one to the digits that are sure."""
    text = recognise(x, 1e-9)[1]
    digits = 12 if unsure <= 0.0 else math.floor(math.log10(abs(x) / unsure)) + 1 if abs(x) > unsure else 1
    return text if simple(text) else f"{x:.{min(12, digits)}g}"


def rational(text: str) -> bool:
    """Whether a recognised number is a rational one."""
    return all(character in "-/0123456789" for character in text)


def simple(text: str) -> bool:
    """Whether a recognised number is a rational one or a known root."""
    return rational(text) or text in IRRATIONAL


def recognise(x: float, tolerance: float) -> tuple[float, str]:
    """The simplest rational number with a denominator up to 1000 near x, or a known root, and its text; else x."""
    for limit in (1, 2, 3, 4, 5, 6, 8, 9, 10, 12, 16, 20, 25, 50, 100, 250, 500, 1000):
        near = Fraction(x).limit_denominator(limit)
        if abs(float(near) - x) <= tolerance:
            return float(near), str(near)
    for text, value in IRRATIONAL.items():
        if abs(value - x) <= tolerance:
            return value, text
    return x, f"{x:.12g}"
