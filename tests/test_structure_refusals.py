"""Bad input of a structure and of its march: what was expected, what came, and the cure."""

from typing import Any

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import LinearOperator
from small_frame import NAMES, PUSH, K, M, frame

import substep as ss


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"K": K[:2]}, "square matrix"),
        ({"K": K[:2, :2]}, "3 x 3 as the mass matrix"),
        ({"K": np.where(K == 5.0, np.nan, K)}, "finite.*nan"),
        ({"K": sparse.csr_array(np.where(K == 5.0, np.inf, K))}, r"inf at \(1, 1\)"),
        ({"K": K + 0j}, "complex"),
        ({"K": None}, "K, or internal_force"),
        ({"tangent": lambda u: K}, "tangent and potential with internal_force only"),
        ({"M": LinearOperator((3, 3), matvec=lambda x: x)}, "M as a matrix, dense or sparse, got _Custom"),
        ({"K": LinearOperator((3, 3), matvec=lambda x: x)}, "K as a matrix, dense or sparse, got _Custom"),
        ({"names": "abc"}, "names as a list, .* got 'abc'"),
        ({"fixed": "roof"}, r"fixed as a list of names or numbers, got 'roof'; give \['roof'\]"),
        ({"fixed": 1}, r"fixed as a list of names or numbers, got 1; give \[1\]"),
        ({"u0": None}, "u0 to be finite"),
        ({"solver": 3}, "a solver, one of: .*; got '3'"),
        ({"solver": lambda matrix: None}, "the solver to return a function b -> x, got NoneType"),
        ({"internal_force": lambda u: u}, "K, or internal_force"),
        ({"C": np.eye(2)}, "C to be 3 x 3"),
        ({"load": ([1.0, 2.0], ss.Step(1.0))}, "3 components"),
        ({"load": ([1.0, 2.0, 3.0], 5.0)}, "pairs"),
        ({"load": [([1.0, 2.0, 3.0], 5.0)]}, "function of time"),
        ({"load": ({"top": 1.0}, ss.Step(1.0))}, "degree of freedom.*'top'"),
        ({"load": PUSH, "fixed": ["roof"], "u0": 0.0}, "no load on the fixed degree of freedom 'roof'"),
        ({"load": ss.Step(1.0)}, r"pairs .* got Step\(amplitude=1.0"),
        ({"load": [([0.0, 0.0, 1.0], ss.Step(1.0)), 3.5]}, "pairs .* got 3.5 in place of a pair"),
        ({"fixed": [3]}, "from 0 to 2"),
        ({"fixed": [True]}, "from 0 to 2 or its name, got True"),
        ({"fixed": ["roof"]}, "keeps the constraints"),
        ({"names": ["a", "a", "b"]}, "3 different names, got 'a' 2 times; rename"),
        ({"names": ["a", 1, "b"]}, "as strings, got 1"),
        ({"constraints": np.ones((2, 2))}, "constraints T"),
        (
            {"constraints": [[1.0, 0.0], [np.nan, 0.0], [0.0, 1.0]]},
            r"constraints T to be finite, got nan at index \(1, 0",
        ),
        ({"constraints": sparse.csr_array([[1.0, 0.0], [np.inf, 0.0], [0.0, 1.0]])}, r"inf at \(1, 0\)"),
        ({"constraints": [["1", "x"]] * 3}, "constraints T to be a real number or an array"),
        ({"constraints": np.eye(3)[:, :2] + 0j}, "constraints T to be real, got complex"),
        (
            {"constraints": [[1.0, 2.0], [1.0, 2.0], [0.5, 1.0]]},
            "independent columns, got column . dependent on others",
        ),
        ({"constraints": np.ones((3, 0))}, "n from 1 to 3, got shape"),
        ({"fixed": [0, 1, 2]}, "all 3 fixed; leave one free"),
        ({"fixed": ["roof"], "u0": np.ones(3)}, "got 1.0 at the fixed degree of freedom 'roof', where they give 0 at"),
        ({"constraints": [[1.0], [0.5], [0.5]], "u0": np.ones(3)}, "got 1.0 at the constrained degree of freedom 'sec"),
        ({"constraints": [[1.0], [0.5], [0.5]], "u0": 1.0}, "got 1.0 at the constrained degree of freedom 'sec"),
        ({"u0": [0.1j, 0.0, 0.0]}, "u0 to be real, got complex"),
        ({"load": ([1j, 0.0, 0.0], ss.Step(1.0))}, "load to be real, got complex"),
        ({"load": ({0: 1j}, ss.Step(1.0))}, "load to be real, got complex"),
        ({"load": ([1.0, 0.0, 0.0], lambda t: np.exp(1j * t))}, "the load to be real, got complex"),
        (
            {"K": None, "internal_force": lambda u: K @ u + 0j, "tangent": lambda u: K},
            "internal_force returns to be real, got complex",
        ),
        ({"u0": [1.0, 2.0]}, "u0 with 3 components"),
        ({"solver": "mumps"}, "a solver"),
    ],
)
def test_bad_input_says_what_was_expected(arguments: dict[str, Any], message: str) -> None:
    matrices = {"M": M, "K": K} | {name: x for name, x in arguments.items() if name in "MK"}
    others = {"names": NAMES, "u0": [0.1, 0.0, 0.2]} | {name: x for name, x in arguments.items() if name not in "MK"}
    with pytest.raises(ValueError, match=message):
        ss.march(ss.structure(**matrices, **others), "bathe", 0.1, 1.0)


def test_bad_arguments_of_a_march() -> None:
    for arguments, message in (
        ({"dt": 0.1, "t_end": 1.0, "dof": [1]}, "did you mean 'dofs'"),
        ({"dt": 0.1, "t_end": 1.05}, "multiple of dt"),
        ({"dt": 0.1, "t_end": 1.0, "newton": "secant"}, "a kind of Newton"),
        ({"dt": 0.1, "t_end": 1.0, "stride": 0}, "whole number of steps >= 1, got 0"),
        ({"dt": 0.1, "t_end": 1.0, "stride": 2.5}, "whole number of steps >= 1, got 2.5"),
        ({"dt": 0.1, "t_end": 1.0, "dofs": "roof"}, r"dofs as a list .* got 'roof'; give \['roof'\]"),
        ({"dt": 0.1, "t_end": 1.0, "dofs": 2}, r"dofs as a list .* got 2; give \[2\]"),
        ({"tol": 0.1, "t_end": 1.0, "dofs": "roof"}, r"got 'roof'; give \['roof'\]"),
        (
            {"dt": 0.1, "t_end": 1.0, "scheme": ss.scheme("wbz_alpha", alpha_B=[0.0, -0.1])},
            "substep.sweep takes arrays",
        ),
    ):
        with pytest.raises(ValueError, match=message):
            ss.march(frame(), **{"scheme": "bathe", **arguments})
    with pytest.raises(ValueError, match="without damping"):
        ss.march(frame(C=ss.Rayleigh(0.1, 0.0)), "rkn43", 0.1, 1.0)
    unsupported = ss.structure(np.diag([1.0, 0.0]), np.diag([1.0, 0.0]), a0=0.0, names=("held", "loose"))
    with pytest.raises(ValueError, match="a step of bathe, got one that leaves degree of freedom 'loose' undetermined"):
        ss.march(unsupported, "bathe", 0.1, 1.0)


@pytest.mark.parametrize(
    ("M", "K", "loose"),
    [
        (np.diag([2.0, 0.0, 0.0]), np.diag([3.0, 1.0, 0.0]), "'roof'"),  # without mass and stiffness
        (np.array([[0.0, 0.0, 0.0], [0.0, 1.0, 1.0], [0.0, 1.0, 1.0]]), np.eye(3), "'(second|roof)'"),
    ],
)
def test_what_a_part_of_the_structure_leaves_undetermined_is_named_as_in_the_whole(M: Any, K: Any, loose: str) -> None:
    with pytest.raises(ValueError, match=f"leaves degree of freedom {loose} undetermined; support it"):
        _ = ss.structure(M, K, names=NAMES).a0
    if M[2, 2] == 0.0:
        with pytest.raises(ValueError, match=f"leaves degree of freedom {loose} undetermined; support it"):
            ss.structure(M, K, names=NAMES).modes(1)


def test_a_massless_part_without_a_tangent_has_no_acceleration_of_its_own() -> None:
    spring = ss.structure(np.diag([1.0, 0.0]), internal_force=lambda u: u, names=("mass", "joint"))
    with pytest.raises(ValueError, match="expected tangent= for the acceleration .* 'joint', .*; give it, or a0="):
        _ = spring.a0


@pytest.mark.parametrize("run", ["march", "modes", "sweep"])
def test_histories_that_do_not_fit_in_memory_are_refused_before_they_are_made(run: str) -> None:
    """10^15 rows of 3 kinds and 3 degrees of freedom are 72 PB."""
    end = {"t_end": 1e14, "dt": 0.1}
    calls: dict[str, Any] = {
        "march": lambda: ss.march(frame(), "bathe", **end),
        "modes": lambda: ss.march(frame().modes(3), "bathe", **end),
        "sweep": lambda: ss.sweep(frame(), "bathe", keep="history", load=[PUSH, PUSH][:1], **end),
    }
    with pytest.raises(MemoryError, match="expected the histories to fit in memory, got .* 7.2e.07 GB, .* keep fewer"):
        calls[run]()
