"""Oscillators of unit mass with a law: as the spring, of initial stiffness omega^2, or beside a linear one."""

from functools import cache
from typing import Any

from sympy import Integer, Symbol

from ..law import Law
from ..laws.plastic import bilinear
from ..parameter import NOT_NEGATIVE, REAL, Parameter
from ..scene import Scene, optional, required
from ..symbols import omega, rate, sampled, xi

NAME = "hysteretic_oscillator"
u, u0, v0 = (Symbol(name) for name in ("u", "u0", "v0"))
IN_WORDS = {"q_y": "strength", "alpha": "hardening"}  # a law's parameters as they are called here


def _renamed(default: Any, names: dict[Symbol, Symbol]) -> Any:
    return None if default is None else default.subs(names, simultaneous=True)


@cache
def hysteretic_oscillator(law: Law) -> Scene:
    """The oscillator with this law. A law with a parameter k is its spring, k = omega^2; any other acts beside it.

    The law's parameters are the scene's, q_y under the name of strength, m/s^2, and alpha under that of hardening.
    """
    names = {p.symbol: Symbol(IN_WORDS.get(p.name, p.name)) for p in law.parameters}
    own = [Parameter(names[p.symbol], p.domain, _renamed(p.default, names)) for p in law.parameters if p.name != "k"]
    spring = any(p.name == "k" for p in law.parameters)
    values = {p.name: names[p.symbol] for p in law.parameters} | ({"k": omega**2} if spring else {})
    strength = names.get(Symbol("q_y"))
    return Scene(
        NAME if law is bilinear else f"{NAME}_{law.name}",
        coordinates={u: "m"},
        kinetic=rate(u) ** 2 / 2,
        potential=Integer(0) if spring else omega**2 * u**2 / 2,
        dissipation=xi * omega * rate(u) ** 2,
        laws={"spring" if spring else "element": law.on(u, **values)},
        load={u: sampled},
        parameters=(
            required(omega),
            optional(xi, 0, NOT_NEGATIVE),
            *own,
            optional(u0, 0, REAL),
            optional(v0, 0, REAL),
        ),
        start={u: u0, rate(u): v0},
        length=1 if strength is None else strength / omega**2,
        energy_scale=None if strength is None else strength**2 / omega**2 / 2,
        reference=f"per unit mass: {law.reference}",
    )


yielding = hysteretic_oscillator(bilinear)

ALL = (yielding,)
