"""Steps of small structures with springs that a kernel computes: as those one by one, and as plain stepping."""

import pickle
from typing import Any

import committed_steps
import numpy as np
import pytest
from declared import BY_NAME
from law_scenes import MARCHED, declared, fitting
from scipy import sparse
from substep_derive import Law, e, required
from sympy import Interval, Max, Min, symbols

import substep as ss
from substep.structures.march import fixed_steps
from substep.structures.march.steps import StructureSteps

DT, STEPS = 0.01, 100
RECORD = ss.Record(0.05, 4.0 * np.random.default_rng(0).normal(size=60))  # m/s^2
M, K, Q_Y = (np.array(x) for x in ([2.0, 1.5, 1.0], [300.0, 250.0, 200.0], [4.0, 3.0, 2.0]))
B = np.eye(3) - np.eye(3, k=-1)
STEEL = ss.law("bilinear", k=K, q_y=Q_Y, alpha=0.03)
SPRINGS: dict[str, list[Any]] = {
    "bilinear": [(B, STEEL)],
    "hysteretic": [(B, STEEL), ({0: 1.0, 2: -1.0}, ss.law("bouc_wen", k=20.0, q_y=1.0))],
    "dampers": [
        (B[:2], ss.law("power_damper", c=0.3, exponent=1.5)),
        ([0.0, 0.0, 1.0], ss.law("maxwell", stiffness=30.0, c=2.0)),
        (B[1:], ss.law("isotropic_bilinear", k=K[1:], q_y=Q_Y[1:], alpha=0.03)),
    ],
}


def model(kind: str, *, damped: bool = True, form: Any = np.asarray, scale: float = 1.0) -> ss.Structure:
    """Three stories on linear columns, with springs of this kind."""
    C = 0.5 * np.eye(3) + 0.1 * B.T @ B if damped else None
    held = form(scale * 0.1 * B.T @ np.diag(K) @ B)
    s = ss.structure(
        form(np.diag(M)), held, springs=SPRINGS[kind], C=None if C is None else form(C), v0=[0.1, 0.0, 0.0]
    )
    return s.ground_motion(RECORD, 1.0)


def one_by_one(s: ss.Structure, *given: Any, **options: Any) -> ss.Response:
    """The march without the kernel."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(fixed_steps.CompiledSteps, "of", lambda *_: None)
        return ss.march(s, *given, **options)


def by_kernel(s: ss.Structure, *given: Any, **options: Any) -> ss.Response:
    """The march, in which no steps are taken one by one but those of a scheme that starts another."""
    scheme, commits = ss.scheme(given[0]), list[float]()
    commit = StructureSteps.commit

    def counted(march: StructureSteps, X: Any, t: float) -> None:
        commits.append(t)
        commit(march, X, t)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(StructureSteps, "commit", counted)
        r = ss.march(s, *given, **options)
    assert len(commits) == (0 if scheme.starter is None else scheme.starting_steps)
    return r


def apart(one: Any, other: Any) -> float:
    """The largest difference, of the largest number."""
    x, y = (np.nan_to_num(np.asarray(z)) for z in (one, other))
    return float(np.abs(x - y).max(initial=0.0) / max(np.abs(y).max(initial=0.0), 1e-300))


def largest_difference(r: Any, other: Any) -> dict[str, float]:
    """Of all histories, by name."""
    found = {name: apart(getattr(r, name), getattr(other, name)) for name in "uva"}
    for name in ("elongations", "forces", "stored", "dissipated"):
        found[name] = apart(getattr(r.springs, name), getattr(other.springs, name))
    scale = max(np.nanmax(np.abs(x)) for x in other.memory.values())  # some remember nothing but rounding
    found |= {name: float(np.nanmax(np.abs(x - other.memory[name]))) / scale for name, x in r.memory.items()}
    for name in ("kinetic", "strain", "work", "damped") if r.account is not None else ():
        found[name] = apart(getattr(r.account, name), getattr(other.account, name))
    return found


@pytest.mark.matrix
@pytest.mark.filterwarnings("ignore:.* the energy in play")
@pytest.mark.parametrize("scheme", MARCHED)
@pytest.mark.parametrize("kind", SPRINGS)
def test_the_kernel_computes_what_steps_one_by_one_do(scheme: str, kind: str) -> None:
    damped = BY_NAME[scheme].takes_damping
    if kind == "dampers" and not damped:
        pytest.skip("takes no dampers")
    s = model(kind, damped=damped)
    options: dict[str, Any] = {"dt": DT, "t_end": STEPS * DT}
    r, other = by_kernel(s, scheme, **options), one_by_one(s, scheme, **options)
    assert r.status == other.status == "completed"
    assert np.nanmax(r.springs.dissipated[-1]) > 0.0  # it has yielded
    assert {name: x for name, x in largest_difference(r, other).items() if not x <= 1e-12} == {}
    assert np.abs(r.account.quadrature - other.account.quadrature).max() <= 1e-12 * np.abs(other.account.work).max()
    # where what is left is just above LINE of what was there, one more correction follows, and one that ends it
    assert np.abs(r.newton_iterations - other.newton_iterations).max() <= 2
    assert r.springs.shortened == other.springs.shortened


@pytest.mark.parametrize("scheme", MARCHED)
def test_a_story_is_that_of_plain_stepping(scheme: str) -> None:
    of, load, h, n = fitting(scheme, 5.0, 0.04, 4.0, 0.1), ss.Record(0.1, 12.0 * RECORD.samples[:40] / 4.0), 0.05, 40
    law = ss.law("bilinear", k=of.omega**2, q_y=of.strength, alpha=of.alpha)
    C = [[2 * of.xi * of.omega]] if of.xi else None
    s = ss.structure([[1.0]], springs=[([1.0], law)], C=C, load=([1.0], load), u0=0.1, v0=1.5)
    r = by_kernel(s, scheme, dt=h, t_end=n * h, account=False)
    rows, kept = committed_steps.history(*declared(scheme, of, load, {}), h, n, 0.1, 1.5)
    assert np.ptp(kept) > 0.0  # it has yielded
    assert np.abs(r.u[:, 0] - rows[:, 0]).max() <= 1e-11
    assert np.abs(r.v[:, 0] - rows[:, 1]).max() <= 1e-11 * of.omega
    assert np.abs(r.memory["p"][:, 0] - np.array(kept)).max() <= 1e-11


@pytest.mark.parametrize("march", [by_kernel, one_by_one])
@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "wilson_theta", "three_substep"])
def test_a_step_on_which_all_springs_go_on_yielding_takes_one_iteration(scheme: str, march: Any) -> None:
    springs = [(B, ss.law("bilinear", k=K, q_y=Q_Y, alpha=0.03))]
    push = ss.structure(np.diag(M), springs=springs, load=([1.0, 1.0, 1.0], ss.Record(2.0, [4.0, 8.0])))
    r = march(push, scheme, dt=DT, t_end=2.0, account=False)
    yielding = (np.diff(r.memory["p"], axis=0) > 0.0).all(axis=1)  # all stories in the whole step, and the one before
    whole = yielding[1:] & yielding[:-1]
    assert whole.sum() >= 20
    assert (r.newton_iterations[1:][whole] == 1).all()


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe", "houbolt", "kr_alpha", "rk4"])
def test_stretches_of_any_length_are_the_same_to_the_bit(scheme: str, monkeypatch: pytest.MonkeyPatch) -> None:
    s, options = model("hysteretic"), {"dt": DT, "t_end": STEPS * DT, "account": False}
    whole = ss.march(s, scheme, **options)
    monkeypatch.setattr(fixed_steps, "STRETCH", 7)
    parts = ss.march(s, scheme, **options)
    rest = ss.march(s, scheme, **options, start=ss.march(s, scheme, **options | {"t_end": 0.5}))
    assert np.array_equal(parts.u, whole.u)
    assert np.array_equal(parts.springs.forces, whole.springs.forces)
    for name in "uva":
        assert np.array_equal(getattr(rest, name), getattr(whole, name)[50:])
    assert np.array_equal(rest.springs.forces, whole.springs.forces[50:])
    assert np.array_equal(rest.memory["p"], whole.memory["p"][50:], equal_nan=True)


def test_some_rows_and_columns() -> None:
    s, options = model("bilinear"), {"dt": DT, "t_end": STEPS * DT}
    every, some = ss.march(s, "bathe", **options), ss.march(s, "bathe", **options, dofs=[2, 0], stride=7)
    assert np.array_equal(some.u, every.u[::7][:, [2, 0]])
    assert np.array_equal(some.springs.dissipated, every.springs.dissipated[::7])
    assert np.array_equal(some.memory["p"], every.memory["p"][::7])
    assert np.array_equal(some.account.damped, every.account.damped[::7])
    assert np.array_equal(some.state.u, every.state.u)
    assert np.array_equal(some.newton_iterations, every.newton_iterations)


def test_matrices_of_any_form_and_constraints() -> None:
    options: dict[str, Any] = {"dt": DT, "t_end": STEPS * DT}
    dense, other = (
        by_kernel(model("bilinear", form=form), "bathe", **options) for form in (np.asarray, sparse.csr_array)
    )
    assert largest_difference(other, dense)["u"] <= 1e-12
    T = [[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]]
    tied = ss.structure(np.diag(M), springs=[(B, STEEL)], C=ss.rayleigh(0.02, 0.03, at=(1.0, 3.0)), constraints=T)
    tied = tied.ground_motion(RECORD, 1.0)
    r, alone = by_kernel(tied, "bathe", **options), one_by_one(tied, "bathe", **options)
    assert np.allclose(r.u[:, 1], 0.5 * (r.u[:, 0] + r.u[:, 2]), rtol=0, atol=1e-15)
    assert {name: x for name, x in largest_difference(r, alone).items() if not x <= 1e-12} == {}
    again = ss.march(pickle.loads(pickle.dumps(tied)), "bathe", **options)
    assert np.array_equal(again.u, r.u)


def test_what_the_kernel_does_not_take_goes_one_by_one(monkeypatch: pytest.MonkeyPatch) -> None:
    taken = list[bool]()
    of = fixed_steps.CompiledSteps.of

    def seen(*given: Any) -> Any:
        found = of(*given)
        taken.append(found is not None)
        return found

    monkeypatch.setattr(fixed_steps.CompiledSteps, "of", seen)
    many, law = np.eye(101), ss.law("bilinear", k=1.0, q_y=1.0)
    for s in (
        model("bilinear"),
        ss.structure(many, many, springs=[(many[0], law)], v0=1.0),
        ss.structure(np.diag(M), springs=[(B, STEEL)], v0=1.0, solver=lambda A: lambda b: np.linalg.solve(A, b)),
        ss.structure(np.diag(M), np.diag(K), v0=1.0),
    ):
        assert ss.march(s, "newmark", dt=DT, t_end=0.05, account=False).status == "completed"
    assert taken == [True, False, False, False]


def test_sweeps_of_records_march_by_the_kernel() -> None:
    law, records = (
        ss.law("bilinear", k=K, q_y=Q_Y, alpha=0.03),
        [ss.Record(0.05, x * RECORD.samples) for x in (0.5, 1, 2)],
    )
    s = ss.shear_building(M, law, damping=0.05)
    options: dict[str, Any] = {"dt": DT, "t_end": 1.0}
    marched = [one_by_one(s.ground_motion(x, 1.0), "bathe", **options, account=False) for x in records]
    for keep, of in (
        ("final", lambda u: u[-1]), ("peak", lambda u: np.abs(u).max(axis=0)), ("history", lambda u: u),
    ):  # fmt: skip
        found = ss.sweep(s, "bathe", **options, ground=records, direction=1.0, keep=keep)
        assert (found.status == 0).all()
        for case, r in enumerate(marched):
            assert apart(found["peak_u" if keep == "peak" else "u"].isel(case=case).values, of(r.u)) <= 1e-12


@pytest.mark.parametrize("scheme", ["average_acceleration", "bathe"])
def test_an_iteration_that_fails_ends_the_march_as_one_by_one(scheme: str) -> None:
    """A law that falls after its yield point, in steps so long that none of its branches has a root."""
    k, q_y, alpha, p = symbols("k q_y alpha p")
    soft = Law(
        "softening_steel",
        parameters=(required(k), required(q_y), required(alpha, Interval(-10, 1))),
        memory={p: 0},
        update={p: Max(e - q_y / k, Min(e + q_y / k, p))},
        force=alpha * k * e + (1 - alpha) * k * (e - p),
    )
    t = 0.1 * np.arange(40)
    law, load = ss.law(soft, k=K, q_y=Q_Y, alpha=-2.0), ss.Record(0.1, 2.0 * t**2 * np.sin(10.0 * t))
    s = ss.structure(np.diag(M), springs=[(B, law)]).ground_motion(load, 1.0)
    options: dict[str, Any] = {"dt": 0.2, "t_end": 3.0}
    r, other = ss.march(s, scheme, **options), one_by_one(s, scheme, **options)
    assert r.status == other.status == "newton_failed"
    assert r.t_failed == other.t_failed
    assert len(r.t) == len(r.memory["p"]) == len(r.springs.forces) == len(r.account.work) == len(other.t) > 4
    assert np.array_equal(r.t, other.t)
    assert apart(r.u, other.u) <= 1e-12
    assert apart(r.state.u, other.state.u) <= 1e-12
    assert apart(r.state.memory["p"], other.state.memory["p"]) <= 1e-12


def test_what_overflows_ends_with_a_status() -> None:
    """An explicit scheme beyond its largest stable step."""
    options: dict[str, Any] = {"dt": 0.3, "t_end": 900.0, "account": False}
    s = model("bilinear", damped=False)
    r, other = ss.march(s, "central_difference", **options), one_by_one(s, "central_difference", **options)
    assert r.status == other.status == "non_finite"
    assert r.t_failed == other.t_failed
    assert np.isfinite(r.u).all()


def test_a_sweep_goes_on_where_a_case_overflows() -> None:
    s, law = np.diag(M), ss.law("bilinear", k=K, q_y=Q_Y, alpha=0.03)
    records = [ss.Record(0.05, x * RECORD.samples) for x in (0.0, 1.0)]
    building = ss.structure(s, springs=[(B, law)])
    options: dict[str, Any] = {"dt": 0.9, "t_end": 2700.0, "ground": records, "direction": 1.0}
    found = ss.sweep(building, "central_difference", **options, keep="history")
    assert found.status.values.tolist() == [0, 2]
    u = found.u.values
    assert (u[0] == 0.0).all()
    assert np.isfinite(u[1, :100]).all()
    assert np.isnan(u[1, -1]).all()
