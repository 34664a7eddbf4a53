"""What is given counts, and as it was when it was given: nothing is lost, and no later change reaches it."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy import sparse

import substep as ss


def test_damping_of_a_shear_building_by_another_word_is_refused() -> None:
    story = ss.law("linear", k=100.0)
    with pytest.raises(ValueError, match=r"as damping=, got C; give the same as damping="):
        ss.shear_building([1.0], story, C=[[2.0]], v0=1.0)
    r = ss.march(ss.shear_building([1.0], story, damping=[[2.0]], v0=1.0), "gauss2", dt=0.01, t_end=2.0)
    omega = np.sqrt(99.0)  # of a unit mass, with xi = 0.1
    assert np.allclose(r.u[:, 0], np.exp(-r.t) * np.sin(omega * r.t) / omega, rtol=0.0, atol=1e-7)


def test_a_load_by_name_and_by_number_of_one_degree_of_freedom_is_refused() -> None:
    def pushed(load: dict[str | int, float]) -> ss.Structure:
        return ss.structure(np.eye(2), np.eye(2), names=["a", "b"], load=(load, ss.Step(1.0)))

    with pytest.raises(ValueError, match="once in a load, got 0 again; add up its parts"):
        pushed({"a": 1.0, 0: 2.0})
    r = ss.march(pushed({"a": 3.0, 1: 1.0}), "gauss3", dt=0.02, t_end=1.0)
    assert np.allclose(r.u, np.outer(1.0 - np.cos(r.t), [3.0, 1.0]), rtol=0.0, atol=1e-12)


@pytest.mark.parametrize("fixed", [[], [0]], ids=["all free", "one held"])
@pytest.mark.parametrize("made", [np.array, sparse.csr_array], ids=["dense", "sparse"])
def test_matrices_that_change_later_are_those_that_were_given(made: Callable[..., Any], fixed: list[int]) -> None:
    """The loads of a motion of the base and of supports are made of M, K and C after the structure is."""
    M, K, C = np.diag([1.0, 2.0, 3.0]), 9.0 * np.eye(3) - 4.0, 0.2 * np.eye(3) - 0.1
    given = [made(x) for x in (M, K, C)]
    s = ss.structure(given[0], given[1], C=given[2], fixed=fixed)
    for x in given:
        (x.data if sparse.issparse(x) else x)[...] = 7.0
    shaken = s.ground_motion(ss.Record(0.1, [0.0, 1.0, 0.0]), 1.0)
    assert np.array_equal(shaken.loads[0][0], -np.diag(M)[len(fixed) :])
    if fixed:
        moved = s.support_motion(fixed, displacement=ss.Step(1.0), velocity=ss.Step(0.0))
        assert np.array_equal([shape for shape, _ in moved.loads], -np.array([K[1:, 0], C[1:, 0]]))


def test_entries_of_a_sparse_matrix_that_stand_twice_stay_so_in_the_callers() -> None:
    K = sparse.csr_array((np.array([1.0, 1.0, 2.0]), np.array([0, 0, 1]), np.array([0, 2, 3])), shape=(2, 2))
    s = ss.structure(sparse.eye_array(2), K)
    assert np.array_equal(s.K.toarray(), 2.0 * np.eye(2))
    assert K.data.tolist() == [1.0, 1.0, 2.0]
    assert K.indptr.tolist() == [0, 2, 3]


def test_small_integers_that_stand_twice_in_a_sparse_matrix_do_not_overflow() -> None:
    entries = np.array([100, 100, 1], np.int8), ([0, 0, 1], [0, 0, 1])
    s = ss.structure(sparse.eye_array(2), sparse.coo_array(entries, shape=(2, 2)))
    assert np.array_equal(s.K.toarray(), np.diag([200.0, 1.0]))


def test_samples_of_a_record_that_change_later_are_those_that_were_given() -> None:
    """A structure takes the record in m/s^2, which is another one, made of what was given."""
    given = np.array([0.0, 1.0, -1.0, 0.0])
    record, in_g = ss.Record(0.1, given), ss.Record(0.1, given, unit="g")
    given *= 3.0
    alone = ss.structure([[1.0]], [[4.0]]).ground_motion(record, 1.0)
    assert np.array_equal(alone.loads[0][1](record.dt * np.arange(4)), [0.0, 1.0, -1.0, 0.0])
    assert np.allclose(in_g.of_ground().samples, [0.0, 9.80665, -9.80665, 0.0], rtol=1e-15, atol=0.0)
    assert np.array_equal(record.values, in_g.values)


def test_parameters_of_a_law_that_change_later_are_those_that_were_given() -> None:
    strengths = np.array([1.0, 2.0])
    law = ss.law("bilinear", k=10.0, q_y=strengths)
    strengths *= 5.0
    assert np.allclose(law.evaluate([1.0, 1.0]).force, [1.0, 2.0], rtol=1e-14, atol=0.0)


OSCILLATORS = {
    "linear": ss.scene("linear_oscillator", omega=2.0, u0=1.0),
    "with a law": ss.scene("hysteretic_oscillator", law="bilinear", omega=2.0, v0=1.0, strength=1.0),
    "structure": ss.structure([[1.0]], [[4.0]], u0=1.0),
    "modes": ss.structure([[1.0]], [[4.0]], u0=1.0).modes(1),
}


@pytest.mark.parametrize("name", OSCILLATORS)
def test_a_run_goes_on_from_where_it_stood_whatever_becomes_of_its_histories(name: str) -> None:
    """As of a history that was turned into another unit in its place."""
    first, same = (ss.march(OSCILLATORS[name], "bathe", dt=0.1, t_end=1.0) for _ in range(2))
    first.u[...] *= 1000.0
    then, expected = (ss.march(OSCILLATORS[name], "bathe", dt=0.05, t_end=2.0, start=r).u for r in (first, same))
    assert np.array_equal(then, expected)
