"""Local errors and their estimates in numbers: a scheme stepped with mpmath, held against the exact motion."""

from collections.abc import Callable, Mapping
from typing import Any

import mpmath
from declared import for_oracle
from declared_steps import Array, Marcher, System, exact, oscillator, vector
from oracle import entry
from substep_derive import Estimator, Scheme
from substep_derive.algebra.algebraic import generator
from substep_derive.algebra.constant import approximated
from substep_derive.declare.symbols import h, knot_of, lattice
from sympy import Expr, Rational, Symbol, lambdify


class Oscillation:
    """u'' + c u' + k u = f with f = amplitude*cos(rate*t), and its exact motion from u, v at any time."""

    def __init__(self, xi: Any, amplitude: Any, rate: Any = "17/10") -> None:
        self.omega, self.xi, self.rate = mpmath.mpf(1), mpmath.mpf(xi), mpmath.mpf(rate)
        self.amplitude = mpmath.mpf(amplitude)
        self.c, self.k = 2 * self.xi * self.omega, self.omega**2
        self.system = oscillator(self.c, self.k, load=self.load)

    def load(self, t: Any) -> Any:
        return self.amplitude * mpmath.cos(self.rate * t)

    def forced(self, t: Any) -> tuple[Any, Any]:
        """The steady response."""
        z = self.amplitude * mpmath.expj(self.rate * t) / (self.k - self.rate**2 + 1j * self.c * self.rate)
        return z.real, (1j * self.rate * z).real

    def after(self, u: Any, v: Any, t: Any, dt: Any) -> tuple[Any, Any]:
        """u, v at t + dt from u, v at t."""
        (p0, q0), (p1, q1) = self.forced(t), self.forced(t + dt)
        x, y, w = u - p0, v - q0, self.omega * mpmath.sqrt(1 - self.xi**2)
        decay, a = mpmath.exp(-self.c / 2 * dt), (y + self.c / 2 * x) / w
        cos, sin = mpmath.cos(w * dt), mpmath.sin(w * dt)
        free = decay * (x * cos + a * sin)
        rate = decay * w * (a * cos - x * sin) - self.c / 2 * free
        return p1 + free, q1 + rate


def evaluated(e: Expr, values: Mapping[Symbol, Any]) -> Any:
    symbols = sorted(e.free_symbols, key=str)
    return lambdify(symbols, e, modules="mpmath")(*(values[s] for s in symbols))


def _in_numbers(scheme: Scheme, error: Expr) -> Expr:
    """An estimate with rational numbers near those of the scheme's constant's field."""
    if scheme.constant is None:
        return error
    return approximated((error.subs(generator, scheme.constant) * h**2).expand()) / h**2


def settled(scheme: Scheme, parameters: dict[str, Rational], motion: Oscillation, dt: Any, steps: int) -> list[Any]:
    """The state after some steps from rest in the middle of the motion, by which other modes have died out."""
    name, given = for_oracle(scheme, parameters)
    step = entry(name).step
    kinds = [knot_of(s) or ("u", "0") for s in scheme.state]
    state = []
    for kind, label in kinds:  # scaled by powers of h, as the oracle's
        t = exact(lattice(label)) * dt
        u, v = motion.after(mpmath.mpf(1), mpmath.mpf("0.3"), 0, t)
        a = motion.load(t) - motion.c * v - motion.k * u
        state.append({"u": u, "v": dt * v, "a": dt**2 * a}[kind])
    numbers = {key: exact(value) for key, value in given.items()}
    for n in range(steps):
        at = n * dt
        state, _ = step(
            state, motion.omega * dt, motion.xi, numbers, lambda tau, at=at: dt**2 * motion.load(at + tau * dt)
        )
    return [value / dt ** "uva".index(kind) for value, (kind, _) in zip(state, kinds, strict=True)]


@mpmath.workdps(40)
def ratios(
    scheme: Scheme,
    parameters: dict[str, Rational],
    estimates: Estimator,
    motion: Oscillation,
    dt: Any,
    steps: int,
    kappa: Any = 1,
) -> tuple[Any, Any]:
    """Estimate/true local error of u and of v, on one step from a settled state.

    An estimate of the second value's error is that value less the first, so that it is divided by the two together.
    """
    dt = exact(dt)
    state = dict(zip(scheme.state, map(vector, settled(scheme, parameters, motion, dt, steps)), strict=True))
    marcher = marcher_of(scheme, parameters, motion.system, dt)
    shorter = marcher_of(scheme, parameters, motion.system, exact(kappa) * dt)
    symbols = two_steps(marcher, state, steps * dt, motion.after, shorter)
    if any("halved" in s.name for s in (estimates.u + estimates.v).free_symbols):
        symbols |= halved(marcher, parameters, symbols, (steps + 1) * dt)
    found = []
    for estimate, key in ((estimates.displacement, "u"), (estimates.velocity, "v")):
        size, error = evaluated(_in_numbers(scheme, estimate.error), symbols), symbols[key]
        found.append(size / (error + size if estimate.of.startswith("the second") else error))
    return found[0], found[1]


def marcher_of(scheme: Scheme, parameters: Mapping[str, Rational], system: System, dt: Any) -> Marcher:
    """Steps of dt on one degree of freedom whose tangent is taken at u = 1."""
    return Marcher(scheme, {Symbol(name): exact(x) for name, x in parameters.items()}, system, dt, vector(1))


def two_steps(
    marcher: Marcher,
    state: Mapping[Symbol, Array],
    t: Any,
    after: Callable[..., tuple[Any, Any]],
    opening: Marcher | None = None,
) -> dict[Any, Any]:
    """All symbols of the second of two steps from a state, those of the first with labels of the step before.

    Under "u" and "v" the second step's local errors. opening: makes the first step, of another length.
    """
    dt, opening = marcher.h, opening or marcher
    first = opening.step(state, t)
    begin = opening.reported(first, t)[:2]
    state, t = opening.after(first), t + opening.h
    second = marcher.step(state, t)
    end = marcher.reported(second, t)[:2]
    found: dict[Any, Any] = {}
    for symbol, value in first.items():
        kind, label = knot_of(symbol) or ("", "")
        step = lattice(label)
        found[Symbol(f"{kind}_{step - 1}" if step is not None else f"{kind}_*{label}-1")] = value
    found |= second
    found |= {Symbol("u_*end"): end[0], Symbol("v_*end"): end[1]}
    found[Symbol("a_*end")] = marcher.system.acceleration(*end, t + dt)
    found[Symbol("a_*start")] = marcher.system.acceleration(*begin, t)
    found = {symbol: x[0] for symbol, x in found.items()}
    found |= {h: dt, Symbol("kappa"): opening.h / dt, **dict(zip(marcher.names, marcher.values[1:], strict=True))}
    true = after(begin[0][0], begin[1][0], t, dt)
    return found | {"u": end[0][0] - true[0], "v": end[1][0] - true[1]}


def halved(marcher: Marcher, parameters: Mapping[str, Rational], symbols: Mapping[Any, Any], t: Any) -> dict:
    """u, v after two steps of half the marcher's length, from the same state."""
    half = marcher_of(marcher.scheme, parameters, marcher.system, marcher.h / 2)
    middle = half.after(half.step({s: vector(symbols[s]) for s in marcher.state}, t))
    u, v, _ = half.reported(half.step(middle, t + half.h), t + half.h)
    return {Symbol("u_*halved"): u[0], Symbol("v_*halved"): v[0]}
