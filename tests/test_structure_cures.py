"""Every cure that a refusal of a structure names is tried: what it says is done, and the march completes."""

import re
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import pytest

import substep as ss

M = np.diag([2.0, 1.0])
K = np.array([[6.0, -2.0], [-2.0, 4.0]])
C = 0.1 * K
FORCE: dict[str, Any] = {"internal_force": lambda u: K @ u + u**3}
TANGENT: dict[str, Any] = {"tangent": lambda u: K + np.diag(3.0 * u**2)}
POTENTIAL: dict[str, Any] = {"potential": lambda u: 0.5 * float(u @ K @ u) + 0.25 * float((u**4).sum())}
DRAG: dict[str, Any] = {"internal_force": lambda u, v: K @ u + C @ v}
BY_U: dict[str, Any] = {"tangent": lambda u, v: K}
PAIR: dict[str, Any] = {"tangent": lambda u, v: (K, C)}
MASSLESS = {"M": np.diag([2.0, 0.0]), "u0": [1.0, 0.5]}


class Case(NamedTuple):
    """A structure that a scheme refuses, with these arguments of the march, and what the message's cures change.

    schemes: whether the message names a scheme to take instead. given, asked, scheme: other cures, arguments of the
    structure, of the march, or another scheme.
    """

    structure: dict[str, Any]
    scheme: str
    message: str
    schemes: bool = True
    given: tuple[dict[str, Any], ...] = ()
    asked: dict[str, Any] | None = None
    march: dict[str, Any] = {"dt": 0.01}  # noqa: RUF012 (of a tuple)


CASES = {
    "no v in N": Case(DRAG | BY_U, "rkn43", "takes damping, such as"),
    "no v in N, without a tangent": Case(DRAG, "suzuki", "takes damping, such as"),
    "no v in N, by tol": Case(DRAG | PAIR, "rkn64", "takes damping, such as", march={"tol": 1e-4}),
    "no C": Case({"K": K, "C": C}, "rkn43", "takes damping, such as"),
    "tangent, of v": Case(DRAG, "central_difference", "give it, or take an explicit .*such as", given=(BY_U, PAIR)),
    "tangent, of u": Case(FORCE, "bathe", "give it, or take an explicit .*such as", given=(TANGENT,)),
    "tangent and C": Case(FORCE | {"C": C}, "bathe", "give it, or take an explicit .*such as", given=(TANGENT,)),
    "tangent by v": Case(DRAG | BY_U, "kr_alpha", "return both, or take another scheme, such as", given=(PAIR,)),
    "tangent by v at the start": Case(DRAG | BY_U, "gholampour", "return both, or take .*, such as", given=(PAIR,)),
    "potential": Case(FORCE | TANGENT, "energy_momentum", "give the function .*, such as", given=(POTENTIAL,)),
    "massless": Case(MASSLESS | {"K": K}, "rk4", "take an implicit scheme, such as"),
    "massless, by tol": Case(
        MASSLESS | {"K": K}, "esdirk43", "or give dt", schemes=False, asked={"dt": 0.01}, march={"tol": 1e-4}
    ),
    "stride with tol": Case({"K": K}, "bathe", "or give dt", False, asked={"dt": 0.01, "stride": 2},
                            march={"tol": 1e-3, "stride": 2}),
    "wrong tangent": Case(FORCE | {"tangent": lambda u: 2.0 * K}, "kr_alpha", "correct tangent", False,
                          given=(TANGENT,)),
    "wrong potential": Case(FORCE | TANGENT | {"potential": lambda u: float(u @ K @ u)}, "energy_momentum",
                            "correct potential", False, given=(POTENTIAL,)),
    "wrong sign of M": Case({"M": np.diag([2.0, -1.0]), "K": K}, "bathe", "correct its entries", False,
                            given=({"M": M},)),
    "not finite": Case({"internal_force": lambda u: np.full(2, np.inf)}, "rk4",
                       "correct the function", False, given=(FORCE,)),
}  # fmt: skip


def march(structure: dict[str, Any], scheme: str, **asked: Any) -> Any:
    given = {"M": M, "u0": [1.0, 0.0], **structure}
    return ss.march(ss.structure(**given), scheme, t_end=0.1, account=False, **asked)


@pytest.mark.parametrize("name", CASES)
def test_what_a_refusal_says_can_be_done(name: str) -> None:
    case = CASES[name]
    with pytest.raises(ValueError, match=case.message) as refused:
        march(case.structure, case.scheme, **case.march)
    cures: list[Callable[[], Any]] = []
    named = re.search(r"such as (\w+)", str(refused.value))
    assert (named is not None) == case.schemes
    if named:
        assert named[1] != case.scheme
        cures.append(lambda: march(case.structure, named[1], **case.march))
    cures += [lambda x=x: march(case.structure | x, case.scheme, **case.march) for x in case.given]
    if case.asked is not None:
        cures.append(lambda: march(case.structure, case.scheme, **(case.asked or {})))
    assert cures
    for cure in cures:
        assert cure().status == "completed"


@pytest.mark.thorough
def test_what_a_refusal_of_modes_and_of_a_sweep_says_can_be_done() -> None:
    damped = ss.structure(M, K, C=C, u0=[1.0, 0.0])
    for call in (
        lambda scheme: ss.march(damped.modes(2), scheme, dt=0.01, t_end=0.1),
        lambda scheme: ss.sweep(damped, scheme, dt=[0.01], t_end=0.1),
    ):
        with pytest.raises(ValueError, match="takes damping, such as dormand_prince") as refused:
            call("rkn43")
        named = re.search(r"such as (\w+)", str(refused.value))
        assert named is not None
        assert np.all(np.isfinite(call(named[1]).u))


def test_what_the_warning_of_coefficients_says_can_be_done() -> None:
    def quadratic(scheme: str) -> Any:
        s = ss.structure(
            M, internal_force=lambda u, v: K @ u + v * np.abs(v), tangent=lambda u, v: (K, np.diag(2.0 * np.abs(v))),
            u0=[1.0, 0.0],
        )  # fmt: skip
        return ss.march(s, scheme, 0.01, 0.1, account=False)

    with pytest.warns(UserWarning, match="kr_alpha takes the damping at the start, .* such as dormand_prince"):
        quadratic("kr_alpha")
    assert quadratic("dormand_prince").status == "completed"
