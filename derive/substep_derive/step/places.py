"""Balance -> at which displacements and velocities it takes the equation of motion, if forces depend on rates."""

from dataclasses import dataclass, replace

from sympy import Dummy, Expr, Integer, Symbol, cancel, factor

from ..declare.symbols import N, N_discrete, knot, knot_of


@dataclass(frozen=True)
class Place:
    """Where a balance takes the equation of motion, with that weight: its force, displacement and velocity."""

    weight: Expr
    force: Expr
    u: Expr
    v: Expr


def places(force: Expr, damping: Expr) -> tuple[list[Place], bool]:
    """The places of the force of a balance, and whether their velocities are, by the weights, what C multiplies.

    The velocity is what C multiplies or, where the force is taken at several displacements, that of their knots.
    """
    marks: dict[Expr, Dummy] = {atom: Dummy() for atom in sorted(force.atoms(N, N_discrete), key=str)}
    marked = force.subs(marks)
    weights = {atom: factor(marked.diff(mark)) for atom, mark in marks.items()}
    found = [
        Place(weight, atom, sum(atom.args, Integer(0)) / len(atom.args), damping / weight)
        for atom, weight in weights.items()
    ]
    if len(found) == 1:
        return found, True
    at_knots = [replace(place, v=_velocity(place.u)) for place in found]
    same = cancel(sum((place.weight * place.v for place in at_knots), Integer(0)) - damping) == 0
    return (at_knots if same else found), same


def _velocity(u: Expr) -> Expr:
    """The velocity of the knots of a displacement."""
    at = {s: knot_of(s) for s in u.free_symbols if isinstance(s, Symbol)}
    return u.subs({s: knot(found[1]).v for s, found in at.items() if found and found[0] == "u"}, simultaneous=True)
