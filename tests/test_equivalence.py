"""Equivalences that the search has to find, each checked at rational points by its own eigenvalue polynomials."""

import os
from functools import cache
from itertools import product

import pytest
from declared import BY_NAME
from substep_derive import Scheme, derive
from substep_derive.declare.scheme import Balance
from substep_derive.declare.schemes.newmark import average_acceleration
from substep_derive.declare.symbols import Omega, gamma_t, h, knot, lam, rho_inf, xi
from substep_derive.oscillator.spectrum import live
from substep_derive.study.equivalence import MATRIX, SPECTRUM, UNDAMPED, Equivalence, equivalences
from sympy import Poly, Rational, Symbol, resultant, simplify

EXHAUSTIVE = os.environ.get("SUBSTEP_VERIFY") == "1"
half = Rational(1, 2)

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
um, vm, _ = knot(-1)
bdf2 = Scheme(
    "bdf2",
    relations={u1: (4 * u0 - um + 2 * h * v1) / 3, v1: (4 * v0 - vm + 2 * h * a1) / 3},
    balances=(Balance.at(end, 1),),
    start=average_acceleration,
)


@cache
def search(*names: str, steps: tuple[int, ...] = (1,)) -> tuple[Equivalence, ...]:
    return tuple(equivalences([BY_NAME.get(name, bdf2) for name in names], steps=steps))


def kinds(found: tuple[Equivalence, ...], left: str, right: str) -> set[tuple]:
    """(values of left, values of right, kind), whichever way round."""
    same = [(e.left_values, e.right_values, e.kind) for e in found if (e.left, e.right) == (left, right)]
    same += [(e.right_values, e.left_values, e.kind) for e in found if (e.left, e.right) == (right, left)]
    return {(*(tuple(sorted(v.items())) for v in values), kind) for *values, kind in same}


def entry(left: dict, right: dict, kind: str) -> tuple:
    return (*(tuple(sorted((k, Rational(v)) for k, v in values.items())) for values in (left, right)), kind)


QUICK = [
    ("houbolt", "wbz_alpha", entry({}, {"alpha_B": -1}, UNDAMPED)),
    ("bathe", "silva_bezerra", entry({}, {"gamma_t": "1/2"}, MATRIX)),
    ("bathe", "silva_bezerra", entry({}, {"gamma_t": "2/3"}, SPECTRUM)),
    ("bathe", "newmark_bdf2", entry({}, {"gamma_t": "1/2", "beta": "1/4", "gamma": "1/2"}, MATRIX)),
    ("central_difference", "newmark", entry({}, {"beta": 0, "gamma": "1/2"}, MATRIX)),
    ("central_difference", "central_difference_lagged", entry({}, {}, UNDAMPED)),
    ("energy_momentum", "average_acceleration", entry({}, {}, SPECTRUM)),
    ("linear_acceleration", "wilson_theta", entry({}, {"theta": 1}, MATRIX)),
    ("backward_euler", "newmark", entry({}, {"beta": 1, "gamma": "3/2"}, UNDAMPED)),
    ("bdf2", "oalts", entry({}, {"rho_inf": 0}, SPECTRUM)),
]
SLOW = [
    ("houbolt", "generalized_alpha", entry({}, {"rho_inf": 0}, UNDAMPED)),
    ("wbz_alpha", "generalized_alpha", entry({"alpha_B": -1}, {"rho_inf": 0}, MATRIX)),
    ("hht_alpha", "generalized_alpha", entry({"alpha": "-1/3"}, {"rho_inf": "1/2"}, MATRIX)),
    ("bathe", "rho_inf_bathe", entry({}, {"rho_inf": 0, "gamma_t": "1/2"}, MATRIX)),
    ("bathe", "beta1_beta2_bathe", entry({}, {"beta1": "1/3", "beta2": "2/3", "gamma_t": "1/2"}, MATRIX)),
]


@pytest.mark.parametrize(("left", "right", "expected"), QUICK + SLOW * EXHAUSTIVE)
def test_known_pairs(left: str, right: str, expected: tuple) -> None:
    assert expected in kinds(search(left, right), left, right)


@pytest.mark.parametrize("name", ["forward_euler", "rk2", "rk4", "park"])
def test_schemes_of_their_own(name: str) -> None:
    assert not [e for e in search(name, "newmark", "wilson_theta", "houbolt") if name in (e.left, e.right)]


def test_steps_of_half_the_size() -> None:
    found = search("rho_inf_bathe", "noh_bathe", "average_acceleration", "central_difference", steps=(2,))
    two_trapezoids = entry({"rho_inf": 1, "gamma_t": "1/2"}, {}, SPECTRUM)
    assert two_trapezoids in kinds(found, "rho_inf_bathe", "average_acceleration")
    assert entry({"p": "1/2"}, {}, UNDAMPED) in kinds(found, "noh_bathe", "central_difference")
    assert all(e.steps == 2 and "2 steps of h/2" in e.text for e in found)


@pytest.mark.skipif(not EXHAUSTIVE, reason="SUBSTEP_VERIFY=1: takes some seconds")
def test_families_as_functions_of_another() -> None:
    found = search("hht_alpha", "generalized_alpha")
    alpha = Symbol("alpha")
    inclusion = {"alpha_m": 0, "alpha_f": -alpha, "beta": (1 - alpha) ** 2 / 4, "gamma": half - alpha}
    matrices = [e.left_values for e in found if e.kind == MATRIX and e.right_values == {"alpha": alpha}]
    assert any(all(simplify(values[k] - e) == 0 for k, e in inclusion.items()) for values in matrices)


@pytest.mark.skipif(not EXHAUSTIVE, reason="SUBSTEP_VERIFY=1: takes some seconds")
def test_two_splits_with_one_spectrum() -> None:
    """gamma_t -> 2 (1 - gamma_t)/(2 - gamma_t (1 - rho_inf)) keeps the spectrum; its fixed point is the default."""
    (other,) = [e for e in search("silva_bezerra", "rho_inf_bathe") if e.kind == SPECTRUM and e.right_values]
    image = other.left_values["gamma_t"]
    assert simplify(image - 2 * (1 - gamma_t) / (2 - gamma_t)) == 0
    default = BY_NAME["rho_inf_bathe"].parameters[1].default.subs({rho_inf: 0})
    assert simplify(image.subs(gamma_t, default) - default) == 0


@pytest.mark.skipif(not EXHAUSTIVE, reason="SUBSTEP_VERIFY=1: takes some seconds")
def test_beta1_beta2_family_is_the_rho_inf_scheme() -> None:
    found = search("rho_inf_bathe", "beta1_beta2_bathe")
    same = [e for e in found if e.kind == MATRIX and e.right_values == {"rho_inf": rho_inf}]
    assert [e.left_values for e in same] == [{"rho_inf": rho_inf, "gamma_t": half}]


def spectrum(name: str, values: dict, damping: Rational, steps: int) -> Poly:
    """The monic characteristic polynomial of all steps at Omega = 2/3, without roots 0."""
    scheme = BY_NAME.get(name, bdf2)
    made = derive(scheme, **values).scheme
    p = (
        live(derive(made, **{s.name: e for s, e in made.typical.items() if s != made.constant}).charpoly)
        .as_expr()
        .subs({Omega: Rational(2, 3) / steps, xi: damping})
    )
    power = Symbol("power")
    p = Poly(resultant(p, power - lam**steps, lam).subs(power, lam), lam)
    while p.eval(0) == 0:
        p = p.quo(Poly(lam, lam))
    return p.monic()


def values_at_a_point(e: Equivalence) -> tuple[dict, dict]:
    """Both sides' parameters with free ones at some shares of their intervals, at which all are inside."""
    free = sorted(
        {s for values in (e.left_values, e.right_values) for v in values.values() for s in v.free_symbols}, key=str
    )
    # at an end of its interval, what depends on free parameters may be a special case that has more in common
    for ends, shares in product((False, True), product((8, 10, 12, 13, 15, 17, 5), repeat=len(free))):
        if found := values_at(e, {s.name: Rational(k, 20) for s, k in zip(free, shares, strict=True)}, ends=ends):
            return found
    raise AssertionError(f"expected a point inside all intervals, found none: {e.text}")


def values_at(e: Equivalence, shares: dict[str, Rational], *, ends: bool) -> tuple[dict, dict] | None:
    """Both sides' parameters with free ones, by name, at these shares of their intervals, if all are inside.

    ends: what depends on free parameters may be at an end of its interval.
    """
    parameters = [p for name in (e.left, e.right) for p in BY_NAME[name].parameters]
    parameters += [family.argument for name in (e.left, e.right) for family in BY_NAME[name].families]
    point = {
        p.symbol: p.domain.start + shares[p.name] * min(p.domain.end - p.domain.start, 1)
        for p in parameters
        if p.name in shares
    }
    both = []
    for name, values in ((e.left, e.left_values), (e.right, e.right_values)):
        domains = {p.name: p.domain for p in [*(f.argument for f in BY_NAME[name].families), *BY_NAME[name].parameters]}
        both.append({k: v.subs(point) for k, v in values.items()})
        allowed = {k: domains[k] if ends or not v.free_symbols else domains[k].interior for k, v in values.items()}
        if not all(v in allowed[k] for k, v in both[-1].items()):
            return None
    return both[0], both[1]


@pytest.mark.skipif(not EXHAUSTIVE, reason="SUBSTEP_VERIFY=1: the whole catalogue")
def test_everything_found_holds_at_a_point() -> None:
    found = list(equivalences())
    assert len(found) > 80
    for e in found:
        left, right = values_at_a_point(e)
        for damping in (Rational(0), Rational(1, 5)):
            same = spectrum(e.left, left, damping, 1) == spectrum(e.right, right, damping, e.steps)
            assert same == (damping == 0 or e.kind != UNDAMPED), e.text
