"""What is decided for every structure, against random structures that are stepped from the declaration alone."""

from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from declared_steps import constants
from structure_steps import Blocks, random_structures
from substep_derive import certify
from substep_derive.declare.catalogue import find
from substep_derive.declare.schemes import ALL
from sympy import Symbol

import substep as ss

REFUTED = {"forward_euler", "rk2", "bdf3", "bdf4", "butcher6", "rkn64"}
BOUND = {
    *(
        "central_difference_lagged",
        "rk4",
        "tchamwa_wielgosz",
        "linear_acceleration",
        "fox_goodwin",
        "central_difference",
    ),
    *("explicit_generalized_alpha", "bogacki_shampine", "dormand_prince", "rkn43", "stoermer_extrapolation", "suzuki"),
    "yoshida6",
}
OPEN = {"noh_bathe", "kim_two_stage", "trbdf3", "forest_ruth"}
THESIS = {"gamma_t": Fraction(1, 5), "beta": Fraction("0.3025"), "gamma": Fraction(3, 5)}


def largest(name: str, count: int, seed: int = 0, **parameters: Any) -> float:
    """The largest modulus of an eigenvalue over random structures, within the bound if there is one."""
    found, scheme = certify(name, structures=True, **parameters), find(name)
    assert found.verdict in ("proved", "proved under a bound")
    numbers = {
        Symbol(key): float(x)
        for key, x in ss.scheme(name, **{k: float(v) for k, v in parameters.items()}).parameters.items()
    }
    numbers |= {s: float(x) for s, x in constants(scheme, mpmath).items()}
    rng, worst = np.random.default_rng([seed, len(name)]), 0.0
    for n, rigid in ((1, 0), (2, 0), (2, 1), (3, 0), (4, 1), (5, 0), (5, 2)):
        M, C, K = random_structures(rng, -(-count // 7), n, rigid)
        if not scheme.takes_damping:
            C = 0 * C
        if found.bound is not None:
            W, D = found.bound
            load = K / float(W) + (0 * C if D is None else C / float(D))
            size = np.abs(np.linalg.eigvals(np.linalg.solve(M, load))).max(axis=1)[:, None, None]
            C, K = (C if D is None else C * 0.999 / size), K * 0.999 / size
        blocks = Blocks(scheme, numbers, (M, C, K))
        A = blocks.without_rigid(blocks.amplification(), rigid)
        worst = max(worst, np.abs(np.linalg.eigvals(A)).max())
    return worst


def proved() -> list[str]:
    return [s.name for s in ALL if s.name not in REFUTED | OPEN]


@pytest.mark.parametrize("name", proved())
def test_no_random_structure_grows(name: str) -> None:
    assert largest(name, 35) <= 1 + 1e-10


@pytest.mark.thorough
@pytest.mark.parametrize("name", proved())
def test_no_structure_of_three_thousand_grows(name: str) -> None:
    assert largest(name, 3000, seed=1) <= 1 + 1e-10


@pytest.mark.parametrize(
    ("gamma_t", "beta", "gamma"), [("1/5", "0.3025", "3/5"), ("1/2", "1/2", "4/5"), ("3/4", "9/10", "11/8")]
)
def test_newmark_then_bdf2_is_proved_where_its_sub_steps_differ(gamma_t: str, beta: str, gamma: str) -> None:
    given = {"gamma_t": Fraction(gamma_t), "beta": Fraction(beta), "gamma": Fraction(gamma)}
    assert largest("newmark_bdf2", 350, **given) < 1


@pytest.mark.parametrize("scheme", ALL, ids=lambda s: s.name)
def test_each_scheme_has_its_verdict(scheme: Any) -> None:
    found = certify(scheme, structures=True)
    name = scheme.name
    expected = (
        "refuted"
        if name in REFUTED
        else "open"
        if name in OPEN
        else "proved under a bound"
        if name in BOUND
        else "proved"
    )
    assert found.verdict == expected
    assert (found.growing is not None) == (name in REFUTED)
    if found.growing is not None:  # the exact matrices, in floating point
        numbers = {s: float(x) for s, x in constants(scheme, mpmath).items()}
        structure = tuple(np.array([part], float) for part in found.growing)
        A = Blocks(scheme, numbers, structure).amplification()  # type: ignore[arg-type]
        assert np.abs(np.linalg.eigvals(A)).max() > 1
