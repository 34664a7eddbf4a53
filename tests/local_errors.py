"""Local errors and their estimates in numbers: a scheme stepped with mpmath, held against the exact motion."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from declared import for_oracle
from oracle import entry
from stepping import MP, Problem, Stepper, _mpf
from substep_derive import Estimator, N, N_discrete, Scheme
from substep_derive.algebra.algebraic import generator
from substep_derive.algebra.constant import approximated
from substep_derive.declare.symbols import h, knot_of, lattice
from sympy import Expr, Rational, Symbol, lambdify

u0, v0 = Symbol("u_0"), Symbol("v_0")


class Oscillation:
    """u'' + c u' + k u = f with f = amplitude*cos(rate*t), and its exact motion from u, v at any time."""

    def __init__(self, xi: Any, amplitude: Any, rate: Any = "17/10") -> None:
        self.omega, self.xi, self.rate = MP.mpf(1), _mpf(xi), _mpf(rate)
        self.amplitude = _mpf(amplitude)
        self.c, self.k = 2 * self.xi * self.omega, self.omega**2
        self.problem = Problem(self.c, lambda u: self.k * u, lambda u: self.k, self.load)

    def load(self, t: Any) -> Any:
        return self.amplitude * MP.cos(self.rate * t)

    def forced(self, t: Any) -> tuple[Any, Any]:
        """The steady response."""
        z = self.amplitude * MP.expj(self.rate * t) / (self.k - self.rate**2 + 1j * self.c * self.rate)
        return z.real, (1j * self.rate * z).real

    def after(self, u: Any, v: Any, t: Any, dt: Any) -> tuple[Any, Any]:
        """u, v at t + dt from u, v at t."""
        (p0, q0), (p1, q1) = self.forced(t), self.forced(t + dt)
        x, y, w = u - p0, v - q0, self.omega * MP.sqrt(1 - self.xi**2)
        decay, a = MP.exp(-self.c / 2 * dt), (y + self.c / 2 * x) / w
        cos, sin = MP.cos(w * dt), MP.sin(w * dt)
        free = decay * (x * cos + a * sin)
        rate = decay * w * (a * cos - x * sin) - self.c / 2 * free
        return p1 + free, q1 + rate


def evaluated(e: Expr, values: Mapping[Symbol, Any]) -> Any:
    symbols = sorted(e.free_symbols, key=str)
    return lambdify(symbols, e, modules=MP)(*(values[s] for s in symbols)) if symbols else MP.mpf(int(e))


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
        t = _mpf(lattice(label)) * dt
        u, v = motion.after(MP.mpf(1), MP.mpf("0.3"), 0, t)
        a = motion.load(t) - motion.c * v - motion.k * u
        state.append({"u": u, "v": dt * v, "a": dt**2 * a}[kind])
    numbers = {key: _mpf(value) for key, value in given.items()}
    for n in range(steps):
        at = n * dt
        state, _ = step(
            state, motion.omega * dt, motion.xi, numbers, lambda tau, at=at: dt**2 * motion.load(at + tau * dt)
        )
    return [value / dt ** "uva".index(kind) for value, (kind, _) in zip(state, kinds, strict=True)]


def with_mean_force(scheme: Scheme) -> Scheme:
    """The scheme with the mean of two forces for a discrete gradient, which it is on a linear problem."""
    mean = [replace(b, force=b.force.replace(N_discrete, lambda u, w: (N(u) + N(w)) / 2)) for b in scheme.balances]
    return replace(scheme, balances=tuple(mean))


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
    dt = _mpf(dt)
    scheme = with_mean_force(scheme)
    state = settled(scheme, parameters, motion, dt, steps)
    stepper = Stepper(scheme, parameters, motion.problem, dt, state[0])
    shorter = Stepper(scheme, parameters, motion.problem, _mpf(kappa) * dt, state[0])
    symbols = two_steps(stepper, state, steps * dt, motion.problem, motion.after, shorter)
    if any("halved" in s.name for s in (estimates.u + estimates.v).free_symbols):
        before = [symbols[s] for s in scheme.state]
        symbols |= halved(scheme, parameters, motion.problem, before, (steps + 1) * dt, dt)
    found = []
    for estimate, key in ((estimates.displacement, "u"), (estimates.velocity, "v")):
        size, error = evaluated(_in_numbers(scheme, estimate.error), symbols), symbols[key]
        found.append(size / (error + size if estimate.of.startswith("the second") else error))
    return found[0], found[1]


def two_steps(
    stepper: Stepper,
    state: list[Any],
    t: Any,
    problem: Problem,
    after: Callable[..., tuple[Any, Any]],
    opening: Stepper | None = None,
) -> dict[Any, Any]:
    """All symbols of the second of two steps from a state, those of the first with labels of the step before.

    Under "u" and "v" the second step's local errors. opening: makes the first step, of another length.
    """
    dt, opening = stepper.h, opening or stepper
    first = opening.step(state, t)
    begin = opening.reported(first, t)[:2]
    state, t = opening.carried(first), t + opening.h
    second = stepper.step(state, t)
    end = stepper.reported(second, t)[:2]
    exact = after(*begin, t, dt)
    found = {h: dt, Symbol("kappa"): opening.h / dt, **stepper.values}
    for symbol, value in first.items():
        kind, label = knot_of(symbol) or ("", "")
        step = lattice(label)
        found[Symbol(f"{kind}_{step - 1}" if step is not None else f"{kind}_*{label}-1")] = value
    found |= second
    found |= {Symbol("u_*end"): end[0], Symbol("v_*end"): end[1]}
    found[Symbol("a_*end")] = problem.acceleration(*end, t + dt)
    found[Symbol("a_*start")] = problem.acceleration(*begin, t)
    return found | {"u": end[0] - exact[0], "v": end[1] - exact[1]}


def halved(
    scheme: Scheme, parameters: dict[str, Rational], problem: Problem, state: list[Any], t: Any, dt: Any
) -> dict:
    """u, v after two steps of dt/2."""
    stepper = Stepper(scheme, parameters, problem, dt / 2, state[0])
    middle = stepper.carried(stepper.step(state, t))
    u, v, _ = stepper.reported(stepper.step(middle, t + dt / 2), t + dt / 2)
    return {Symbol("u_*halved"): u, Symbol("v_*halved"): v}
