"""A one-step scheme taken several times with steps of different lengths -> the declaration of their composition."""

from collections.abc import Sequence
from typing import Any

from sympy import Expr, Integer, Symbol

from .entries import LABELS, Entries
from .errors import DeclarationError
from .irrational import generated
from .parameter import Parameter
from .published import Published
from .scheme import Balance, Scheme
from .symbols import f, h, knot, knot_of


def composition(
    name: str,
    base: Scheme,
    weights: Sequence[Any],
    *,
    parameters: tuple[Parameter, ...] = (),
    reference: str = "",
    published: Published | None = None,
) -> Scheme:
    """The scheme whose step consists of steps w_1 h, w_2 h, ... of the base, one after another.

    weights: exact, as entries of `tableau`, with the sum 1; some may be negative. A symmetric base and weights that
    read the same backwards give a symmetric scheme, a symplectic base a symplectic one; where w_1^(p+1) + w_2^(p+1) +
    ... vanishes, the order is one more than the base's p, and even if the composition is symmetric (Hairer, Lubich &
    Wanner, Geometric Numerical Integration (2006), II.4). The base's own parameters stay parameters.

    Raises DeclarationError for weights that are not exact or do not sum to 1, and for a base that is no one-step scheme
    or reports other values than it goes on with.
    """
    start, end = knot(0), knot(1)
    if base.start or base.report or not set(base.state) <= set(start):
        raise DeclarationError(
            f"{name}: expected a one-step scheme to compose, which goes on with the u_1, v_1, a_1 that it reports, got "
            f"{base.name} with the state {', '.join(map(str, base.state))}; compose another one, such as "
            "central_difference"
        )
    parameters, ((weights,),) = generated(name, parameters, ((weights,),))
    entries = Entries(name, parameters, ((weights,),))
    (steps,) = entries.sums("the weights", [entries.vector("weights", weights)], [Integer(1)])
    inner = sorted({(knot_of(s) or ("", ""))[1] for s in base.unknowns} - {"0", "1"})
    relations: dict[Any, Expr] = {}
    balances: list[Balance] = []
    first, begin = start, Integer(0)
    for k, (weight, label) in enumerate(zip(steps, LABELS, strict=False), start=1):
        last = end if k == len(steps) else knot(label)
        named: dict[Symbol, Expr] = dict(zip((*start, *end), (*first, *last), strict=True))
        for other in inner:
            named |= dict(zip(knot(other), knot(f"{label}{other}"), strict=True))
        values: dict[Any, Any] = {**named, h: weight * h}

        def placed(e: Expr, values: dict[Any, Any] = values, begin: Expr = begin, weight: Expr = weight) -> Expr:
            loads = {load: f(begin + weight * load.args[0]) for load in e.atoms(f)}
            return e.subs(values, simultaneous=True).subs(loads, simultaneous=True)

        relations |= {named[symbol]: placed(e) for symbol, e in base.relations.items()}
        balances += [Balance(*map(placed, (b.inertia, b.damping, b.force, b.load))) for b in base.balances]
        first, begin = last, begin + weight
    return Scheme(
        name,
        relations=relations,
        balances=tuple(balances),
        parameters=(*base.parameters, *parameters),
        families=base.families,
        reference=reference,
        published=published,
    )
