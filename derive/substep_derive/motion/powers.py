"""EquationsOfMotion -> the power of what gives energy to a scene or takes it."""

from sympy import Expr, Integer, sympify

from ..declare.symbols import t
from .equations import EquationsOfMotion


def powers(motion: EquationsOfMotion) -> dict[str, Expr]:
    """The power of each, by name, in coordinates, rates and t; reactions and laws apart, and those that are 0.

    Forces and loads are each by themselves, `forces x` and `load x` on the coordinate x. Of time it is that of energies
    which hold it: with T_k of degree k in the rates, T_2 - T_0 + V changes by d(V - T)/dt at fixed coordinates and
    rates. Where the kinetic energy or the potential holds time, `frame` is T_1 + 2 T_0, by which the energy that is
    reported, T + V, is beyond that.
    """
    scene, v = motion.scene, motion.scene.rates
    T, V = motion.kinetic, motion.potential_energy
    at_rest = dict.fromkeys(v, Integer(0))
    linear = sum((T.diff(r).subs(at_rest) * r for r in v), Integer(0))
    pairs = list(zip(motion.coordinates, v, strict=True))
    given = {"forces": scene.forces, "load": scene.load}
    found = {
        "dissipation": -sum((scene.dissipation.diff(r) * r for r in v), Integer(0)),
        **{f"{kind} {q}": sympify(on.get(q, 0)) * r for kind, on in given.items() for q, r in pairs},
        "time": (V - T).diff(t),
        "frame": linear + 2 * T.subs(at_rest) if motion.of_time else Integer(0),
    }
    return {name: e for name, e in found.items() if e != 0}
