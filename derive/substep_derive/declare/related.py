"""A scheme with parameters fixed at numbers or tied to others, so that fewer are free."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from sympy import Expr, Symbol

from .errors import DeclarationError
from .scheme import Scheme


def related(scheme: Scheme, parameters: Mapping[str, Any]) -> Scheme:
    """The scheme with parameters at exact numbers, as expressions in others, or along a family.

    A family is followed by giving its argument as a symbol, rho_inf=Symbol("rho_inf"). Raises DeclarationError as
    `Scheme.fix`, and for an expression in symbols that are no parameters.
    """
    tied = {key: e for key, e in parameters.items() if isinstance(e, Expr) and e.free_symbols}
    fixed = scheme.fix({key: e for key, e in parameters.items() if key not in tied})
    if not tied:
        return fixed
    own = {s.name: s for s in fixed.values}
    families = {family.argument.name: family for family in fixed.families}
    along = [families[key] for key, e in tied.items() if key in families and e == families[key].argument.symbol]
    values = {s: e for family in along for s, e in family.values.items()}
    values |= {own[key]: e.subs(values, simultaneous=True) for key, e in tied.items() if key in own}
    kept = [*(family.argument for family in along), *(p for p in fixed.parameters if p.symbol not in values)]
    allowed = {p.symbol for p in kept}
    reached = {*own, *(family.argument.name for family in along)}
    for key, e in tied.items():
        if key not in reached or not (values.get(own[key], e) if key in own else e).free_symbols <= allowed:
            raise DeclarationError(
                f"{scheme.name}: expected {key} as a number or in terms of {', '.join(sorted(map(str, allowed)))}, "
                f"got {e}; its parameters: {', '.join([*own, *families]) or 'none'}"
            )

    def tie(expressions: Mapping[Symbol, Expr]) -> dict[Symbol, Expr]:
        return {symbol: e.subs(values, simultaneous=True) for symbol, e in expressions.items()}

    return replace(
        fixed,
        parameters=tuple(replace(p, default=p.default.subs(values)) for p in kept),
        families=(),
        relations=tie(fixed.relations),
        start=fixed.start if isinstance(fixed.start, Scheme) else tie(fixed.start),
        report=tie(fixed.report),
        embedded=tie(fixed.embedded),
        balances=tuple(balance.replace(values) for balance in fixed.balances),
        published=None,
        parent=fixed.parent or scheme.name,
    )
