"""What can be asked of a structure: constraints, massless parts, moving bases, energies, runs that end early."""

import tracemalloc
import warnings
from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy import sparse
from small_frame import NAMES, PUSH, RECORD, K, M, frame

import substep as ss


def test_degrees_of_freedom_are_chosen_by_name_or_number() -> None:
    whole = ss.march(frame(), "bathe", 0.1, 2.0)
    part = ss.march(frame(), "bathe", 0.1, 2.0, dofs=["roof", 0], stride=4)
    assert whole.dofs == NAMES
    assert np.array_equal(part.u, whole.u[::4, [2, 0]])
    assert np.array_equal(part.at("roof")[2], whole.a[::4, 2])
    assert np.allclose(part.t, whole.t[::4])
    whole, turned = (ss.march(frame(), "rk4", 0.1, 2.0, dofs=x) for x in (None, ["roof", 0, 1]))
    assert np.array_equal(turned.a, whole.a[:, [2, 0, 1]])
    turned = ss.march(frame(constraints=np.eye(3)[::-1]), "rk4", 0.1, 2.0)
    with pytest.raises(ValueError, match="expected all degrees of freedom for the acceleration"):
        _ = turned.a
    explicit = ss.march(frame(), "rk4", 0.1, 2.0, dofs=["roof"])
    assert explicit.at("roof")[2] is None
    with pytest.raises(ValueError, match="expected all degrees of freedom for the acceleration"):
        _ = explicit.a
    with pytest.raises(ValueError, match="'second'"):
        part.at("second")


def test_what_is_kept_of_all_takes_no_dense_matrix() -> None:
    """Of 3000 degrees of freedom a full matrix would take 72 MB."""
    n = 3000
    line = ss.structure(sparse.eye_array(n), sparse.eye_array(n), v0=1.0, a0=0.0)
    tracemalloc.start()
    r = ss.march(line, "central_difference", 0.1, 0.2, account=False)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert np.ptp(r.u[-1]) == 0.0 < r.u[-1, 0]
    assert peak < 5e6


@pytest.mark.parametrize("make", [np.asarray, sparse.csr_array, sparse.csc_matrix, sparse.coo_array])
def test_dense_and_sparse_matrices_of_any_kind_give_the_same(make: Any) -> None:
    expected = ss.march(frame(load=PUSH), "newmark_bdf2", 0.1, 2.0)
    found = ss.march(ss.structure(make(M), make(K), load=PUSH, u0=[0.1, 0.0, 0.2]), "newmark_bdf2", 0.1, 2.0)
    assert np.allclose(found.u, expected.u, rtol=0, atol=1e-13)


@pytest.mark.parametrize("solver", ["dense", "superlu", "pardiso"])
def test_every_solver_gives_the_same(solver: str) -> None:
    if solver == "pardiso":
        pytest.importorskip("pypardiso")
    n = 400
    stiffness = sparse.diags_array([-np.ones(n - 1), 2 * np.ones(n), -np.ones(n - 1)], offsets=[-1, 0, 1])
    chains = [
        ss.structure(sparse.eye_array(n), stiffness, load=({n // 2: 1.0}, ss.Step(1.0)), solver=s)
        for s in (solver, "dense")
    ]
    found, expected = (ss.march(chain, "bathe", 0.5, 10.0, dofs=[n // 2, 0]) for chain in chains)
    assert np.abs(found.u - expected.u).max() <= 1e-12 * np.abs(expected.u).max()


def test_fixed_degrees_of_freedom_and_constraints() -> None:
    """The roof held; and the same as a transformation; and the first two tied to each other."""
    start = {"u0": [0.1, 0.0, 0.0]}
    held = ss.march(frame(fixed=["roof"], **start), "bathe", 0.1, 2.0)
    small = ss.march(ss.structure(M[:2, :2], K[:2, :2], u0=[0.1, 0.0]), "bathe", 0.1, 2.0)
    assert np.allclose(held.u[:, :2], small.u, rtol=0, atol=1e-14)
    assert not held.u[:, 2].any()
    alone = ss.march(frame(fixed=["roof"], **start), "bathe", 0.1, 2.0, dofs=["roof"], account=False)
    assert alone.u.shape == (21, 1)
    assert not alone.u.any()
    by_matrix = ss.march(frame(constraints=np.eye(3)[:, :2], **start), "bathe", 0.1, 2.0)
    assert np.allclose(by_matrix.u, held.u, rtol=0, atol=1e-14)
    tied = ss.march(frame(constraints=[[1.0, 0.0], [1.0, 0.0], [0.0, 1.0]], u0=[0.1, 0.1, 0.2]), "bathe", 0.1, 2.0)
    assert np.array_equal(tied.u[:, 0], tied.u[:, 1])
    one = ss.structure(np.diag([3.0, 3.0]), [[7.0, -3.0], [-3.0, 3.0]], u0=[0.1, 0.2])
    assert np.allclose(tied.u[:, 1:], ss.march(one, "bathe", 0.1, 2.0).u, rtol=0, atol=1e-14)


def test_a_moving_base_is_a_load_and_gives_absolute_accelerations() -> None:
    iota = np.array([1.0, 1.0, 1.0])
    moved = ss.march(frame(u0=0.0).ground_motion(RECORD, iota), "average_acceleration", 0.1, 3.0)
    by_hand = ss.march(frame(u0=0.0, load=(-M @ iota, RECORD)), "average_acceleration", 0.1, 3.0)
    assert np.allclose(moved.u, by_hand.u, rtol=0, atol=1e-14)
    assert np.allclose(moved.absolute_a, moved.a + RECORD(moved.t)[:, None], rtol=0, atol=1e-14)
    by_name = ss.march(frame(u0=0.0).ground_motion(RECORD, list(NAMES)), "average_acceleration", 0.1, 3.0)
    assert np.array_equal(by_name.u, moved.u)
    with pytest.raises(ValueError, match="ground_motion"):
        _ = by_hand.absolute_a


def test_two_motions_of_the_base_add_up() -> None:
    """Along x and y, and both at once where the structure is linear."""
    x, y, other = [1.0, 0.0, 1.0], [0.0, 1.0, 0.5], ss.Record(0.1, np.cos(np.arange(60)))
    still = frame(u0=0.0)
    both = still.ground_motion(RECORD, x).ground_motion(other, y)
    each = still.ground_motion(RECORD, x), still.ground_motion(other, y)
    r, *parts = (ss.march(s, "average_acceleration", 0.1, 3.0) for s in (both, *each))
    assert np.allclose(r.absolute_a, sum(part.absolute_a for part in parts), rtol=0, atol=1e-12)


def test_a_direction_that_may_be_displacements_or_numbers_is_refused() -> None:
    still = frame(u0=0.0)
    for direction in (1, np.int64(1), [0, 1, 2]):
        with pytest.raises(ValueError, match=r"such as 1.0 for all, or as a list of degrees of freedom, such as \[1\]"):
            still.ground_motion(RECORD, direction)
    with pytest.raises(ValueError, match="expected a direction in which mass moves that is free, got one without"):
        frame(fixed=["roof"], u0=0.0).ground_motion(RECORD, ["roof"])
    with pytest.raises(ValueError, match="direction to be real, got complex"):
        still.ground_motion(RECORD, [1j, 0.0, 0.0])
    for direction, expected in ((1.0, [1, 1, 1]), ([1], [0, 1, 0]), ([1, 0, 1], [1, 0, 1]), ([2, 0], [1, 0, 1])):
        assert np.array_equal(still.influence_of(direction), expected)


def test_a_start_is_of_all_degrees_of_freedom_and_keeps_the_constraints() -> None:
    """One number is that of all that are not fixed; of independent ones in another order they are sorted."""
    assert np.array_equal(frame(fixed=["second"], u0=1.0).u0, [1.0, 1.0])
    turned = frame(constraints=np.eye(3)[::-1])
    assert np.allclose(turned.T @ turned.u0, [0.1, 0.0, 0.2], rtol=0, atol=1e-15)
    with pytest.raises(ValueError, match="values of the record to be real, got complex"):
        ss.Record(0.1, [0.0, 1j])


def test_massless_degrees_of_freedom_start_by_static_condensation() -> None:
    """The second has no mass: it follows statically, at the start and in an implicit march."""
    mass = np.diag([2.0, 0.0, 3.0])
    u0 = np.array([0.1, (2.0 * 0.1 + 3.0 * 0.2) / 5.0, 0.2])
    loose = ss.structure(mass, K, u0=u0)
    condensed = K - np.outer(K[:, 1], K[1]) / K[1, 1]
    small = ss.structure(mass[np.ix_([0, 2], [0, 2])], condensed[np.ix_([0, 2], [0, 2])], u0=u0[[0, 2]])
    assert np.allclose(loose.a0[[0, 2]], small.a0, rtol=0, atol=1e-14)
    assert abs(K[1] @ loose.a0) <= 1e-14
    found, expected = (ss.march(s, "bathe", 0.1, 2.0) for s in (loose, small))
    assert np.allclose(found.u[:, [0, 2]], expected.u, rtol=0, atol=1e-13)
    damped = replace(loose, C=ss.Rayleigh(0.1, 0.01))  # which makes the matrix of an explicit step regular
    for scheme, s in product(("central_difference", "forest_ruth", "rk4"), (loose, damped)):
        with pytest.raises(ValueError, match=f"{scheme} is explicit: expected mass .* none at 1; .* implicit"):
            ss.march(s, scheme, 0.1, 2.0)
        with pytest.raises(ValueError, match=f"{scheme} is explicit"):
            ss.sweep(s, scheme, dt=0.1, t_end=2.0)
    started = next(s for s in map(ss.scheme, ss.schemes()) if s.starter and s.starter.name == "dormand_prince")
    with pytest.raises(ValueError, match=f"dormand_prince, which starts {started.name}, is explicit"):
        ss.march(loose, started, 0.1, 2.0)
    with pytest.raises(ValueError, match="equilibrium of the massless degree of freedom 1"):
        ss.march(ss.structure(mass, K, u0=[0.1, 0.0, 0.2]), "bathe", 0.1, 2.0)


@pytest.mark.parametrize("large", [False, True], ids=["dense", "sparse"])
def test_a_mass_matrix_with_a_negative_eigenvalue_is_refused(large: bool) -> None:
    """Two masses that are coupled by more than their mean, at one place of a chain; as much as that is accepted."""
    n = 1200 if large else 5
    full = sparse.diags_array([0.5 * np.ones(n - 1), 2.0 * np.ones(n), 0.5 * np.ones(n - 1)], offsets=[-1, 0, 1])
    names = [f"x {i}" for i in range(n)]
    stiffness = sparse.eye_array(n)
    for coupling, sign in ((3.0, 1.0), (0.5, -1.0), (0.5, 1.0)):
        mass = sparse.lil_array(full)
        mass[2, 3] = mass[3, 2] = coupling
        mass[3, 3] *= sign
        s = ss.structure(sparse.csr_array(mass), stiffness, names=names, v0=1.0)
        if (coupling, sign) == (0.5, 1.0):
            assert ss.march(s, "bathe", 0.1, 0.2).status == "completed"
            continue
        for ask in (
            lambda s=s: ss.march(s, "bathe", 0.1, 0.2),
            lambda s=s: ss.sweep(s, "bathe", dt=0.1, t_end=0.2),
            lambda s=s: s.critical_step("rk4"),
        ):
            with pytest.raises(ValueError, match=r"without negative eigenvalues.*freedom 'x [23]'; correct"):
                ask()
    with pytest.raises(ValueError, match="without negative eigenvalues.*freedom 1;"):
        ss.structure(np.diag([1.0, -1.0]), np.eye(2)).critical_step("rk4", bound=True)


def test_what_knows_the_tangent_alone_refuses_an_internal_force() -> None:
    bent = ss.structure(M, internal_force=lambda u: K @ u + u**3, tangent=lambda u: K + np.diag(3.0 * u**2), v0=0.1)
    modes = bent.modes(2)
    for ask in (
        lambda: bent.critical_step("rk4"),
        lambda: bent.critical_step("rk4", bound=True),
        lambda: ss.march(modes, "bathe", 0.1, 1.0),
        lambda: ss.choose(bent, 1e-3, t_end=1.0, quantity=0),
        lambda: ss.choose(modes, 1e-3, t_end=1.0, quantity=0),
        lambda: ss.response_spectrum_analysis(modes, RECORD, 1.0),
    ):
        with pytest.raises(
            ValueError, match=r"expected a linear structure .* march the structure itself, or linearise"
        ):
            ask()
    assert ss.structure(M, K, C=ss.modal_damping(0.1, modes), v0=0.1).damping.shape == (3, 3)


def test_a_free_body_drifts_with_its_momentum() -> None:
    pair = ss.structure(np.diag([1.0, 2.0]), [[5.0, -5.0], [-5.0, 5.0]], v0=[1.0, 0.0])
    r = ss.march(pair, "generalized_alpha", 0.05, 5.0)
    assert np.allclose(r.v @ [1.0, 2.0], 1.0, rtol=0, atol=5e-12)


def test_the_account_of_energy_closes_for_the_average_acceleration_scheme() -> None:
    """Its step keeps the balance exactly; a dissipative scheme's numerical dissipation is what its damping takes."""
    damped = frame(C=ss.rayleigh(0.02, 0.03, at=(0.6, 2.9)), load=PUSH)
    closed = ss.march(damped, "average_acceleration", 0.05, 10.0).account
    assert closed is not None
    assert np.abs(closed.numerical).max() <= 1e-12 * closed.work.max()
    assert closed.damped[-1] > 0.01 * closed.work.max()
    with pytest.warns(UserWarning, match="backward_euler has dissipated"):
        lossy = ss.march(frame(), "backward_euler", 0.05, 10.0).account
    assert lossy is not None
    assert np.all(np.diff(lossy.numerical) > 0.0)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ss.march(frame(), "bathe", 0.05, 10.0)
    for scheme, dt in (("central_difference", 0.95), ("forward_euler", 0.05)):
        with pytest.warns(UserWarning, match=f"{scheme} has gained"):
            ss.march(frame(), scheme, dt, 19.0)
    for name, s in (
        ("K", ss.structure(M, K + np.eye(3, k=1), u0=0.1)),
        ("M", ss.structure(M + 0.1 * np.eye(3, k=1), K)),
    ):
        with pytest.warns(UserWarning, match=f"no account of energy where {name} is not symmetric"):
            assert ss.march(s, "bathe", 0.05, 1.0).account is None
    with pytest.raises(ValueError, match="account=True"):
        _ = ss.march(frame(), "bathe", 0.05, 10.0, account=False).energy


def test_rayleigh_damping_has_its_ratios_where_it_was_asked_to() -> None:
    damping = ss.rayleigh(0.02, 0.05, at=(1.0, 10.0))
    assert np.allclose([damping.ratio(1.0), damping.ratio(10.0)], [0.02, 0.05], rtol=1e-14)
    with pytest.raises(ValueError, match="beta = -"):
        ss.rayleigh(0.5, 0.01, at=(1.0, 10.0))
    with pytest.raises(ValueError, match="two different frequencies"):
        ss.rayleigh(0.02, 0.02, at=(1.0, 1.0))


def test_a_run_that_overflows_or_is_interrupted_keeps_what_it_has() -> None:
    grown = ss.march(frame(), "central_difference", 100.0, 100_000.0, account=False)
    assert grown.status == "non_finite"
    assert np.isfinite(grown.u).all()
    assert grown.t_failed == pytest.approx(100.0 * len(grown.u))

    def load(t: Any) -> Any:
        if np.max(t) > 30.0:
            raise KeyboardInterrupt
        return 0.0 * t

    stopped = ss.march(frame(load=([1.0, 0.0, 0.0], load)), "bathe", 0.1, 60.0, account=False)
    assert stopped.status == "interrupted"
    assert 1 < len(stopped.u) < 601


def test_an_exception_of_the_users_loses_nothing() -> None:
    def load(t: Any) -> Any:
        if np.max(t) > 30.0:
            raise RuntimeError("no load")
        return np.sin(t)

    with pytest.raises(RuntimeError, match="no load") as caught:
        ss.march(frame(load=([1.0, 0.0, 0.0], load)), "bathe", 0.1, 60.0)
    done = caught.value.response  # type: ignore[attr-defined]
    assert len(done.u) > 200
    assert np.array_equal(done.u, ss.march(frame(load=([1.0, 0.0, 0.0], np.sin)), "bathe", 0.1, 60.0).u[: len(done.u)])


def test_an_iteration_that_fails_ends_the_run_with_what_it_has() -> None:
    snap = ss.structure(
        [[1.0]], internal_force=lambda u: np.where(u > 0.5, np.nan, u), tangent=lambda u: [[1.0]], v0=[1.0]
    )
    r = ss.march(snap, "average_acceleration", 0.1, 2.0, account=False)
    assert r.status == "newton_failed"
    assert 2 < len(r.u) < 8


def test_one_of_many_names_is_found_at_once_and_a_wrong_one_is_answered_briefly() -> None:
    n = 50_000
    names = [f"u{i}" for i in range(n)]
    unit = sparse.eye_array(n, format="csr")
    many = ss.structure(unit, unit, names=names, fixed=names[::2])
    assert many.kept(None) == names
    assert many.place("u49999") == 49_999
    with pytest.raises(
        ValueError, match=r"got 'u50001'; did you mean 'u.*'\? near are: u.*, .*; there are 50000"
    ) as found:
        many.place("u50001")
    assert len(str(found.value)) < 3000


def test_a_damping_ratio_in_place_of_a_matrix_is_answered_by_the_dampings_that_take_one() -> None:
    with pytest.raises(
        ValueError, match=r"C as a matrix, got 0.05; .*ss.modal_damping\(0.05, .*ss.rayleigh\(0.05, 0.05"
    ):
        ss.structure(np.eye(2), np.eye(2), C=0.05)


def test_the_base_shear_is_that_of_one_direction() -> None:
    springs = [([1.0, 0.0], ss.law("linear", k=4.0)), ([0.0, 1.0], ss.law("linear", k=9.0))]
    record, along_y = ss.Record(0.1, [0.0, 1.0, -1.0, 0.0]), [0.0, 1.0]
    s = ss.structure(np.eye(2), springs=springs).ground_motion(record, along_y)
    r = ss.march(s.ground_motion(record, along_y), "newmark", dt=0.1, t_end=0.5)
    assert np.allclose(r.base_shear, 9.0 * r.u[:, 1], rtol=1e-12, atol=0.0)
    r = ss.march(s.ground_motion(record, [1.0, 0.0]), "newmark", dt=0.1, t_end=0.5)
    with pytest.raises(ValueError, match="one direction for the base shear, got 2 motions in several; add up r.spr"):
        _ = r.base_shear
