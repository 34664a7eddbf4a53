"""Marches in single precision: they keep the digits that they say, and compute nothing in double precision."""

import ast
import importlib.util
import inspect
import re
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from numba import types
from scipy.linalg import expm
from substep_derive.declare.catalogue import find, find_scene
from substep_derive.emit.first_use import pair_in_threads
from substep_derive.emit.single import in_single
from substep_derive.motion.equations import EquationsOfMotion
from substep_kernels.marches import linear_filter
from substep_kernels.pairs import bathe__elastic_pendulum as pair

import substep as ss

PLAIN = """
import numpy as np
from numba import njit

LIMIT = 3

def _power(x, n):
    if x > 2:
        return 0
    return max(x, 1e-30) ** n * np.sqrt(2) / 4

def march(s, n):
    total, count = 0, 0
    for j in range(n):
        half = 0 if s[j] <= LIMIT else 1
        total += (1/2)*s[j]**2 - 1/(s[j] + 3) + half*s[j] + _power(s[j], 2)
        count += 1 if abs(s[j]) < 1e-15*total else 0
    return total / n if count < n else 0
"""


def _made(text: str, tmp_path: Path, name: str) -> ModuleType:
    path = tmp_path / f"{name}.py"
    path.write_text(text.replace("cache=True", "cache=False"))
    spec = importlib.util.spec_from_file_location(name, path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    spec.loader.exec_module(module)
    return module


def test_whole_numbers_stay_whole_and_others_become_single(tmp_path: Path) -> None:
    s = np.linspace(0.1, 4.0, 17)
    double, single = (_made(text, tmp_path, f"plain_{k}") for k, text in enumerate((PLAIN, in_single(PLAIN))))
    found = single.march(s.astype(np.float32), len(s))
    assert type(found) is np.float32
    assert found == pytest.approx(double.march(s, len(s)), rel=1e-6)
    assert single._power(np.float32(3.0), np.float32(1.0)).dtype == np.float32


def _arithmetic_in_double(kernel: Any, *signature: Any) -> list[str]:
    """Lines of the compiled code that add, multiply or divide doubles."""
    kernel.compile(signature)
    return re.findall(r"= f(?:add|sub|mul|div) .*double.*", kernel.inspect_llvm(kernel.signatures[0]))


def test_a_filter_computes_nothing_in_double(tmp_path: Path) -> None:
    text = in_single(Path(linear_filter.__file__).read_text())
    module = _made(
        text.replace("peak[0, first + j] *= abs", "s[j] = abs"), tmp_path, "filter_32"
    )  # the scale, at the end
    wide, loads = types.Array(types.float64, 2, "C"), types.Array(types.float32, 1, "C")
    assert not _arithmetic_in_double(module.peaks_2_1, wide, loads, wide, types.int64, types.int64)


@pytest.mark.thorough
def test_a_pair_computes_only_its_constants_in_double(tmp_path: Path) -> None:
    tree = ast.parse(in_single(Path(pair.__file__).read_text()))
    (block,) = [f for f in tree.body if isinstance(f, ast.FunctionDef) and f.name == "_block"]
    block.body.remove([line for line in block.body if isinstance(line, ast.For)][1])
    module = _made(ast.unparse(tree), tmp_path, "pair_32")
    sizes = {"state": 3, "out": 4, "extremes": 2, "iterations": 3, "newton": 3}
    whole = {"n", "n_done", "status", "iterations", "newton"}
    signature = [
        types.int64 if name in ("first", "stride")
        else types.Array(types.int64 if name in whole else types.float64, sizes.get(name, 1), "C")
        for name in module.ARGUMENTS
    ]  # fmt: skip
    assert not _arithmetic_in_double(module.march_block, *signature)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "pair", [("bathe", "elastic_pendulum"), ("newmark", "sliding_block"), ("newmark", "softening")]
)
def test_a_thread_of_a_gpu_computes_nothing_in_double(pair: tuple[str, str], tmp_path: Path) -> None:
    text = in_single(pair_in_threads(find(pair[0]), EquationsOfMotion(find_scene(pair[1]))))
    for gpu, cpu in (
        ("cuda.jit(device=True)", 'cuda.njit(error_model="numpy")'),
        ("from numba import", "import numba as"),
    ):
        text = text.replace(gpu, cpu)
    lane = text[: text.index("@_compile")].replace("_compile = cuda.jit(cache=True)", "")
    module = _made(lane, tmp_path, f"thread_{pair[1]}")
    sizes = {"state": 2, "out": 3, "extremes": 1, "iterations": 2, "newton": 2}
    whole = {"n", "first", "stride", "iterations", "newton"}
    signature = []
    for name in inspect.signature(module._lane.py_func).parameters:
        number = types.int64 if name in whole else types.float32
        signature.append(types.Array(number, sizes[name], "C") if name in sizes else number)
    assert not _arithmetic_in_double(module._lane, *signature)


def test_peaks_of_a_long_record_are_exact_to_the_error_that_is_reported() -> None:
    dt, n, T, xi = 0.01, 20000, np.array([0.05, 0.3, 1.0, 5.0]), 0.02
    a = np.sin(np.arange(n) * dt) * np.cos(0.3 * np.arange(n) ** 0.9)
    a[0] = 0.0
    ds = ss.response_spectrum(a, dt=dt, periods=T, xi=xi, dtype="float32")
    for j, omega in enumerate(2 * np.pi / T):  # Newmark's average acceleration in plain NumPy
        A, b = np.array([[0.0, 1.0], [-(omega**2), -2 * xi * omega]]), np.array([0.0, -1.0])
        left = np.linalg.inv(np.eye(2) - dt / 2 * A)
        x, peak = np.zeros(2), 0.0
        step, load = left @ (np.eye(2) + dt / 2 * A), left @ b * dt / 2
        for f in (a[:-1] + a[1:])[: n - 1]:
            x = step @ x + load * f
            peak = max(peak, abs(x[0]))
        error = abs(float(ds.displacement[j]) / peak - 1.0)
        assert error <= ds.displacement.attrs["float32_error"] + 1e-9
    assert 0.0 < ds.displacement.attrs["float32_error"] < 10.0 ** -ds.attrs["float32_digits"]
    assert ds.attrs["float32_compared"] == 4


@pytest.mark.thorough
def test_increments_keep_the_digits_of_small_steps() -> None:
    """One radian in 20000 steps: a map that is rounded as a whole keeps two digits."""
    h, n = 5e-5, 20000
    ds = ss.sweep("linear_oscillator", "newmark", omega=[1.0, 2.0], dt=h, t_end=n * h, dtype="float32")
    exact = np.array([expm(np.array([[0.0, 1.0], [-(w**2), 0.0]]))[:, 0] for w in (1.0, 2.0)])
    np.testing.assert_allclose(ds.u[:, 0], exact[:, 0], atol=2e-4)
    assert ds.attrs["float32_digits"] >= 3


@pytest.mark.filterwarnings("ignore:float32 leaves 2 digits of")
@pytest.mark.parametrize("keep", ["final", "peak", "history"])
def test_the_error_is_that_against_double_precision(keep: Any) -> None:
    more = {"samples": 5} if keep == "history" else {}
    lanes = {"EA": 1e4, "v0": np.linspace(7.0, 8.0, 20), "dt": 0.01, "t_end": 1.0, "keep": keep, **more}
    single = ss.sweep("elastic_pendulum", "bathe", dtype="float32", **lanes)
    double = ss.sweep("elastic_pendulum", "bathe", **lanes)
    name = "peak_u" if keep == "peak" else "u"
    scale = np.abs(double[name]).max() if keep == "final" else np.abs(double[name]).max([*double[name].dims[1:]])
    error = float((np.abs(single[name] - double[name]) / scale).max())
    assert single[name].attrs["float32_error"] == pytest.approx(error, rel=1e-6)
    assert 1e-8 < error < 1e-3
    assert single.attrs["float32_differ"] == 0
    assert (single.newton_iterations < double.newton_iterations + 1.0).all()


def test_a_stiff_pendulum_says_that_no_digits_remain() -> None:
    lanes = {"EA": 1e10, "a0": (-19.6, 0.0), "v0": np.linspace(7.0, 8.0, 4), "dt": 0.01, "t_end": 1.0}
    with pytest.warns(UserWarning, match=r"float32 leaves [012] digits of a"):
        ds = ss.sweep("elastic_pendulum", "bathe", dtype="float32", **lanes)
    assert ds.attrs["float32_digits"] < 3
    assert ds.a.attrs["float32_error"] > 1e-3


def test_a_run_that_overflows_in_single_precision_alone_is_seen() -> None:
    """Newmark's explicit scheme just beyond its limit grows by 1e60 in these steps."""
    lanes = {"omega": [1.0, 2.2], "dt": 1.0, "t_end": 150.0, "beta": 0.0, "gamma": 0.5}
    with pytest.warns(UserWarning, match="1 of 2 runs ended otherwise than in float64"):
        ds = ss.sweep("linear_oscillator", "newmark", dtype="float32", **lanes)
    assert ds.attrs["float32_differ"] == 1
    assert ds.u.attrs["float32_error"] == np.inf
    assert ds.attrs["float32_digits"] == 0


def test_what_has_no_kernels_in_single_precision_is_refused() -> None:
    run: dict[str, Any] = {"dt": 0.01, "t_end": 0.1, "dtype": "float32"}
    with pytest.raises(ValueError, match="expected dtype='float64' for a structure, got 'float32'; leave dtype out"):
        ss.sweep(ss.structure([[1.0]], [[1.0]]), "newmark", **run)
    with pytest.raises(ValueError, match="where runs choose their steps"):
        ss.sweep("duffing", "newmark", tol=1e-3, t_end=0.1, dtype="float32")
    with pytest.raises(ValueError, match="whose energies depend on time"):
        ss.sweep("driven_duffing", "newmark", **run)
    with pytest.raises(ValueError, match="float16"):
        ss.sweep("linear_oscillator", "newmark", omega=1.0, dt=0.01, t_end=0.1, dtype="float16")  # type: ignore[arg-type]


def test_what_rounding_is_compared_with_is_that_of_single_precision_with_either_sign() -> None:
    text = in_single(
        "from math import sqrt\n\n\ndef closed(g, x):\n    return g <= -1e-12 * x or g < 1e-12 or g > -0.5\n"
    )
    found = [node.value for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Constant)]
    assert sorted(map(abs, found)) == [2.0**29 * 1e-12, 2.0**29 * 1e-12, 0.5]
