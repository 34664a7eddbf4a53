"""Symmetric, symplectic, conjugate symplectic: derived verdicts against what is known and against maps by number."""

import re
from dataclasses import replace
from functools import cache
from typing import Any

import mpmath
import numpy as np
import pytest
from declared import BY_NAME, NAMES
from declared_steps import Marcher, System, amplification, exact, oscillator
from nonlinear_systems import defaults
from substep_derive import Balance, Scheme, derive
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.declare.symbols import N, f, h, knot
from substep_derive.nonlinear.nystrom import Nystrom, nystrom
from substep_derive.nonlinear.step import StepSeries
from substep_derive.nonlinear.structure import Structure, structure
from substep_derive.oscillator.evaluation import Evaluation
from sympy import Integer, Rational
from tables import COMPOSITIONS

from substep.derived.facade import order

u0, v0, a0 = knot(0)
u1, v1, a1 = knot(1)
YES, NO, OPEN = True, False, None
# symmetric, symplectic, conjugate symplectic; all others of the catalogue damp or feed the oscillator at their defaults
CATALOGUE = {
    "central_difference": (YES, YES, YES),
    "central_difference_lagged": (YES, YES, YES),
    "newmark": (YES, NO, YES),
    "average_acceleration": (YES, NO, YES),
    "linear_acceleration": (YES, NO, YES),
    "fox_goodwin": (YES, NO, YES),
    **dict.fromkeys(("energy_momentum", "lobatto_iiia3"), (YES, NO, OPEN)),
    # their coefficients are those of the structure
    **dict.fromkeys(("chang", "chen_ricles", "gui_lambda"), (OPEN, OPEN, OPEN)),
    # of two steps; undamped they have the spectrum of the central difference
    **dict.fromkeys(("zhai", "beeman"), (OPEN, OPEN, OPEN)),
}
MEMBERS: list[tuple[str, dict[str, Any], tuple[Any, Any, Any]]] = [
    ("generalized_alpha", {"rho_inf": 1}, (YES, NO, YES)),  # the trapezoidal rule
    ("generalized_alpha_mixed_displacement", {"rho_inf": 1}, (YES, YES, YES)),  # the midpoint rule
    ("hht_alpha", {"alpha": 0}, (YES, NO, YES)),
    ("tchamwa_wielgosz", {"phi": 1}, (NO, YES, YES)),  # the symplectic Euler scheme
    ("rho_inf_bathe", {"rho_inf": 1, "gamma_t": "1/2"}, (YES, NO, YES)),  # two steps of the trapezoidal rule
    ("three_substep", {"rho_inf": 1}, (YES, NO, YES)),  # three
    ("newmark", {"beta": "1/7", "gamma": "1/2"}, (YES, NO, YES)),  # any beta: Kane, Marsden, Ortiz & West (2000)
    ("oalts", {"rho_inf": 1}, (OPEN, OPEN, OPEN)),  # of two steps
]


def composed(weights: list[Rational]) -> Scheme:
    """Velocity Verlet steps of these parts of h, one after another."""
    relations: dict[Any, Any] = {}
    balances, u, v, a, t = [Balance(a0, v0, N(u0), f(0))], u0, v0, a0, Integer(0)
    for k, w in enumerate(weights):
        K, t = knot("abcdefgh"[k]), t + w
        relations |= {K.u: u + w * h * v + (w * h) ** 2 / 2 * a, K.v: v + w * h / 2 * (a + K.a)}
        balances.append(Balance.at(K, t))
        u, v, a = K
    return Scheme("composed", {**relations, u1: u, v1: v}, tuple(balances))


def evaluated(name: str, parameters: dict[str, Any]) -> Evaluation:
    return Evaluation.at(ParameterSet.of(BY_NAME[name], None, parameters))


@cache
def at_defaults(name: str) -> Structure:
    return structure(Evaluation.at_defaults(name))


def held(found: Structure) -> tuple[Any, Any, Any]:
    return found.symmetric.holds, found.symplectic.holds, found.conjugate_symplectic.holds


@pytest.mark.parametrize("name", NAMES)
def test_verdicts_at_the_defaults(name: str) -> None:
    found = at_defaults(name)
    if name in CATALOGUE:
        assert held(found) == CATALOGUE[name]
    elif stated := re.search(r"modulus .*\(omega h\)\^(\d+)", found.symmetric.reason):
        assert held(found) == (NO, NO, NO)
        check_modulus(name, int(stated[1]))
    else:  # it neither damps nor feeds the oscillator; its map is tested below
        assert None not in held(found)[:2]


@mpmath.workdps(40)
def check_modulus(name: str, power: int) -> None:
    """The modulus of the eigenvalues by number: that of the stepped matrix, less 1, falls as the stated power does."""
    scheme, excess = BY_NAME[name], []
    for omega in (Rational(1, 5), Rational(1, 10)) if power < 8 else (1, Rational(1, 2)):
        A = amplification(scheme, defaults(scheme, True), oscillator(0, exact(omega) ** 2)).astype(float)
        pair = max((x for x in np.linalg.eigvals(A) if x.imag > 0), key=abs)
        excess.append(abs(pair) - 1)
    assert np.log2(excess[0] / excess[1]) == pytest.approx(power, abs=0.5), excess


@pytest.mark.parametrize(("name", "parameters", "expected"), MEMBERS, ids=str)
def test_verdicts_of_members(name: str, parameters: dict[str, Any], expected: tuple[Any, Any, Any]) -> None:
    assert held(structure(evaluated(name, parameters))) == expected


def test_general_parameters() -> None:
    """With the parameters as symbols; the coefficient says where the verdict may change."""
    found = derive("newmark").nonlinear
    assert (found.symmetric.holds, found.symplectic.holds, found.conjugate_symplectic.holds) == (NO, NO, NO)
    assert not found.symplectic  # a verdict is true where it holds with a proof
    assert "(1/4 - gamma/2)*(omega h)^2" in found.symplectic.reason
    undamped = derive("newmark", gamma="1/2").nonlinear
    assert (undamped.symmetric.holds, undamped.symplectic.holds, undamped.conjugate_symplectic.holds) == (YES, NO, YES)
    assert "x = u + beta h^2 N(u)" in undamped.conjugate_symplectic.reason


def test_compositions() -> None:
    """A symplectic scheme composed with itself stays so; it is symmetric if the parts of h are."""
    third = Rational(1, 3)
    assert held(structure(Evaluation.at_defaults(composed([third, third, third])))) == (YES, YES, YES)
    uneven = structure(Evaluation.at_defaults(composed([Rational(1, 4), Rational(3, 4)])))
    assert held(uneven) == (NO, YES, YES)
    assert "a step of h and one of -h leave" in uneven.symmetric.reason


def test_forth_and_back_in_trees_is_by_number_what_it_says(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of symmetric schemes nothing is left; of the symplectic Euler scheme -h^2 N(u) in u, up to a higher power."""
    euler = evaluated("tchamwa_wielgosz", {"phi": 1})
    assert "leave (-1)*N[] in u" in structure(euler).symmetric.reason
    for y in POINTS:
        for step, near in ((0.01, 0.2), (0.001, 0.02)):
            there = mapped(euler.scheme, {s: 1.0 for s in euler.values}, y, step)
            left = (mapped(euler.scheme, {s: 1.0 for s in euler.values}, there, -step) - y)[:2]
            assert left == pytest.approx(-(step**2) * force(y[:2]), rel=near)
    monkeypatch.setattr(Nystrom, "permutation_to", lambda self, other: None)
    for name in ("average_acceleration", "energy_momentum", "central_difference_lagged"):
        found = structure(Evaluation.at_defaults(name)).symmetric
        assert (found.holds, found.reason[:28]) == (OPEN, "a step of h and one of -h di")


# --- by number ---------------------------------------------------------------------------------------------


def force(u: Any) -> Any:
    """The gradient of |u|^2 + x^2 y + x^4/4 + x y^3/3."""
    x, y = u
    return np.array([2 * x + 2 * x * y + x**3 + y**3 / 3, 2 * y + x * x + x * y * y])


def tangent(u: Any) -> Any:
    x, y = u
    return np.array([[2 + 2 * y + 3 * x * x, 2 * x + y * y], [2 * x + y * y, 2 + 2 * x * y]])


GAUSS = np.polynomial.legendre.leggauss(4)


def _mean(u: Any, w: Any) -> Any:
    """The mean of the force along the line: a discrete gradient, exact for this potential."""
    return sum(c / 2 * force(u + (1 + s) / 2 * (w - u)) for s, c in zip(*GAUSS, strict=True))


PLANE = System(force, tangent, _mean, np.zeros((2, 2)), lambda t: np.zeros(2))
POINTS = [np.array(p) for p in ([0.3, -0.2, 0.5, 0.7], [-0.4, 0.6, -0.3, 0.2])]


def size(name: str) -> float:
    """A step at which an error of the scheme's order is well above rounding, shorter where parts are longer than it."""
    return 0.2 if max(order(name)) < 5 or name in COMPOSITIONS else 0.8


def mapped(scheme: Scheme, values: Any, y: Any, step: float) -> Any:
    """(u, v) after a step from (u, v), started consistently."""
    marcher = Marcher(scheme, values, PLANE, step, y[:2])
    return np.concatenate(marcher.reported(marcher.step(marcher.started(y[:2], y[2:]), 0.0), 0.0)[:2])


def jacobian(g: Any, y: Any) -> Any:
    """By central differences, extrapolated once; exact to about 1e-11."""
    columns = []
    for e in np.eye(4):
        wide, narrow = ((g(y + d * e) - g(y - d * e)) / (2 * d) for d in (4e-3, 2e-3))
        columns.append((16 * narrow - 4 * wide) / 12)
    return np.array(columns).T


AREA = np.block([[np.zeros((2, 2)), np.eye(2)], [-np.eye(2), np.zeros((2, 2))]])
MAPS = [
    *((name, {}) for name in NAMES),
    *((name, parameters) for name, parameters, expected in MEMBERS if expected[0] is not None),
]


@pytest.mark.parametrize(("name", "parameters"), MAPS, ids=str)
def test_the_map_by_number(name: str, parameters: dict[str, Any]) -> None:
    """Two coordinates, a potential of fourth degree: steps of h and -h; the Jacobian; that of the changed variables."""
    evaluation = evaluated(name, parameters)
    form = nystrom(StepSeries(evaluation))
    if form is None:
        return  # no map of u and v; its eigenvalues are what decides, which is tested above
    scheme = BY_NAME[name]
    values = defaults(scheme, False) | {s: float(x) for s, x in evaluation.values.items() if parameters and x.is_number}
    found = structure(evaluation)
    step = size(name)
    back = max(np.abs(mapped(scheme, values, mapped(scheme, values, y, step), -step) - y).max() for y in POINTS)
    assert (back < 1e-14) == found.symmetric.holds, back
    defect = changed = 0.0
    change = form.symplectic_conjugate()
    xi, eta = (float(evaluation.field.expression(x)) for x in change) if change is not None else (0.0, 0.0)

    def chi(y: Any) -> Any:
        K, eye = tangent(y[:2]), np.eye(2)
        return np.block([[eye + xi * step**2 * K, np.zeros((2, 2))], [eta * step * K, eye]])

    for y in POINTS:
        J = jacobian(lambda x: mapped(scheme, values, x, step), y)
        defect = max(defect, np.abs(J.T @ AREA @ J - AREA).max())
        J = chi(mapped(scheme, values, y, step)) @ J @ np.linalg.inv(chi(y))
        changed = max(changed, np.abs(J.T @ AREA @ J - AREA).max())
    assert (defect < 1e-9) == found.symplectic.holds, defect
    if found.conjugate_symplectic.holds and not found.symplectic.holds:
        assert changed < 1e-9 < defect


@pytest.mark.parametrize("name", ["average_acceleration", "energy_momentum"])
def test_the_determinant_s_first_term(name: str) -> None:
    """On one coordinate, as the counterexample to symplecticity states it: a multiple of h^3 N'' v."""
    stated = re.search(r"h\^3\*\((.*?)\)\)? \+", at_defaults(name).symplectic.reason)
    assert stated is not None
    factor = float(Rational(stated[1].replace("N2*v", "1").replace(")", "")))
    pendulum = System(
        np.sin,
        lambda u: np.diag(np.cos(u)),
        lambda u, w: np.sin((u + w) / 2) * np.sinc((w - u) / 2 / np.pi),
        np.zeros((1, 1)),
        lambda t: np.zeros(1),
    )
    y, excess = np.array([0.6, 0.8]), []
    for step in (0.05, 0.025):

        def after(x: Any, step: float = step) -> Any:
            marcher = Marcher(BY_NAME[name], defaults(BY_NAME[name], False), pendulum, step, x[:1])
            return np.concatenate(marcher.reported(marcher.step(marcher.started(x[:1], x[1:]), 0.0), 0.0)[:2])

        J = np.array([(after(y + 1e-3 * e) - after(y - 1e-3 * e)) / 2e-3 for e in np.eye(2)]).T
        excess.append((np.linalg.det(J) - 1) / (step**3 * -np.sin(0.6) * 0.8))
    assert 2 * excess[1] - excess[0] == pytest.approx(factor, rel=0.02), excess


def test_a_state_of_its_own_is_no_map() -> None:
    """Generalized-alpha carries an acceleration that is no function of u and v, unless it is consistent by itself."""
    assert nystrom(StepSeries(Evaluation.at_defaults("generalized_alpha"))) is None
    assert nystrom(StepSeries(evaluated("generalized_alpha", {"alpha_m": "1/4", "alpha_f": "1/4"}))) is not None
    assert nystrom(StepSeries(Evaluation.at_defaults("houbolt"))) is None
    lagged = nystrom(StepSeries(Evaluation.at_defaults("central_difference_lagged")))
    assert lagged is not None
    assert [rows[0][0] for rows in lagged.stages] == [0, 1]


def test_a_wrong_start_is_no_map_either() -> None:
    """The lagged velocity begun at v_0 itself is not the velocity half a step before that later steps carry."""
    lagged = BY_NAME["central_difference_lagged"]
    plain = replace(lagged, start={knot("-1/2").v: v0})
    assert nystrom(StepSeries(Evaluation.at_defaults(plain))) is None
