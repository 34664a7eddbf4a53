"""Each law along random paths, against a second account of it: from event to event, or integrated by SciPy."""

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from law_paths import Array, Oracle, bilinear, bouc_wen, clough, coulomb, isotropic_bilinear, maxwell, multilinear, slip
from plain_kernels import committed
from scipy.integrate import quad_vec

import substep as ss

SMOOTH = {"k": 25.0, "q_y": 4.0, "alpha": 0.1, "A": 1.0, "beta": 0.5, "gamma": 0.5}
LAWS: list[tuple[str, Callable[..., Oracle], dict[str, float]]] = [
    *(("bilinear", bilinear, {"k": 25.0, "q_y": 4.0, "alpha": alpha}) for alpha in (0.0, 0.2)),
    *(("isotropic_bilinear", isotropic_bilinear, {"k": 25.0, "q_y": 4.0, "alpha": alpha}) for alpha in (0.0, 0.05)),
    ("coulomb", coulomb, {"stiffness": 100.0, "q_y": 3.0}),
    *(("slip", slip, {"stiffness": 30.0, "q_y": 4.0, "gap": gap}) for gap in (0.0, 0.1)),
    *(("clough", clough, {"k": 25.0, "q_y": 4.0, "alpha": alpha}) for alpha in (0.0, 0.1)),
    ("multilinear", multilinear, {"k": 25.0, "e_1": 0.1, "k_2": 5.0, "e_2": 0.3, "k_3": 40.0}),
    *(("bouc_wen", bouc_wen, SMOOTH | {"n": n}) for n in (1, 2)),
    *(("bouc_wen", bouc_wen, SMOOTH | {"A": 1.2, "beta": 0.7, "gamma": 0.1, "n": n}) for n in (1, 2)),
    ("bouc_wen", bouc_wen, SMOOTH | {"beta": 0.4, "gamma": -0.3, "n": 2}),
    ("maxwell", maxwell, {"stiffness": 20.0, "c": 3.0}),
]
IDS = [f"{name}-{'-'.join(f'{x:g}' for x in values.values())}" for name, _, values in LAWS]


@cache
def plain(name: str) -> Any:
    return committed(f"laws.{name}")


def law(name: str, values: dict[str, float]) -> ss.Law:
    """The law with functions that are not compiled."""
    renamed = {"beta": "beta_bw", "gamma": "gamma_bw"}
    made = ss.law(name, **{renamed.get(key, key): x for key, x in values.items()})
    return replace(made, module=plain(name))


def path(seed: int, n: int = 40) -> Array:
    """Elongations, each a turn or on the way to one: at yield it is 0.16."""
    rng = np.random.default_rng(seed)
    return (rng.normal(size=n) * np.where(rng.random(n) < 0.5, 0.1, 0.4)).cumsum() * 0.7


@pytest.mark.parametrize(("name", "oracle", "values"), LAWS, ids=IDS)
@pytest.mark.parametrize(("seed", "scale"), [(1, 1), (2, 6)])
def test_force_along_a_path(
    name: str, oracle: Callable[..., Oracle], values: dict[str, float], seed: int, scale: int
) -> None:
    """Also so far that the backbones beyond the peaks have another sign there."""
    made, (memory, follow), elapsed = law(name, values), oracle(**values), 0.05
    kept, largest = made.unstrained(), 0.0
    for e in scale * path(seed):
        found = made.evaluate([e], memory=kept, elapsed=elapsed)
        q, memory = follow(float(e), memory, elapsed)
        kept, largest = found.memory, max(largest, abs(q))
        assert found.force[0] == pytest.approx(q, abs=1e-10 * largest + 1e-13)
    assert largest > 2.0


@pytest.mark.parametrize(("name", "oracle", "values"), LAWS[:-1], ids=IDS[:-1])
def test_commits_on_the_way_change_nothing(name: str, oracle: Callable[..., Oracle], values: dict[str, float]) -> None:
    """However many, on a path on which little yields: no rounding may add up. The last law, Maxwell's, has a rate."""
    made, (memory, follow), x, force = law(name, values), oracle(**values), 0.0, 0.0
    kept, largest = made.unstrained(), 0.0
    for e in 0.3 * path(4, 12):
        q, memory = follow(float(e), memory, 0.0)
        for between in np.linspace(x, e, 100)[1:]:
            found = made.evaluate([between], memory=kept)
            force, kept = float(found.force[0]), found.memory
        x, largest = float(e), max(largest, abs(q))
        assert force == pytest.approx(q, abs=1e-10 * largest + 1e-13)


@pytest.mark.parametrize(("name", "oracle", "values"), LAWS, ids=IDS)
def test_work_is_stored_or_dissipated(name: str, oracle: Callable[..., Oracle], values: dict[str, float]) -> None:
    """The integral of the oracle's force along the path, against the law's two energies."""
    made, (memory, follow), elapsed, x, work = law(name, values), oracle(**values), 0.05, 0.0, 0.0
    kept, before = made.unstrained(), 0.0
    for e in path(5, 8):

        def force(s: float, x: float = x, e: float = float(e), memory: Any = memory) -> float:
            return follow(x + s * (e - x), memory, s * elapsed)[0] if s else 0.0

        work += quad_vec(force, 0, 1, epsabs=1e-11, epsrel=1e-11)[0] * (e - x)
        found = made.evaluate([e], memory=kept, elapsed=elapsed)
        (_, memory), kept, x = follow(float(e), memory, elapsed), found.memory, float(e)
        dissipated = float(kept[0, made.memory.index("dissipated")]) if "dissipated" in made.memory else 0.0
        assert found.stored[0] + dissipated == pytest.approx(work, rel=1e-8, abs=1e-9)
        assert dissipated >= before - 1e-12
        before = dissipated


@pytest.mark.parametrize(("name", "oracle", "values"), LAWS, ids=IDS)
def test_tangent_is_the_slope_of_the_force(name: str, oracle: Callable[..., Oracle], values: dict[str, float]) -> None:
    made, elapsed, far = law(name, values), 0.05, 0
    kept, step = made.unstrained(), 1e-6
    for e in path(4):
        q = [made.evaluate([e + d], memory=kept, elapsed=elapsed).force[0] for d in (-step, 0.0, step)]
        found = made.evaluate([e], memory=kept, elapsed=elapsed)
        if abs(q[0] + q[2] - 2 * q[1]) < 1e-8:  # else it bends within
            assert found.tangent[0] == pytest.approx((q[2] - q[0]) / (2 * step), rel=1e-6, abs=1e-5)
            far += 1
        kept = found.memory
    assert far > 20


@pytest.mark.parametrize("n", [1.3, 1.7, 2.5])
def test_bouc_wen_of_any_exponent(n: float) -> None:
    test_force_along_a_path("bouc_wen", bouc_wen, SMOOTH | {"n": n}, 1, 1)


@pytest.mark.parametrize("exponent", [0.1, 0.5, 1.0, 1.7, 2.0])
def test_a_damper_of_a_power_of_the_rate(exponent: float) -> None:
    made = law("power_damper", {"c": 3.0, "exponent": exponent})
    for rate in (-2.0, -1e-3, 1e-3, 0.5, 2.0):
        found = made.evaluate([0.3], [rate], elapsed=0.05)
        assert found.force[0] == pytest.approx(3.0 * np.sign(rate) * abs(rate) ** exponent, rel=1e-13)
        assert found.damping[0] == pytest.approx(3.0 * exponent * abs(rate) ** (exponent - 1), rel=1e-12)
