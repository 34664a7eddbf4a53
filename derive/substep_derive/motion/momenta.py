"""Noether's theorem: the momenta of the rigid motions of coordinates that leave the Lagrangian as it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from sympy import Expr, Integer, Matrix, Symbol, factor_terms, ilcm, sign

from ..declare.symbols import rate

ANGULAR = "kg m^2/s"


@dataclass(frozen=True)
class Momentum:
    """One of Noether's invariants and its unit. name: what is moved, as `x`, or `x y` of the rotation of a plane."""

    name: str
    expression: Expr
    unit: str

    @property
    def angular(self) -> bool:
        """Whether the motion turns: it rotates a plane or shifts an angle."""
        return self.unit == ANGULAR


def momenta(coordinates: Mapping[Symbol, str], lagrangian: Expr, kept: Sequence[Expr]) -> list[Momentum]:
    """One for each independent rotation and translation of the coordinates, the rotations first.

    coordinates: symbol -> unit. lagrangian: of coordinates, rates and time. kept: what the motion has to leave as it is
    besides, such as constraints. A rotation is of the planes of any two coordinates of one unit that is not an angle's,
    the translation one of any coordinates, both with constant rational coefficients. What is sought is
    dq_i = sum of W_ij q_j + d_i with an antisymmetric W and any d; the change of an expression is linear in these, and
    vanishes if the coefficients of its terms do, which gives linear equations for W and d.
    Source: E. Noether, Invariante Variationsprobleme, 1918.
    """
    q = list(coordinates)
    planes = [(a, b) for a, b in combinations(q, 2) if coordinates[a] == coordinates[b] != "rad"]
    moved = [{b: a, a: -b} for a, b in planes] + [{a: Integer(1)} for a in q]
    names = [f"{a} {b}" for a, b in planes] + [str(a) for a in q]
    units = [ANGULAR] * len(planes) + [_unit(coordinates[a]) for a in q]
    found, whole = [], [_with_rates(along) for along in moved]
    for weights in _vanishing([[_change(e, along, e.free_symbols) for along in whole] for e in (lagrangian, *kept)]):
        some = [k for k, w in enumerate(weights) if w]
        total = sum((weights[k] * x * lagrangian.diff(rate(a)) for k in some for a, x in moved[k].items()), Integer(0))
        unit = ANGULAR if any(units[k] == ANGULAR for k in some) else units[some[0]]
        name = " + ".join({1: "", -1: "-"}.get(weights[k], f"{weights[k]} ") + names[k] for k in some)
        found.append(Momentum(name.replace("+ -", "- "), factor_terms(total), unit))
    return found


def _with_rates(along: Mapping[Symbol, Expr]) -> Mapping[Symbol, Expr]:
    """A motion of coordinates, and that of their rates."""
    of_rates = {rate(a): sum((x.diff(c) * rate(c) for c in x.free_symbols), Integer(0)) for a, x in along.items()}
    return {**along, **of_rates}


def _change(e: Expr, along: Mapping[Symbol, Expr], own: set[Symbol]) -> Expr:
    """The change of an expression, which has symbols of its own, with a motion of these."""
    return sum((x * e.diff(a) for a, x in along.items() if a in own), Integer(0)).expand()


def _vanishing(changes: Sequence[Sequence[Expr]]) -> list[list[Expr]]:
    """The independent integers (w_k), the first of them positive, for which each row's sum of w_k e_k vanishes."""
    rows = dict[tuple[Expr, ...], None]()
    for row in changes:
        terms = [e.as_coefficients_dict() for e in row]
        some = dict.fromkeys(x for of in terms for x in of)
        rows |= {tuple(of.get(term, Integer(0)) for of in terms): None for term in some}
    found = []
    for weights in Matrix(list(rows) or [[0] * len(changes[0])]).nullspace():
        first = next(w for w in weights if w)
        found.append(list(weights * ilcm(1, *(w.q for w in weights)) * sign(first)))
    return found


def _unit(of_coordinate: str) -> str:
    return {"rad": ANGULAR, "m": "kg m/s"}.get(of_coordinate, f"J s/{of_coordinate}")
