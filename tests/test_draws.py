"""Distributions as parameters of a sweep: moments against quadrature, standard errors that hold, Sobol' indices."""

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.stats as st
import xarray as xr

import substep as ss
from substep.sweeps.draws import drawn, points
from substep.sweeps.scene_plan import ScenePlan, planned

OMEGA, U0, V0 = st.norm(2.0, 0.2), st.norm(1.0, 0.1), st.uniform(-1.0, 2.0)
RUN: dict[str, Any] = {"dt": 0.1, "t_end": 2.0, "progress": False}
ALLOWED: dict[str, Any] = {"omega": 2.0, "u0": U0, "v0": V0}


def sweep(**more: Any) -> xr.Dataset:
    return ss.sweep("linear_oscillator", "newmark", **{**RUN, **more})  # the trapezoidal rule, by default


def rule(omega: Any, u0: Any = 1.0, v0: Any = 0.0, dt: float = 0.1, t_end: float = 2.0) -> Any:
    """The displacement by the trapezoidal rule, undamped and without load: each step turns by 2 arctan(omega dt/2)."""
    turn = round(t_end / dt) * 2.0 * np.arctan(omega * dt / 2.0)
    return u0 * np.cos(turn) + v0 / omega * np.sin(turn)


def expected(f: Any) -> float:
    """The mean of f(omega) by Gauss's quadrature with the normal density as weight."""
    x, w = np.polynomial.hermite_e.hermegauss(60)
    return float(np.sum(w * f(2.0 + 0.2 * x)) / np.sqrt(2.0 * np.pi))


MEAN = expected(rule)


def of_u(ds: xr.Dataset) -> list[float]:
    """Mean of u, its standard error, and the standard deviation."""
    return [float(x) for x in ss.uncertainty(ds)["u"][:3, 0]]


def own(N: int, seed: int) -> xr.DataArray:
    """Random draws of the same distribution, without replicates."""
    return xr.DataArray(np.random.default_rng(seed).normal(2.0, 0.2, N), dims="draw")


def test_mean_deviation_and_percentiles_are_those_of_quadrature() -> None:
    found = ss.uncertainty(sweep(omega=OMEGA, u0=1.0, samples=2**12), [2.5, 50.0])
    mean, error, deviation, _, median = found["u"].sel(coordinate="u").values
    assert abs(mean - MEAN) < 4.0 * error < 1e-3
    assert deviation == pytest.approx(np.sqrt(expected(lambda x: rule(x) ** 2) - MEAN**2), rel=5e-3)
    assert median == pytest.approx(rule(2.0), abs=1e-3)  # it rises with omega from 1.6 on, and beyond 1.1 is below
    assert found["u"].attrs["units"] == "m"
    assert (int(found["completed"]), float(found["failed"])) == (2**12, 0.0)


@pytest.mark.parametrize("make", [lambda N, seed: {"omega": OMEGA, "samples": N, "seed": seed},
                                  lambda N, seed: {"omega": own(N, seed)}], ids=["sobol", "random"])  # fmt: skip
def test_the_standard_error_is_that_of_the_mean(make: Any) -> None:
    """Over 40 seeds the error in standard errors is as that of a mean of 16, or of many, independent numbers."""
    found = np.array([of_u(sweep(u0=1.0, **make(256, seed))) for seed in range(40)])
    off = (found[:, 0] - MEAN) / found[:, 1]
    assert 0.7 < np.sqrt(np.mean(off**2)) < 1.4
    assert np.mean(np.abs(off) < st.t(15).ppf(0.975)) >= 0.8


def test_the_order_of_draws_does_not_matter() -> None:
    """Replicates whose draws no longer stand together, as after sorting, are still those of the sampler."""
    ds = ss.sweep("linear_oscillator", "newmark", dt=0.1, t_end=1.0, omega=OMEGA, samples=256)
    of = ss.uncertainty(ds).u.to_numpy()
    for other in (ds.sortby("omega"), ds.isel(draw=np.random.default_rng(0).permutation(256))):
        assert np.allclose(ss.uncertainty(other).u, of, rtol=1e-12)


def test_it_falls_faster_than_with_random_draws() -> None:
    def fall(make: Any) -> float:
        return of_u(make(2**8))[1] / of_u(make(2**14))[1]

    assert fall(lambda N: sweep(u0=1.0, omega=own(N, 1))) == pytest.approx(8.0, rel=0.2)
    assert fall(lambda N: sweep(u0=1.0, omega=OMEGA, samples=N)) > 64.0**0.8


def test_each_replicate_has_one_draw_in_each_of_equal_parts_and_seeds_repeat() -> None:
    assert (points([64], 2, 0)[0] * 2**31 % 2 == 1).all()  # in the middle of cells, none at 0 or 1
    ds = sweep(**ALLOWED, samples=16 * 32)
    for name, distribution in (("u0", U0), ("v0", V0)):
        part = np.floor(distribution.cdf(ds[name].values.reshape(16, 32)) * 32)
        assert (np.sort(part) == np.arange(32)).all()
        assert len({tuple(row) for row in part}) == 16
    assert np.array_equal(ds["replicate"], np.repeat(np.arange(16), 32))
    assert ds["u0"].attrs["distribution"] == "norm(1.0, 0.1)"
    assert ds.attrs["seed"] == 0
    xr.testing.assert_identical(ds, sweep(**ALLOWED, samples=16 * 32))
    assert not np.isin(sweep(**ALLOWED, samples=16 * 32, seed=1)["u0"], ds["u0"]).any()


def test_newer_discrete_and_measured_distributions() -> None:
    newer = getattr(st, "Normal", None)
    if newer is not None:
        some, same = (sweep(omega=2.0, u0=x, samples=20) for x in (newer(mu=1.0, sigma=0.1), U0))
        assert np.allclose(some["u0"], same["u0"], rtol=1e-13)
        assert some["u0"].attrs["distribution"] == "Normal(mu=1.0, sigma=0.1)"
    steps = sweep(omega=2.0, u0=st.randint(1, 5), samples=64)["u0"]
    assert np.array_equal(np.unique(steps, return_counts=True), [[1, 2, 3, 4], [16] * 4])
    measured = sweep(omega=2.0, u0=st.rv_histogram(np.histogram([1.0, 2.0, 2.0])), samples=16)["u0"]
    assert 1.0 <= measured.min() <= measured.max() <= 2.0


@pytest.mark.parametrize("keep", ["final", "peak"])
def test_draws_of_scheme_scene_and_load_are_marched_as_each_alone(keep: Any) -> None:
    """Two parameters of the scheme vary together, not one for each value of the other."""
    ds = ss.sweep(
        "linear_oscillator", "newmark", t_end=1.0, load=ss.HalfSine(1.0, 0.4), keep=keep, progress=False, samples=20,
        gamma=st.uniform(0.5, 0.1), omega=OMEGA, dt=[0.1, 0.05], beta=st.uniform(0.31, 0.1), xi=[0.0, 0.1],
        duration=st.uniform(0.3, 0.2),
    )  # fmt: skip
    assert ds["status"].dims == ("dt", "xi", "draw")
    for k in (0, 7, 19):
        at = ds.isel(dt=1, xi=1, draw=k)
        load = ss.HalfSine(1.0, float(at.duration))
        scene = ss.scene("linear_oscillator", omega=float(at.omega), xi=0.1, load=load)
        r = ss.march(scene, ss.scheme("newmark", gamma=float(at.gamma), beta=float(at.beta)), 0.05, 1.0)
        expected = np.abs(r.u).max() if keep == "peak" else r.u[-1, 0]
        assert float(at["peak_u" if keep == "peak" else "u"][0]) == pytest.approx(expected, rel=1e-11)


@pytest.mark.usefixtures("plain_adaptive")
def test_draws_of_runs_that_choose_their_steps() -> None:
    load = ss.HalfSine(1.0, 0.4)
    ds = sweep(dt=None, tol=1e-3, t_end=0.5, omega=OMEGA, u0=U0, amplitude=V0, load=load, samples=3)
    for k in range(3):
        at = ds.isel(draw=k)
        load = ss.HalfSine(float(at.amplitude), 0.4)
        scene = ss.scene("linear_oscillator", omega=float(at.omega), u0=float(at.u0), load=load)
        assert np.array_equal(at["u"], ss.march(scene, "newmark", tol=1e-3, t_end=0.5).u[-1])


def test_rows_with_one_dimension_vary_together_also_with_histories_and_structures() -> None:
    omega, u0 = (xr.DataArray(x, dims="draw") for x in ([1.0, 2.0, 3.0], [0.5, 0.6, 0.7]))
    ds = sweep(omega=omega, u0=u0.assign_attrs(units="m"), v0=[0.0, 1.0], keep="history")
    assert ds["u"].dims == ("draw", "v0", "t", "coordinate")
    assert np.allclose(ds["u"][:, :, -1, 0], rule(omega.values[:, None], u0.values[:, None], np.array([0.0, 1.0])))
    assert ds["u0"].attrs["units"] == "m"
    K, M = np.diag([1.0, 4.0]), np.eye(2)
    beta, gamma = (xr.DataArray(x, dims="draw") for x in ([0.3, 0.36], [0.5, 0.6]))
    found = ss.sweep(ss.structure(M, K, u0=[1.0, 1.0]), "newmark", dt=0.1, t_end=1.0, beta=beta, gamma=gamma)
    assert found["u"].dims == ("draw", "dof")
    for k in range(2):
        s = ss.scheme("newmark", beta=float(beta[k]), gamma=float(gamma[k]))
        for j, w in enumerate((1.0, 2.0)):
            r = ss.march(ss.scene("linear_oscillator", omega=w, u0=1.0), s, 0.1, 1.0)
            assert float(found["u"][k, j]) == pytest.approx(r.u[-1, 0], rel=1e-12)


def test_statistics_are_of_completed_runs_and_tell_the_share_of_others() -> None:
    """Against plain NumPy, with replicates that have lost different numbers of runs."""
    ds = sweep(omega=[2.0, 9.0], u0=st.uniform(0.0, 2.0), v0=V0, samples=100, energy_bound=40.0)
    ds = ds.assign(drift=2.0 * ds["u"].isel(coordinate=0))
    ds["u"][0, 3] = ds["drift"][0, 3] = np.nan  # of a run that completed
    found = ss.uncertainty(ds, [0.0, 30.0, 100.0])
    assert set(found.data_vars) == {"u", "v", "a", "energy", "drift", "completed", "failed"}
    assert np.isnan(found["drift"][:, 0]).all()
    made, x = (ds["status"][1] == 0).values, ds["drift"][1].values
    assert 10 < made.sum() < 90
    assert (int(found["completed"][0]), int(found["completed"][1])) == (100, made.sum())
    assert np.allclose(found["failed"], [0.0, 1.0 - made.mean()])
    some = x[made]
    rows = [(made[ds["replicate"] == r].sum(), x[made & (ds["replicate"].values == r)].mean()) for r in range(16)]
    n, means = np.transpose(rows)
    error = np.sqrt(16 / 15 * np.sum((n / n.sum() * (means - some.mean())) ** 2))
    by_hand = [some.mean(), error, some.std(ddof=1), *np.percentile(some, [0, 30, 100])]
    assert np.allclose(found["drift"][:, 1], by_hand, rtol=1e-12)
    none = ss.uncertainty(sweep(omega=9.0, u0=st.uniform(5.0, 1.0), samples=20, energy_bound=1.0))
    assert np.isnan(none["u"]).all()
    assert float(none["failed"]) == 1.0


def test_a_sweep_on_disk_goes_on_with_the_same_draws(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ScenePlan, "piece", lambda self, cluster: (8,))
    call, run, begun = {**ALLOWED, "samples": 32, "save": tmp_path / "s.zarr"}, ScenePlan.run, list[int]()

    def stops(plan: ScenePlan, first: int, *rest: Any) -> Any:
        if first >= 16:
            raise KeyboardInterrupt
        return run(plan, first, *rest)

    monkeypatch.setattr(ScenePlan, "run", stops)
    part = sweep(**call)
    assert float(ss.uncertainty(part)["failed"]) == 0.5
    monkeypatch.setattr(ScenePlan, "run", lambda plan, *span: (begun.append(span[0]), run(plan, *span))[1])
    whole = sweep(**call).load()
    assert begun == [16, 24]
    xr.testing.assert_identical(whole, sweep(**ALLOWED, samples=32))
    for change, message in (({"seed": 1}, "seed is 0, got 1"), ({"u0": st.norm(1.0, 0.2)}, r"expected u0\[0\] = "),
                            ({"samples": 31}, "expected 32 values of u0")):  # fmt: skip
        with pytest.raises(ValueError, match=message):
            sweep(**{**call, **change})
    alone = {name: whole[name].drop_attrs() for name in ("u0", "v0")}
    with pytest.raises(ValueError, match="sampler is Sobol"):
        sweep(omega=2.0, save=tmp_path / "s.zarr", **alone)


def test_a_plan_is_plain_data() -> None:
    uncertain = {"omega": st.norm(2.0, 0.1), "gamma": st.uniform(0.5, 0.1), "beta": st.uniform(0.31, 0.1)}
    values, _ = drawn({**uncertain, "xi": [0.0, 0.1]}, 8, 0)
    made = planned(
        "linear_oscillator", "newmark", 0.1, None, 1.0, "final", None, None, None, None, "cpu", "float64", values=values
    )
    assert made.scheme_of_all.parameters["beta"].shape == made.scheme_of_all.parameters["gamma"].shape == (8,)
    sent = pickle.dumps(made)
    assert b"scipy" not in sent
    here, there = (plan.run(3, 13, {}) for plan in (made, pickle.loads(sent)))
    assert all(np.array_equal(here[name], there[name]) for name in here)


def ishigami(ds: xr.Dataset) -> xr.DataArray:
    return np.sin(ds.u0) + 7.0 * np.sin(ds.v0) ** 2 + 0.1 * ds.amplitude**4 * np.sin(ds.u0)


def test_indices_of_the_function_of_ishigami() -> None:
    """Their closed forms: T. Ishigami and T. Homma, 1990."""
    angle = st.uniform(-np.pi, 2.0 * np.pi)
    found = ss.sobol_indices(
        "linear_oscillator", "newmark", ishigami, dt=0.1, t_end=0.1, omega=2.0, load=ss.HalfSine(1.0, 1.0),
        u0=angle, v0=angle, amplitude=angle, samples=2**11, progress=False,
    )  # fmt: skip
    one, two = 0.5 * (1.0 + 0.1 * np.pi**4 / 5.0) ** 2, 49.0 / 8.0
    both = 0.01 * np.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    shares = np.array([[one, two, 0.0], [one + both, two, both]]) / (one + two + both)
    assert found["parameter"].values.tolist() == ["u0", "v0", "amplitude"]
    for name, share in zip(("first_order", "total"), shares, strict=True):
        assert np.allclose(found[name], share, atol=0.03)
        low, high = found[f"{name}_interval"].values
        assert ((low <= share) & (share <= high) & (high - low < 0.4)).all()
    assert found.attrs["samples"] == 2**11


def test_indices_of_an_additive_response_are_shares_of_variances_at_every_instant() -> None:
    """At fixed omega the displacement is linear in u0 and v0."""
    found = ss.sobol_indices(
        "linear_oscillator", "average_acceleration", "u", **RUN, keep="history", omega=2.0, u0=U0, v0=st.norm(0.0, 0.3)
    )
    assert found["first_order"].dims == ("parameter", "t", "coordinate")
    turn = np.arange(21) * 2.0 * np.arctan(0.1)
    parts = np.array([(0.1 * np.cos(turn)) ** 2, (0.15 * np.sin(turn)) ** 2])
    for name in ("first_order", "total"):
        assert np.allclose(found[name][..., 0], parts / parts.sum(axis=0), atol=0.01)
    none = ss.sobol_indices("linear_oscillator", "newmark", lambda ds: 0.0 * ds.u, **RUN, **ALLOWED, samples=16)
    assert np.isnan(none["total"]).all()
    assert np.isnan(none["total_interval"]).all()


def test_a_run_that_fails_is_said_and_kept() -> None:
    with pytest.raises(RuntimeError, match=r"\d+ of 64 did not") as caught:
        ss.sobol_indices("linear_oscillator", "newmark", "u", **RUN, **ALLOWED, samples=16, energy_bound=2.2)
    assert caught.value.dataset["status"].max() > 0  # type: ignore[attr-defined]


REFUSED: dict[str, tuple[dict[str, Any], str]] = {
    "outside": ({"omega": st.norm(1.0, 1.0)}, r"parameter omega .*\(0.0, inf\), got -.*one of 10 of 64 draws of omega "
                r"from norm\(1.0, 1.0\).*truncnorm"),
    "damping": ({"xi": st.norm(0.0, 1.0), "omega": 2.0}, "one of 32 of 64 draws of xi"),
    "load": ({"omega": 2.0, "load": ss.HalfSine(1.0, 1.0), "duration": st.norm()}, "32 of 64 draws of duration"),
    "estimate": ({"omega": 2.0, "dt": None, "tol": 1e-3, "gamma": st.uniform(0.5, 0.1)}, "gamma.*estimate of its own"),
    "infinite": ({"omega": st.cauchy(1e300, 1e308)}, r"finite draws of omega, got \d+ of 64"),
    "several": ({"omega": st.norm([1.0, 2.0])}, "distribution of one number"),
    "without": ({"omega": st.lognorm}, "distribution with its parameters, got lognorm"),
    "history": ({"omega": OMEGA, "keep": "history"}, "keep='final' or 'peak'"),
    "dt": ({"omega": 2.0, "dt": st.uniform(0.1, 0.2)}, "dt as a number or a row.*multiple"),
    "tol": ({"omega": 2.0, "dt": None, "tol": st.uniform(0.1, 0.2)}, "tol as a number or a row"),
    "samples": ({"omega": OMEGA, "samples": None}, "samples to be a whole number of draws >= 1, got None"),
    "half": ({"omega": OMEGA, "samples": 2.5}, "samples to be a whole number of draws >= 1, got 2.5"),
    "seed": ({"omega": OMEGA, "seed": -1}, "seed to be a whole number >= 0"),
    "lengths": ({"omega": xr.DataArray([1.0, 2.0], dims="draw"), "u0": OMEGA}, "64 along|as many values of u0"),
    "time": ({"omega": xr.DataArray([1.0, 2.0], dims="t"), "samples": None}, "another dimension of omega than t"),
    "taken": ({"omega": xr.DataArray([1.0, 2.0], dims="u0"), "u0": xr.DataArray([1.0], dims="x"), "samples": None},
              "another dimension of omega than u0"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_refusals_come_before_anything_runs(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(ScenePlan, "run", None)
    change, message = REFUSED[name]
    with pytest.raises(ValueError, match=message):
        sweep(**{"samples": 64, "xi": 0.0, **change})


@pytest.mark.parametrize("wide", [st.cauchy(1.0, 0.1), st.t(1.5), st.pareto(1.5)])
def test_a_distribution_without_a_variance_is_warned_of(wide: Any) -> None:
    """The standard error of a mean that does not exist was given as of any other."""
    with pytest.warns(UserWarning, match="u0 is from .*, of no finite variance: means, standard errors"):
        sweep(u0=wide, omega=2.0, samples=16)
    with pytest.warns(UserWarning, match="of no finite variance"):
        ss.sobol_indices("linear_oscillator", "newmark", "u", **RUN, omega=2.0, u0=wide, v0=V0, samples=16)


def test_refusals_of_structures_statistics_and_indices() -> None:
    several = [ss.structure(np.eye(2), k * np.eye(2), u0=[1.0, 0.0]) for k in (1.0, 2.0, 4.0)]
    ds = ss.sweep(several, "newmark", dt=0.1, t_end=2.0)
    mean, error = ss.uncertainty(ds.rename(structure="draw"))["u"][:2, 0].values
    by_hand = rule(np.sqrt([1.0, 2.0, 4.0]))
    assert (mean, error) == pytest.approx((by_hand.mean(), by_hand.std(ddof=1) / np.sqrt(3.0)), rel=1e-12)
    with pytest.raises(ValueError, match="give a list of structures"):
        ss.sweep(ss.structure(np.eye(2), np.eye(2)), "newmark", dt=0.1, t_end=1.0, beta=st.uniform(0.3, 0.1), samples=4)
    ds = sweep(**ALLOWED, samples=4)
    for wrong in (ds[["u"]], ds.isel(draw=0), ds["u"]):
        with pytest.raises(ValueError, match="dimension draw and its status"):
            ss.uncertainty(wrong)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match=r"percentiles in \[0.0, 100.0\]"):
        ss.uncertainty(ds, [101.0])
    call: dict[str, Any] = {"scene": "linear_oscillator", "scheme": "newmark", "quantity": "u", "samples": 4}
    wrongs: list[tuple[dict[str, Any], str]] = [
        ({"quantity": "x"}, "a variable of the sweep"), ({"samples": 6}, "give samples=4"),
        ({"u0": 1.0}, "one has all of the variance"), ({"t_end": 0.15}, "multiple"),
        ({"quantity": lambda ds: ds.u.mean("draw")}, "along draw"), ({"quantity": lambda ds: ds.u.values}, "ndarray"),
        ({"quantity": lambda ds: np.log(-abs(ds.u) - 1.0)}, "finite values"),
    ]  # fmt: skip
    for change, message in wrongs:
        with np.errstate(invalid="ignore"), pytest.raises(ValueError, match=message):
            ss.sobol_indices(**{**RUN, **call, **ALLOWED, **change})
