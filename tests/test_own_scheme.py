"""A scheme of the user's own, in a file outside the package, gets everything a built-in one has."""

import hashlib
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from inner_kernels import block_of
from substep_derive import Balance, Parameter, Scene, Scheme, certify, derive, rate
from substep_derive.declare.symbols import gamma, h, knot, theta
from sympy import Interval, Rational, Symbol

import substep as ss
from substep.derived import module_cache

OWN = '''
"""Newmark's relations with beta = gamma^2/2 (a user's file)."""
from sympy import Interval, Rational
from substep_derive import Balance, Parameter, Scheme
from substep_derive.declare.symbols import gamma, h, knot

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
half = Rational(1, 2)

mine = Scheme(
    "mine",
    parameters=(Parameter(gamma, Interval(half, 2), Rational(3, 5)),),
    relations={
        u1: u0 + h * v0 + h**2 * ((half - gamma**2 / 2) * a0 + gamma**2 / 2 * a1),
        v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
    },
    balances=(Balance.at(end, 1),),
)
'''

RUN = """
import substep as ss, sys
from my_scheme import mine
from substep_derive import certify, derive
s = ss.scheme(mine, gamma=0.7)
r = ss.march(ss.scene("linear_oscillator", omega=2.0, xi=0.05), s, dt=0.1, t_end=1.0)
print(repr(float(s.spectral_radius(1.3))), repr(float(r.u[-1, 0])), certify(mine, gamma="7/10").stable)
print(derive(mine).balances[0].effective_stiffness)
"""

LOAD = """
import substep as ss
from my_scheme import mine
print(repr(float(ss.scheme(mine, gamma=0.7).spectral_radius(1.3))))
"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    cache = tmp_path / "cache"
    monkeypatch.setenv("SUBSTEP_CACHE", str(cache))
    (tmp_path / "my_scheme.py").write_text(OWN)
    (tmp_path / "run.py").write_text(RUN)
    (tmp_path / "load.py").write_text(LOAD)
    return tmp_path


def start(folder: Path, script: str = "run.py") -> "subprocess.Popen[str]":
    environment = {**os.environ, "PYTHONPATH": str(folder), "NUMBA_DISABLE_JIT": "1"}
    command = [sys.executable, str(folder / script)]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment)


def result(process: "subprocess.Popen[str]") -> str:
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    return out


def expected() -> tuple[float, float]:
    s = ss.scheme("newmark", beta=0.7**2 / 2, gamma=0.7)
    r = ss.march(ss.scene("linear_oscillator", omega=2.0, xi=0.05), s, dt=0.1, t_end=1.0)
    return float(s.spectral_radius(1.3)), float(r.u[-1, 0])


def test_closed_forms_certificate_kernels_and_march_and_the_cache(folder: Path) -> None:
    first = result(start(folder))
    radius, u, stable = first.splitlines()[0].split()
    assert np.allclose([float(radius), float(u)], expected(), rtol=1e-13)
    assert stable == str(certify("newmark", beta="49/200", gamma="7/10").stable)
    assert "K_t(u_1)" in first
    (module,) = (folder / "cache").glob("substep_own_*.py")
    text = module.read_text()
    assert text.splitlines()[0] == "# sha256 " + hashlib.sha256(text.split("\n", 1)[1].encode()).hexdigest()
    assert (folder / "cache").stat().st_mode & 0o777 == 0o700
    written = module.stat().st_mtime_ns
    assert result(start(folder)) == first
    assert module.stat().st_mtime_ns == written  # taken from the cache


def test_a_torn_file_is_written_again(folder: Path) -> None:
    first = result(start(folder, "load.py"))
    (module,) = (folder / "cache").glob("substep_own_*.py")
    whole = module.read_text()
    module.write_text(whole[: len(whole) // 2])
    assert result(start(folder, "load.py")) == first
    assert module.read_text() == whole


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("torn", [lambda whole: whole[: len(whole) // 2], lambda _: "", lambda whole: whole + "x = 0\n",
                                  lambda whole: whole.replace("1.5", "0.5"), lambda _: "raise SystemExit"])  # fmt: skip
def test_a_file_that_is_not_what_was_written_is_never_run(torn: Callable[[str], str]) -> None:
    found = []
    for _ in range(2):
        module = module_cache.cached_module("a declaration that is torn", lambda: "x = 1.5\n")
        path = Path(str(module.__file__))
        found.append((module.x, path.read_text()))
        path.write_text(torn(found[0][1]))
        del sys.modules[module.__name__]
    assert found[0] == found[1] == (1.5, found[0][1])


def test_two_processes_at_once(folder: Path) -> None:
    both = [start(folder, "load.py"), start(folder, "load.py")]
    first, second = (result(process) for process in both)
    assert first == second
    assert len(list((folder / "cache").glob("*.py"))) == 1
    assert not list((folder / "cache").glob("*.part"))


def test_a_folder_that_others_may_write_to_or_own_is_refused(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    module_cache.cache_folder().chmod(0o777)
    with pytest.raises(PermissionError, match="chmod 700"):
        module_cache.cache_folder()
    build_folder = folder / "cache"
    build_folder.chmod(0o700)
    monkeypatch.setattr(os, "getuid", lambda: build_folder.stat().st_uid + 1)
    with pytest.raises(PermissionError, match="yours alone"):
        module_cache.cache_folder()


def declared(name: str) -> Scheme:
    u0, v0, a0 = knot(0)
    u1, v1, a1 = end = knot(1)
    half = Rational(1, 2)
    return Scheme(
        name,
        parameters=(Parameter(gamma, Interval(half, 2), Rational(3, 5)),),
        relations={
            u1: u0 + h * v0 + h**2 * ((half - gamma**2 / 2) * a0 + gamma**2 / 2 * a1),
            v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
        },
        balances=(Balance.at(end, 1),),
    )


def test_in_one_process_compiled(folder: Path) -> None:
    mine = ss.scheme(declared("mine"), gamma=0.7)
    assert np.isclose(mine.spectral_radius(1.3), expected()[0], rtol=1e-14)
    assert mine.state == derive(declared("mine")).state
    with pytest.raises(ValueError, match=r"in \[0\.5, 2\.0\], got 3"):
        ss.scheme(declared("mine"), gamma=3.0)


def test_a_leading_coefficient_below_zero(folder: Path) -> None:
    """Newmark with beta = (3 + s)/(4 + 2 s), 1/4 at s = gamma + theta = -4: the usual polynomial times 4 + 2 s.

    Its sign is chosen at the default, s = 0.
    """
    u0, v0, a0 = knot(0)
    u1, v1, a1 = end = knot(1)
    half, beta = Rational(1, 2), (3 + gamma + theta) / (4 + 2 * gamma + 2 * theta)
    mine = Scheme(
        "below_zero",
        parameters=tuple(Parameter(s, Interval(-9, 9), Rational(0)) for s in (gamma, theta)),
        relations={u1: u0 + h * v0 + h**2 * ((half - beta) * a0 + beta * a1), v1: v0 + h * (a0 + a1) / 2},
        balances=(Balance.at(end, 1),),
    )
    below, usual = ss.scheme(mine, gamma=-4), ss.scheme("newmark", beta=0.25, gamma=0.5)
    assert block_of(below.kernels.polynomial, (1.0, 0.1, -4.0, 0.0), 6)[1] < 0  # c2, after whether it is conservative
    Omega = np.logspace(-6, 3, 40)
    for xi in (0.0, 0.1):
        found, expected = below.stability(Omega, xi), usual.stability(Omega, xi)
        assert all(np.isfinite(x).all() for x in expected)
        for x, y, atol in zip(found, expected, (0.0, 1e-16, 0.0), strict=True):
            np.testing.assert_allclose(x, y, rtol=1e-12, atol=atol)
        np.testing.assert_array_equal(found[0], below.spectral_radius(Omega, xi))


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("reported", ["u", "v"])
def test_the_energy_of_a_march_is_that_of_what_is_reported(reported: str) -> None:
    """On a mass that moves, whose energy has parts in common: they are taken from this step's u and v, not the last."""
    (u0, v0, a0), (u1, v1, a1) = knot(0), knot(1)
    relations = {u1: u0 + h * v0 + h**2 / 4 * (a0 + a1), v1: v0 + h / 2 * (a0 + a1)}
    report = {"u": {u1: u1 + h**2 / 11 * (a1 - a0)}, "v": {v1: v1 + h / 7 * (a1 - a0)}}[reported]
    plain, own = (
        Scheme(name, relations, (Balance.at(knot(1), 1),), report=given)
        for name, given in (("plain", {}), ("reporting", report))
    )
    x, y = Symbol("x"), Symbol("y")
    v, w = rate(x), rate(y)
    moving = Scene(
        "moving", {x: "m", y: "m"}, kinetic=((1 + x**2) * v**2 + (2 + x**2) * w**2) / 2, parameters=(),
        potential=x**2 + x**4 + y**2 + 3 * x, start={x: 0, y: 0, v: 1, w: 1}, length=1,
    )  # fmt: skip
    one, r = (ss.march(ss.scene(moving), scheme, dt=0.05, t_end=0.5) for scheme in (plain, own))
    change = one.a[1:] - one.a[:-1]
    u, v1_ = one.u.copy(), one.v.copy()
    u[1:] += 0.05**2 / 11 * change if reported == "u" else 0.0
    v1_[1:] += 0.05 / 7 * change if reported == "v" else 0.0
    np.testing.assert_allclose(r.u, u, rtol=0.0, atol=1e-13)
    np.testing.assert_allclose(r.v, v1_, rtol=0.0, atol=1e-13)
    (a, b), (p, q) = u[1:].T, v1_[1:].T
    energy = ((1 + a**2) * p**2 + (2 + a**2) * q**2) / 2 + a**2 + a**4 + b**2 + 3 * a
    np.testing.assert_allclose(r.growth, energy.max() / r.energy[0], rtol=1e-12)
