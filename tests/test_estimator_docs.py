"""The table of docs/estimators.md, held against what is derived."""

import re
from pathlib import Path

import pytest
from declared import BY_NAME, NAMES
from substep_derive import derive
from substep_derive.study.estimates import shown
from sympy import Expr, Symbol, factor

PAGE = Path(__file__).parents[1] / "docs" / "estimators.md"


def formula(name: str, error: Expr) -> str:
    """With steps of equal length; weights of a scheme with a constant in digits."""
    if BY_NAME[name].constant is not None:
        return f"`{shown(BY_NAME[name], error)}`"
    return f"`{factor(error.subs(Symbol('kappa'), 1))}`"


def row(name: str) -> str:
    """The scheme's line of the table."""
    found = derive(name).estimator
    needs = ", ".join(f"`{s}`" for s in sorted(found.extra or (), key=str)) or "–"
    growth = f"{found.displacement.growth}, {found.velocity.growth}"
    order = f"{found.order[0]}, {found.order[1]}"
    return f"| `{name}` | {order} | {formula(name, found.u)} | {formula(name, found.v)} | {needs} | {growth} |"


@pytest.mark.parametrize("name", NAMES)
def test_the_table_holds_what_is_derived(name: str) -> None:
    assert row(name) in PAGE.read_text(encoding="utf-8").splitlines()


def test_the_table_has_no_other_lines() -> None:
    listed = re.findall(r"^\| `(\w+)` \|", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    assert listed == list(NAMES)
