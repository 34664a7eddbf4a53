"""What is derived about the thesis, as text of generated/facts.py, so that no run has to derive it."""

import hashlib
from collections.abc import Mapping
from typing import Any

from substep_derive.declare.symbols import xi
from substep_derive.emit.facts_module import literal
from substep_derive.emit.printing import fill
from substep_derive.emit.templates.scheme import BANNER
from substep_derive.study.derivation import derive

from .findings import JUDGES
from .printed import compared, newmark_sets, splits

FACTS = '''"""Derived facts about the thesis, as plain data, so that no run has to derive them.

SPLITS, NEWMARK_SETS: gamma_t of the thesis's figures 4.1 to 4.5, and (beta, gamma) of its Table 4.1. PROPERTIES: these
sets and Bathe's scheme, as (scheme, "parameter=value", ...), sorted -> rho_inf, order, and the first term of numerical
damping and of period error at small Omega as (power, coefficient), undamped; None for an error that is 0. FINDINGS: id
of a claim of the thesis that algebra alone judges -> whether each part of it holds, and the evidence.
"""

{values}
'''


def facts_module() -> str:
    """Text of the module: values of numbers and texts alone, a table's row on each line."""
    facts = {
        "SPLITS": tuple(map(str, splits)),
        "NEWMARK_SETS": tuple(tuple(map(str, pair)) for pair in newmark_sets),
        "PROPERTIES": {
            (name, *sorted(f"{key}={value}" for key, value in parameters.items())): properties(name, parameters)
            for name, parameters in compared
        },
        "FINDINGS": {key: judge() for key, judge in JUDGES.items()},
    }
    text = fill(FACTS, values="\n".join(f"{name} = {literal(value)}" for name, value in facts.items()))
    return fill(BANNER, source=__name__, digest=hashlib.sha256(text.encode()).hexdigest()) + text


def properties(name: str, parameters: Mapping[str, Any]) -> dict[str, Any]:
    """rho_inf, order of the free vibration, and the first term (power of Omega, coefficient) of each error, undamped.

    Exact values as text; None for an error that is 0.
    """
    d = derive(name, **parameters)

    def first(terms: Mapping[int, Any]) -> tuple[int, str] | None:
        values = ((power, coefficient.subs(xi, 0)) for power, coefficient in sorted(terms.items()))
        return next(((power, str(value)) for power, value in values if value != 0), None)

    return {
        "rho_inf": str(d.rho_inf),
        "order": d.series.order,
        "damping": first(d.series.numerical_damping),
        "period": first(d.series.period_error),
    }
