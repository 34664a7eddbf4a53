"""Which cases `make test` and `make verify` run: see tests/conftest.py."""

from pathlib import Path

import pytest
from conftest import DRAWN, draw, in_gate, with_one_of_each, without_products
from declared import NAMES
from plain_kernels import SCENE_BY_NAME, gate_pairs, kinds

ROOT = Path(__file__).parents[1]


def test_the_gate_leaves_no_scheme_and_no_test_out() -> None:
    """Each test meets one scheme of every third kind, each scheme some tests; what names no scheme is always run."""
    assert tuple(kinds()) == NAMES
    functions = [f"tests/test_{k}.py::test_{k}" for k in range(2000)]
    every = list(dict.fromkeys(kinds().values()))
    for function in functions:
        run = [name for name in NAMES if in_gate(function, [name, "elastic_pendulum"], kinds())]
        found = sorted(every.index(kinds()[name]) for name in run)
        assert found in [[*range(first, len(every), 3)] for first in range(3)]
        assert in_gate(function, ["elastic_pendulum"], kinds())
    assert all(any(in_gate(function, [name], kinds()) for function in functions) for name in NAMES)


def test_pairs_of_the_gate_have_every_scheme_and_every_scene() -> None:
    schemes, scenes = zip(*gate_pairs(), strict=True)
    assert set(schemes) == set(NAMES)
    assert set(scenes) >= set(SCENE_BY_NAME)


def test_no_test_of_schemes_is_left_out_whatever_the_kinds_of_these_are() -> None:
    cases = ["a[x]", "a[y]", "b[x]", "b[y]", "c[x]", "d"]
    chosen = with_one_of_each(cases, [False, True, False, False, False, True], {"c[x]"})
    assert [case for case, run in zip(cases, chosen, strict=True) if run] == ["a[y]", "b[x]", "d"]


def test_schemes_and_what_else_a_test_is_of_are_all_run_but_not_each_with_each() -> None:
    product = [("a", scheme, other) for scheme in "xyz" for other in "1234"]
    cases = [*product, ("b", "x", "1"), None, ("b", "x", "2"), None]
    chosen = without_products(cases, [*[True] * 15, False])
    kept = [case for case, run in zip(cases, chosen, strict=True) if run]
    of_a = [case for case in kept if case and case[0] == "a"]
    assert len(of_a) == 4
    assert {case[1] for case in of_a} == set("xyz")
    assert {case[2] for case in of_a} == set("1234")
    assert kept[4:] == [("b", "x", "1"), None, ("b", "x", "2")]
    left_out = [False, *[True] * 14, False]  # is not taken in again
    assert without_products(cases, left_out)[0] is False


def test_verify_draws_cases_of_every_test_and_in_time_all_of_them() -> None:
    """A draw is repeated by its seed, and leaves no test out; other seeds draw other cases."""
    cases = [f"tests/test_a.py::test_many[{k}]" for k in range(100)] + ["tests/test_a.py::test_once"]
    first = draw(cases, "1")
    assert first == draw(cases, "1")
    assert len(first) == DRAWN + 1
    assert "tests/test_a.py::test_once" in first
    assert set().union(*(draw(cases, str(seed)) for seed in range(60))) == set(cases)


@pytest.mark.parametrize("page", ["CONTRIBUTING.md", "docs/commands.md"])
def test_pages_say_how_many_cases_are_drawn(page: str) -> None:
    text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
    assert f"draws {DRAWN} cases of each test" in text
