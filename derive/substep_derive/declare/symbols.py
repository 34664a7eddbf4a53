"""The symbols that all declarations and derivations share.

A *knot* is a label with its own displacement u, velocity v and acceleration a. A label is never a
time: Runge-Kutta has two knots at h/2. Labels that are numbers stand for whole steps from t_n
(0, 1, -1, -1/2, ...), and only they are carried over to the next step. What a scheme carries beside u, v and a is an
*auxiliary state*: a second value at such a step, under a name of its own.
"""

from fractions import Fraction
from typing import Any, NamedTuple

from sympy import Expr, Function, Symbol

# time step, natural frequency, Omega = omega*h, damping ratio, amplification-matrix unknowns
h, omega, Omega, xi = (Symbol(name) for name in ("h", "omega", "Omega", "xi"))
lam, mu, z = (Symbol(name) for name in ("lambda", "mu", "z"))
# mass, damping, tangent stiffness at the start (structure-dependent schemes read the three)
M, C, K0 = (Symbol(name) for name in ("M", "C", "K0"))

# parameters of schemes, under the names of their papers
beta, gamma, gamma_t, theta, alpha, alpha_B, alpha_m, alpha_f, rho_inf = (
    Symbol(name)
    for name in (["beta", "gamma", "gamma_t", "theta", "alpha", "alpha_B", "alpha_m", "alpha_f", "rho_inf"])
)
delta, alpha_g, p, phi, beta1, beta2 = (Symbol(name) for name in ["delta", "alpha_g", "p", "phi", "beta1", "beta2"])


# for scenes: the time, and a load that the user gives as a function of time
t, sampled = Symbol("t"), Symbol("f")


def rate(coordinate: Symbol) -> Symbol:
    """The coordinate's velocity."""
    return Symbol(f"{coordinate.name}_dot")


def acceleration(coordinate: Symbol) -> Symbol:
    """The coordinate's acceleration."""
    return Symbol(f"{coordinate.name}_ddot")


NAMED = ":"  # stands in a label before the name of an auxiliary state


class Knot(NamedTuple):
    """Displacement, velocity and acceleration at one knot."""

    u: Symbol
    v: Symbol
    a: Symbol


def knot(label: str | int, name: str = "") -> Knot:
    """The knot of that label: symbols u_label, v_label, a_label.

    name: makes them auxiliary states at the step of that number. knot(0, "rate").v and knot(1, "rate").v are a second
    velocity at t_n and at t_n + h, which the next step reads as its own at t_n.
    """
    at = f"{label}{NAMED}{name}" if name else label
    return Knot(*(Symbol(f"{kind}_{at}") for kind in "uva"))


def knot_of(symbol: Symbol) -> tuple[str, str] | None:
    """(kind, label) of a knot's symbol, None for any other symbol."""
    kind, _, label = symbol.name.partition("_")
    return (kind, label) if label and kind in ("u", "v", "a") else None


def lattice(label: str) -> Fraction | None:
    """The label as a number of steps from t_n, None for a sub-step's or stage's label."""
    try:
        return Fraction(label.partition(NAMED)[0])
    except ValueError:
        return None


def kind_of(symbol: Symbol) -> int:
    """0, 1, 2 for a displacement, velocity, acceleration."""
    return "uva".index((knot_of(symbol) or ("u", ""))[0])


def steps_back(symbol: Symbol) -> Fraction:
    """How many steps before t_n the symbol of a state stands: 1 for u_-1, 1/2 for v_-1/2."""
    return -(lattice((knot_of(symbol) or ("", "0"))[1]) or Fraction(0))


def successor(symbol: Symbol) -> Symbol:
    """The symbol of the same kind one step later: u_0 for u_-1, v_1/2 for v_-1/2."""
    return shifted(symbol, 1)


def shifted(symbol: Symbol, steps: int) -> Symbol:
    """The symbol of the same kind, and of the same name, that many steps later."""
    kind, label = knot_of(symbol) or ("", "")
    _, *name = label.split(NAMED)
    return getattr(knot(str((lattice(label) or 0) + steps), *name), kind)


def auxiliary(symbol: Symbol) -> str:
    """The name of an auxiliary state, empty for a knot's own u, v or a."""
    return (knot_of(symbol) or ("", ""))[1].partition(NAMED)[2]


def state_label(symbol: Symbol) -> str:
    """'u', 'h*v', 'h^2*a', or the name in place of the letter, with the step in brackets for one of an earlier step."""
    kind, label = knot_of(symbol) or ("", "")
    step, _, name = label.partition(NAMED)
    scaled = {"u": "", "v": "h*", "a": "h^2*"}[kind] + (name or kind)
    return scaled if step == "0" else f"{scaled}[{step}]"


class K_t(Function):
    """Tangent stiffness: the derivative of the internal force."""

    nargs = 1


class N(Function):
    """Internal force as a function of the displacement (or of a mixture of displacements)."""

    nargs = 1

    def fdiff(self, argindex: Any = 1) -> Expr:
        """The tangent stiffness."""
        return K_t(self.args[0])


class N_discrete(Function):
    """Discrete gradient of the strain energy between two displacements."""

    nargs = 2


class N_of_rates(Function):
    """Internal force as a function of the displacement and the velocity."""

    nargs = 2


class f(Function):
    """External load at t_n + tau*h, as a function of tau."""

    nargs = 1
