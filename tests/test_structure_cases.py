"""Sweeps of structures: every point is the march of that point, and load cases are one block."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy import sparse
from small_frame import RECORD, K, M, frame

import substep as ss
from substep.structures.model.given import loads_of

LOADS = [([1.0, 0.0, 0.0], ss.Step(1.0)), [([0.0, 0.0, 1.0], ss.Harmonic(2.0, 1.5)), ([0.0, 1.0, 0.0], RECORD)], ()]


def bent(**more: Any) -> ss.Structure:
    return ss.structure(M, internal_force=lambda u: K @ u + u**3, tangent=lambda u: K + np.diag(3 * u**2), **more)


@pytest.mark.parametrize(
    "scheme", ["newmark", "bathe", "houbolt", "kr_alpha", "central_difference_lagged", "rk4", "gauss3"]
)
def test_load_cases_are_marched_at_once(scheme: str) -> None:
    found = ss.sweep(frame(), scheme, dt=0.1, t_end=2.0, load=LOADS, keep="history", dofs=["roof", "first"])
    for case, load in enumerate(LOADS):
        r = ss.march(frame(load=load), scheme, 0.1, 2.0, dofs=["roof", "first"], account=False)
        for name in ("u", "v", "a") if "a" in found else ("u", "v"):
            assert np.allclose(found[name][case], getattr(r, name), rtol=0, atol=1e-11), name
    assert found.u.dims == ("case", "t", "dof")


@pytest.mark.parametrize(("start", "factorizations"), [({"a0": 0.0}, 1), ({}, 2)], ids=["given a0", "a0 by M"])
def test_one_factorization_of_each_matrix_serves_all_load_cases(start: Any, factorizations: int) -> None:
    made = []

    def solver(matrix: Any) -> Any:
        made.append(matrix)
        return lambda b: np.linalg.solve(matrix, b)

    coupled = ss.structure(M + 0.1, K, solver=solver, **start)
    ss.sweep(coupled, "newmark", dt=0.1, t_end=2.0, load=LOADS)
    assert len(made) == factorizations


def test_a_damping_that_the_scheme_does_not_take_is_refused_before_anything_is_marched() -> None:
    with pytest.raises(ValueError, match="rkn43 is a scheme .* without damping"):
        ss.sweep(frame(), "rkn43", dt=0.1, t_end=1.0, C=[None, 0.1 * np.eye(3)])


def test_axes_of_step_scheme_and_damping() -> None:
    dampings = [None, ss.Rayleigh(0.1, 0.01), 0.1 * np.eye(3)]
    found = ss.sweep(
        frame(), "generalized_alpha", dt=[0.1, 0.05], t_end=1.0, rho_inf=[0.0, 0.5, 1.0], C=dampings, keep="peak"
    )
    assert found.peak_u.dims == ("dt", "rho_inf", "damping", "dof")
    assert found.sizes == {"dt": 2, "rho_inf": 3, "damping": 3, "dof": 3}
    for i, j, k in np.ndindex(2, 3, 3):
        scheme = ss.scheme("generalized_alpha", rho_inf=[0.0, 0.5, 1.0][j])
        r = ss.march(frame(C=dampings[k]), scheme, [0.1, 0.05][i], 1.0, account=False)
        assert np.allclose(found.peak_a[i, j, k], np.abs(r.a).max(axis=0), rtol=1e-12, atol=0)


def test_ground_motions_are_cases() -> None:
    records = [RECORD, ss.Record(0.2, np.cos(np.arange(20)))]
    found = ss.sweep(frame(u0=0.0), "bathe", dt=0.1, t_end=2.0, ground=records, direction=np.ones(3))
    for case, record in enumerate(records):
        r = ss.march(frame(u0=0.0).ground_motion(record, np.ones(3)), "bathe", 0.1, 2.0, account=False)
        assert np.allclose(found.u[case], r.u[-1], rtol=0, atol=1e-14)


def test_a_nonlinear_structure_has_cases_too() -> None:
    found = ss.sweep(bent(), "bathe", dt=0.1, t_end=1.0, load=LOADS)
    for case, load in enumerate(LOADS):
        assert np.allclose(found.u[case], ss.march(bent(load=load), "bathe", 0.1, 1.0).u[-1], rtol=0, atol=1e-13)


@pytest.mark.parametrize("make", [frame, bent], ids=["linear", "nonlinear"])
def test_the_workers_of_a_cluster_give_what_this_process_gives(make: Any) -> None:
    from distributed import Client, LocalCluster

    call: dict[str, Any] = {"dt": [0.1, 0.05], "t_end": 1.0, "rho_inf": [0.5, 0.8], "load": LOADS}
    two = {"n_workers": 2, "threads_per_worker": 1, "processes": False, "dashboard_address": None}
    with LocalCluster(**two) as cluster, Client(cluster) as client:
        found = ss.sweep(make(), "generalized_alpha", **call, client=client)
    local = ss.sweep(make(), "generalized_alpha", **call)
    xr.testing.assert_identical(found, local)
    assert (found.status == 0).all()
    with pytest.raises(ValueError, match="synchronous dask.distributed.Client, got 'me'"):
        ss.sweep(make(), "generalized_alpha", **call, client="me")


@pytest.mark.parametrize("make", [frame, bent], ids=["linear", "nonlinear"])
@pytest.mark.parametrize("raised", [KeyboardInterrupt, ZeroDivisionError])
def test_a_sweep_that_is_stopped_keeps_what_is_computed(make: Any, raised: Any) -> None:
    """In its second step length: the first is there, and of a nonlinear structure its cases before the one stopped."""

    def load(t: Any) -> Any:
        if stopping and np.size(t) == 4:  # the steps of the second length, whose loads are taken at once
            raise raised
        return np.sin(t)

    cases = [LOADS[0], ([0.0, 1.0, 0.0], load)]
    call: dict[str, Any] = {"dt": [0.1, 0.3], "t_end": 1.2, "load": cases, "keep": "peak"}
    stopping = False
    whole = ss.sweep(make(), "bathe", **call)
    stopping = True
    if raised is KeyboardInterrupt:
        part = ss.sweep(make(), "bathe", **call)
    else:
        with pytest.raises(ZeroDivisionError) as caught:
            ss.sweep(make(), "bathe", **call)
        part = caught.value.dataset  # type: ignore[attr-defined]
    assert part.attrs["interrupted"] == 1 > whole.attrs["interrupted"]
    assert part.status.values.tolist() == [[0, 0], [-1, -1] if make is frame else [0, -1]]
    for name in whole:
        assert part[name].where(part.status == 0).equals(whole[name].where(part.status == 0)), name
        assert name == "status" or part[name].where(part.status < 0).isnull().all(), name


def test_how_each_run_ended_is_told() -> None:
    """Of a linear structure by the case, of a nonlinear one also where the iteration fails."""

    def ended(found: xr.Dataset) -> list[str]:
        meanings = found.status.attrs["flag_meanings"].split()
        return [meanings[i + 1] for i in found.status.values]

    cases = [(), ([1e300, 0.0, 0.0], ss.Step(1.0))]
    grown = ss.sweep(frame(u0=0.0), "central_difference", dt=100.0, t_end=3000.0, load=cases)
    assert ended(grown) == ["completed", "non_finite"]
    assert grown.u.isnull().all(dim="dof").values.tolist() == [False, True]
    snap = ss.structure([[1.0]], internal_force=lambda u: np.where(u > 0.5, np.nan, u), tangent=lambda u: [[1.0]])
    failed = ss.sweep(snap, "average_acceleration", dt=0.1, t_end=2.0, load=[(), ([9.0], ss.Step(1.0))], keep="history")
    assert ended(failed) == ["completed", "newton_failed"]
    assert 1 < failed.u[1].notnull().sum() < 21


def yielding(q_y: float) -> ss.Structure:
    law = ss.law("bilinear", k=[30.0, 20.0], q_y=[q_y, 0.8 * q_y], alpha=0.05)
    return ss.shear_building([1.0, 1.0], law, load=([0.0, 1.0], ss.HalfSine(4.0, 1.0)))


def bouncing(height: float) -> ss.Structure:
    return ss.structure(
        [[1.0]],
        [[0.0]],
        u0=[height],
        load=([-9.81], ss.Step(1.0)),
        contacts={"floor": ({0: 1.0}, 0.0)},
        restitution=0.5,
    )


@pytest.mark.parametrize("keep", ["final", "peak", "history"])
def test_of_no_degree_of_freedom_what_springs_do_is_kept(keep: Any) -> None:
    call: dict[str, Any] = {"dt": 0.05, "t_end": 1.0, "keep": keep}
    whole = ss.sweep([yielding(0.5), yielding(1.0)], "newmark", **call)
    found = ss.sweep([yielding(0.5), yielding(1.0)], "newmark", **call, dofs=[])
    assert found.sizes["dof"] == 0
    xr.testing.assert_equal(found.drop_dims("dof"), whole.drop_dims("dof"))
    assert float(abs(found["peak_force" if keep == "peak" else "force"]).max()) > 0.0


@pytest.mark.matrix
@pytest.mark.parametrize("keep", ["final", "peak"])
@pytest.mark.parametrize(
    "structures",
    [[frame()], [bent(u0=[x, 0.0, 0.0]) for x in (0.1, 0.2)], [yielding(q) for q in (0.5, 1.0)],
     [bouncing(x) for x in (1.0, 0.5)]],
    ids=["linear", "nonlinear", "springs", "contacts"],
)  # fmt: skip
def test_structures_that_choose_their_steps_are_marched_as_by_themselves(
    structures: list[ss.Structure], keep: Any
) -> None:
    call: dict[str, Any] = {"tol": [1e-3, 1e-5], "t_end": 1.5, "dt_max": 0.2}
    load = [LOADS[1], LOADS[0]] if structures[0].size == 3 else None  # cases, each with steps of its own
    found = ss.sweep(structures, "average_acceleration", **call, keep=keep, load=load)
    assert found.attrs["dt_max"] == 0.2
    assert (found.status == 0).all()
    for i, tol in enumerate(call["tol"]):
        for k, s in enumerate(structures):
            for case in range(1 if load is None else len(load)):
                one = s if load is None else replace(s, loads=loads_of(s.T, s.names, load[case]))
                r = ss.march(one, "average_acceleration", **{**call, "tol": tol}, account=False)
                here = found.isel(tol=i, structure=k, **({} if load is None else {"case": case}))
                of = {"u": r.u, "v": r.v, "a": r.a}
                if r.springs is not None:
                    of |= {"elongation": r.springs.elongations, "force": r.springs.forces}
                if r.touched is not None:
                    of |= {"reaction": r.touched[:, 0], "gap": r.touched[:, 1]}
                for name, x in of.items():
                    if keep == "final":
                        assert np.array_equal(here[name], x[-1]), name
                    else:
                        assert np.array_equal(here[f"peak_{name}"], np.abs(x).max(axis=0)), name
                if r.springs is not None:
                    assert np.array_equal(here.elongation, r.springs.elongations[-1])
                assert r.statistics is not None
                assert (int(here.accepted), int(here.rejected)) == (r.statistics.accepted, r.statistics.rejected)
    assert (found.accepted.diff("tol") > 0).all()


@pytest.mark.parametrize("raised", [KeyboardInterrupt, ZeroDivisionError])
def test_what_ends_structures_that_choose_their_steps_keeps_those_before(raised: Any) -> None:
    def load(t: Any) -> Any:
        if stopping:
            raise raised
        return np.sin(t)

    cases, stopping = [LOADS[0], ([0.0, 1.0, 0.0], load)], False
    call: dict[str, Any] = {"tol": 1e-3, "t_end": 1.0}
    whole = ss.sweep(frame(), "bathe", **call, load=cases)
    stopping = True
    if raised is KeyboardInterrupt:
        part = ss.sweep(frame(), "bathe", **call, load=cases)
    else:
        with pytest.raises(ZeroDivisionError) as caught:
            ss.sweep(frame(), "bathe", **call, load=cases)
        part = caught.value.dataset  # type: ignore[attr-defined]
    assert part.status.values.tolist() == [0, -1]
    assert part.u[0].equals(whole.u[0])
    assert part.u[1].isnull().all()
    small = ss.sweep(bent(u0=[0.1, 0.0, 0.0]), "bathe", tol=[1e-2, 1e-9], t_end=1.0, dt_min=0.02)
    assert small.status.values.tolist() == [
        0,
        list(small.status.attrs["flag_meanings"].split()).index("step_too_small") - 1,
    ]
    assert small.u.isnull().all("dof").values.tolist() == [False, True]
    assert small.t_failed.isnull().values.tolist() == [True, False]


def test_what_does_not_fit_is_refused() -> None:
    for arguments, message in (
        ({"load": LOADS, "ground": [RECORD]}, "got both"),
        ({"ground": [RECORD]}, "direction"),
        ({"ground": [np.ones(9)], "direction": 1.0, "scale": [2.0]}, "as ss.Record.dt, values., got ndarray"),
        ({"keep": "all"}, "did you mean|one of: final"),
        ({"dt": [0.1, 0.2], "keep": "history"}, "one dt"),
        ({"dt": None}, "expected t_end and either dt, a constant step, or tol"),
        ({"tol": 1e-3}, "expected t_end and either dt, a constant step, or tol"),
        ({"dt": None, "tol": 1e-3, "keep": "history"}, "the rows of each are its own steps; march each, or give dt"),
        ({"dt": None, "tol": 1e-3, "grid": [0.5]}, "'final' or 'peak' of structures that choose their steps"),
        ({"dt": None, "tol": [1e-3, 0.0]}, "tol in .0.0, inf., got 0.0"),
        ({"dt": None, "tol": 1e-3, "scheme": "houbolt"}, "one-step or composite scheme .* got houbolt"),
        ({"save": "here"}, "a sweep of a structure without save"),
        ({"rho_inf": [0.5, 1.5]}, "rho_inf"),
        ({"rho_inf": [[0.5, 0.8]]}, r"rho_inf to be a number or a row of them, got shape \(1, 2\)"),
        ({"dt": [[0.1], [0.05]]}, r"dt to be a number or a row of them, got shape \(2, 1\)"),
        ({"dt": []}, "at least one value on each axis"),
        ({"load": []}, "at least one value on each axis"),
        ({"scheme": ss.scheme("generalized_alpha", rho_inf=[0.5, 0.8])}, "got an array; give it as an axis"),
        ({"load": [([1.0], ss.Step(1.0))]}, "3 components"),
    ):
        with pytest.raises(ValueError, match=message):
            ss.sweep(frame(), **{"scheme": "generalized_alpha", "dt": 0.1, "t_end": 1.0, **arguments})


def test_a_sweep_says_that_it_keeps_no_account() -> None:
    with pytest.raises(ValueError, match="a sweep of a structure keeps no account of energy: march the point"):
        ss.sweep(frame(), "bathe", dt=0.1, t_end=1.0, account=True)


@pytest.mark.parametrize(
    ("axis", "message"),
    [
        ({"C": ss.Rayleigh(0.1, 0.01)}, r"C as a list, .* got Rayleigh, one value; give a list \[C\]"),
        ({"C": 0.1 * np.eye(3)}, r"C as a list, .* got ndarray"),
        ({"C": sparse.csr_array(0.1 * np.eye(3))}, r"C as a list, .* got csr_array"),
        ({"ground": RECORD, "direction": 1.0}, r"ground as a list, .* got Record, one value; give a list \[ground\]"),
        ({"load": 3.0}, r"load as a list, .* got float"),
        ({"load": LOADS[0]}, r"load as a list, .* got tuple, one value; give a list \[load\]"),
    ],
)
def test_an_axis_that_is_no_list_is_refused_with_the_cure(axis: dict[str, Any], message: str) -> None:
    with pytest.raises(ValueError, match=message):
        ss.sweep(frame(), "bathe", dt=0.1, t_end=1.0, **axis)
    (name, value), *others = axis.items()
    if name != "load" or value != 3.0:
        assert ss.sweep(frame(), "bathe", dt=0.1, t_end=1.0, **{name: [value]}, **dict(others)).status.size == 1


def test_modes_are_not_swept() -> None:
    with pytest.raises(ValueError, match="a scene or a structure to sweep, got modes; sweep their structure"):
        ss.sweep(frame().modes(2), "bathe", dt=0.1, t_end=1.0)  # type: ignore[arg-type]


def test_calls_of_rayleigh_that_do_not_fit() -> None:
    with pytest.raises(ValueError, match=r"at as two circular frequencies, rad/s, got 3.0; give a list \[omega_1"):
        ss.rayleigh(0.02, 0.02, at=3.0)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match=r"a call such as rayleigh\(0.02, 0.05, at=\(omega_1, omega_2\)\); missing"):
        ss.rayleigh(0.02, 0.02)  # type: ignore[call-arg]


def test_loads_as_an_axis_stand_beside_motions_of_base_and_supports() -> None:
    """As structures of their own that have each load and are moved after that."""
    M, K = np.diag([1.0, 2.0, 1.0]), 9.0 * np.eye(3) - 4.0
    quake, rise = ss.Record(0.04, [0.0, 2.0, -1.0, 0.5, 0.0]), ss.HalfSine(0.3, 0.4)
    loads = [({1: 1.0}, ss.Step(2.0)), [({1: 1.0}, ss.Harmonic(1.0, 3.0)), ({2: 2.0}, ss.Step(1.0))]]

    def moved(load: Any) -> ss.Structure:
        s = ss.structure(M, K, load=load, fixed=[0])
        return s.ground_motion(quake, 1.0).support_motion([0], displacement=rise)

    found = ss.sweep(moved(({2: 5.0}, ss.Step(1.0))), "bathe", dt=0.02, t_end=0.6, load=loads).u
    each = [ss.march(moved(load), "bathe", dt=0.02, t_end=0.6).u[-1] for load in loads]
    assert np.allclose(found, each, rtol=1e-12, atol=1e-14)


def test_a_start_at_rest_under_one_load_has_no_other_loads_as_an_axis() -> None:
    at_rest = ss.structure(np.eye(2), 4.0 * np.eye(2), load=([1.0, 0.0], ss.Step(1.0)), u0="static")
    with pytest.raises(ValueError, match=r"start is given, got u0='static'.*; give a list of structures, each with"):
        ss.sweep(at_rest, "bathe", dt=0.1, t_end=1.0, load=[([1.0, 1.0], ss.Step(1.0))])


def test_supports_that_have_moved_dashpots_take_no_other_damping() -> None:
    held = ss.structure(np.eye(2), 9.0 * np.eye(2) - 4.0, C=0.2 * np.eye(2) - 0.1, fixed=[0])
    s = held.support_motion([0], displacement=ss.Step(1.0), velocity=ss.Step(0.0))
    with pytest.raises(ValueError, match="damping before supports move .* and then support_motion"):
        ss.sweep(s, "bathe", dt=0.1, t_end=1.0, C=[None, np.eye(2)])
    with pytest.raises(ValueError, match="damping before supports move .* and then support_motion"):
        s.modes(1).damped(0.05)
