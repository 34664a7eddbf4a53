"""Handles of schemes and scenes: what the index says of them, when two are equal, and what marches the first steps."""

import copy
import pickle
import tomllib
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from substep_derive import Balance, Parameter, Scene, Scheme
from substep_derive.declare.scene import optional
from substep_derive.declare.symbols import gamma, h, knot, rate
from substep_kernels.index import SCHEMES
from substep_kernels.scene_index import SCENES
from sympy import Interval, Rational, Symbol

import substep as ss
from substep.core.entries import SceneInfo, SchemeInfo

NEWMARK: dict[str, Any] = SCHEMES["newmark"]


@pytest.mark.parametrize("name", SCHEMES)
def test_every_scheme_of_the_index_has_its_entry_in_full(name: str) -> None:
    s = ss.scheme(name)
    assert [*s.info.parameters] == [key for key, *_ in SCHEMES[name]["parameters"]]
    assert len(s.state) == len(s.history) == len(SCHEMES[name]["state"])
    assert s.stencil().shape == (s.info.loads,)
    assert (s.starter is not None) == (s.info.start == "scheme")
    assert s.info.start != "given" or all(lag == 0 for _, lag in s.history)
    for family in s.info.families.values():
        assert family.values.keys() <= s.info.parameters.keys()


@pytest.mark.parametrize("name", SCENES)
def test_every_scene_of_the_index_has_its_entry_in_full(name: str) -> None:
    info = SceneInfo.of(name, SCENES[name])
    for (key, low, high, low_open, high_open, default), mine in zip(
        SCENES[name]["parameters"], info.parameters.values(), strict=True
    ):
        assert (mine.name, mine.low, mine.high, mine.low_open, mine.high_open) == (key, low, high, low_open, high_open)
        assert (None if mine.default is None else mine.default()) == default


def test_a_default_follows_the_parameters_before_it() -> None:
    beta, gamma = ss.scheme("generalized_alpha").info.parameters, ss.scheme("newmark").info.parameters["gamma"]
    assert gamma.default_of("newmark", {"beta": 0.3}) == 0.5
    assert beta["beta"].default is not None
    with pytest.raises(ValueError, match="expected a value for EA of elastic_pendulum, got none; give it by ss.scene"):
        ss.scene("elastic_pendulum")


def started(entry: dict[str, Any], declaration: Any = None) -> ss.Scheme:
    return replace(ss.scheme("newmark"), info=SchemeInfo.of("newmark", {**NEWMARK, **entry}, declaration=declaration))


def test_start_and_starter() -> None:
    """A start by u, h*v, h^2*a, by the module's function, by a scheme of the index, or by one declared with it."""
    for start in ("given", "function"):
        s = started({"start": start, "starter": None})
        assert s.info.start == start
        assert s.starter is None
    s = started({"start": "scheme", "starter": ("newmark", {"beta": 0.3, "gamma": 0.6})})
    assert s.info.start == "scheme"
    assert s.starter == ss.scheme("newmark", beta=0.3, gamma=0.6)
    own = SimpleNamespace(start_scheme="bathe")  # in place of a declaration, so that nothing has to be derived
    assert started({"start": "scheme", "starter": ("", {})}, own).starter == ss.scheme("bathe")


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize(
    "scene",
    [lambda: ss.scene("linear_oscillator", omega=3.0, xi=0.1, load=ss.Harmonic(1.0, 2.0)), lambda: ss.scene("duffing")],
)
def test_a_starter_marches_the_first_steps_with_its_parameters(scene: Callable[[], ss.Scene]) -> None:
    """In both marches the first steps are the starter's to the last bit, and the next step is not."""
    houbolt = ss.scheme("houbolt")
    lag = max(back for _, back in houbolt.history)
    parameters = {"beta": 0.3, "gamma": 0.6}
    other = replace(houbolt, info=replace(houbolt.info, starter=("newmark", parameters)))
    found, usual = (ss.march(scene(), s, dt=0.01, t_end=0.1) for s in (other, houbolt))
    first = ss.march(scene(), ss.scheme("newmark", **parameters), dt=0.01, t_end=0.1)
    assert np.array_equal(found.u[: lag + 1], first.u[: lag + 1])
    assert not np.array_equal(found.u[lag + 1], first.u[lag + 1])
    assert not np.array_equal(found.u[: lag + 1], usual.u[: lag + 1])


def declared(weight: Rational) -> Scheme:
    u0, v0, a0 = knot(0)
    u1, v1, a1 = end = knot(1)
    return Scheme(
        "mine",
        parameters=(Parameter(gamma, Interval(Rational(1, 2), 2), Rational(3, 5)),),
        relations={
            u1: u0 + h * v0 + h**2 * ((Rational(1, 2) - weight) * a0 + weight * a1),
            v1: v0 + h * ((1 - gamma) * a0 + gamma * a1),
        },
        balances=(Balance.at(end, 1),),
    )


def own_scene(power: int) -> Scene:
    q, k = Symbol("q"), Symbol("k")
    start = {q: 1, rate(q): 0}
    return Scene("mine", {q: "m"}, rate(q) ** 2 / 2, k * q**power, (optional(k, 1),), start=start, length=1)


def assert_distinguished(same: tuple[Any, Any], others: list[Any]) -> None:
    one, again = same
    assert one is not again
    assert one == again
    assert hash(one) == hash(again)
    kept = {one: "found"}
    assert kept[again] == "found"
    for other in others:
        assert one != other
        assert other not in kept
    assert len({one, again, *others}) == 1 + len(others)


def test_schemes_are_equal_by_name_and_parameters() -> None:
    values = np.array([0.25, 0.3])
    assert_distinguished(
        (ss.scheme("newmark", beta=0.25), ss.scheme("newmark")),
        [ss.scheme("newmark", beta=0.26), ss.scheme("average_acceleration"), ss.scheme("newmark", beta=[0.25])],
    )
    assert_distinguished(
        (ss.scheme("newmark", beta=values), ss.scheme("newmark", beta=values.copy())),
        [ss.scheme("newmark", beta=x) for x in (values[::-1], values[:, None], values[:1], 0.25)],
    )
    assert_distinguished(
        (ss.scheme("hht_alpha", alpha=0.0), ss.scheme("hht_alpha", alpha=-0.0)), [ss.scheme("hht_alpha")]
    )
    assert ss.scheme("newmark") != "newmark"


def test_own_schemes_are_equal_by_what_is_declared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    quarter, third = Rational(1, 4), Rational(1, 3)
    same = ss.scheme(declared(quarter), gamma=0.6), ss.scheme(declared(quarter))
    assert_distinguished(same, [ss.scheme(declared(third)), ss.scheme(declared(quarter), gamma=0.7)])


def test_scenes_are_equal_by_name_parameters_start_and_load() -> None:
    def oscillator(load: Any = None, **parameters: Any) -> ss.Scene:
        return ss.scene("linear_oscillator", **{"omega": 2.0, **parameters}, load=load)

    record = [0.0, 1.0, 0.5]
    assert_distinguished(
        (oscillator(ss.Record(0.1, record)), oscillator(ss.Record(0.1, np.array(record)))),
        [
            oscillator(),
            oscillator(ss.Harmonic(1.0, 2.0)),
            oscillator(ss.Record(0.1, record[:2])),
            oscillator(ss.Record(0.2, record)),
            oscillator(ss.Record(0.1, record), omega=2.1),
            oscillator(ss.Record(0.1, record), u0=2.0),
            ss.scene("linear_oscillator", omega=2.0, a0=1.0, load=ss.Record(0.1, record)),
        ],
    )
    assert_distinguished(
        (ss.scene("elastic_pendulum", EA=1e4), ss.scene("elastic_pendulum", EA=1e4, strain="green_lagrange")),
        [ss.scene("elastic_pendulum", EA=1e4, strain="engineering")],
    )


def test_own_scenes_are_equal_by_what_is_declared(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    assert_distinguished((ss.scene(own_scene(4)), ss.scene(own_scene(4), k=1.0)), [ss.scene(own_scene(6))])


def test_a_response_is_equal_to_itself_alone() -> None:
    run = [ss.march(ss.scene("linear_oscillator", omega=2.0), ss.scheme("bathe"), 0.1, 1.0) for _ in range(2)]
    assert run[0] != run[1]
    assert len({*run}) == 2


def test_a_handle_is_printed_with_its_parameters() -> None:
    assert repr(ss.scheme("newmark", beta=[0.25, 0.3])) == "Scheme(newmark, beta=[0.25, 0.3], gamma=0.5)"


LOADED = ss.scene("linear_oscillator", omega=2.0, load=ss.Record(0.1, np.arange(50.0)), a0="consistent")
KEPT: dict[str, Any] = {
    **{name: ss.scheme(name) for name in SCHEMES},
    "given parameters": ss.scheme("newmark_bdf2", gamma_t=0.2, beta=0.3025, gamma=0.6),
    "a family": ss.scheme("generalized_alpha", rho_inf=0.3),
    "arrays": ss.scheme("newmark", beta=[0.25, 0.3]),
    **{f"scene {name}": ss.scene(name, EA=1e4) for name in ("elastic_pendulum", "elastic_pendulum_engineering")},
    **{f"scene {name}": ss.scene(name) for name in ("duffing", "softening", "bathe_noh", "penalty_bounce")},
    "loaded": LOADED,
    **{type(load).__name__: load for load in (ss.Harmonic(1.0, 2.0), ss.Step(1.0), ss.HalfSine(1.0, 2.0), LOADED.load)},
}
WAYS: dict[str, Callable[[Any], Any]] = {
    "pickle": lambda x: pickle.loads(pickle.dumps(x)),
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
}


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("kept", KEPT)
def test_handles_survive_copies(kept: str, way: str) -> None:
    original = KEPT[kept]
    found = WAYS[way](original)
    assert found == original
    assert hash(found) == hash(original)
    assert repr(found) == repr(original)
    assert len(repr(original)) < 200
    if isinstance(original, ss.Scheme):
        assert [*found.given] == [*original.given]
        assert not any(x.flags.writeable for x in found.parameters.values())
    if isinstance(original, ss.Scene):
        assert found.a0_asked == original.a0_asked


def test_own_handles_survive_pickling(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SUBSTEP_CACHE", str(tmp_path / "cache"))
    for own in (ss.scheme(declared(Rational(1, 4)), gamma=0.7), ss.scene(own_scene(4), k=2.0)):
        for way in WAYS.values():
            assert way(own) == own


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("way", WAYS)
def test_responses_and_structures_survive_copies(way: str) -> None:
    frame = ss.structure(np.eye(2), np.diag([1.0, 4.0]), u0=1.0, load=([1.0, 0.0], ss.Step(1.0)))
    runs = [ss.march(scene, "bathe", 0.1, 1.0) for scene in (LOADED, ss.scene("duffing"), frame, frame.modes(1))]
    for r in [*runs, ss.march(frame, "bathe", tol=1e-2, t_end=0.5)]:
        r.a  # which is kept once it was computed
        found = WAYS[way](r)
        assert all(np.array_equal(getattr(found, name), getattr(r, name)) for name in ("t", "u", "v", "a"))
        assert (found.status, found.scheme, repr(found)) == (r.status, r.scheme, repr(r))
    again = WAYS[way](frame)
    assert np.array_equal(ss.march(again, "bathe", 0.1, 1.0).u, runs[2].u)
    assert np.array_equal(
        ss.march(WAYS[way](frame.modes(2)), "bathe", 0.1, 1.0).u, ss.march(frame.modes(2), "bathe", 0.1, 1.0).u
    )


def test_a_response_is_printed_in_one_line() -> None:
    r = ss.march("duffing", "bathe", dt=0.1, t_end=1.0)
    assert repr(r) == f"Response({ss.scheme('bathe')} on {ss.scene('duffing')}, 11 rows to t = 1 s, completed)"
    frame = ss.structure(np.eye(2), np.eye(2))
    text = "Structure(2 free of 2 degrees of freedom, 0 loads)"
    assert repr(ss.march(frame, "bathe", 0.1, 1.0)) == (
        f"StructureResponse(Scheme(bathe) on {text}, 11 rows to t = 1 s, completed)"
    )


def test_the_version_is_that_of_the_package() -> None:
    pyproject = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text(encoding="utf-8"))
    assert ss.__version__ == pyproject["project"]["version"]
    with pytest.raises(AttributeError, match="no attribute 'verison'"):
        ss.verison  # pyright: ignore


STRUCTURE = ss.structure(np.eye(30), np.eye(30))
SHORT: dict[str, Callable[[], object]] = {
    "scheme": lambda: ss.scheme("bathe"),
    "arrays": lambda: ss.scheme("newmark", beta=np.linspace(0.25, 0.3, 500)),
    "scene": lambda: ss.scene("elastic_pendulum", EA=1e4),
    "response": lambda: ss.march("duffing", "bathe", 0.1, 10.0),
    "structure": lambda: ss.march(STRUCTURE, "bathe", 0.1, 10.0),
    "modes": lambda: STRUCTURE.modes(5),
    "spectrum": lambda: ss.response_spectrum_analysis(STRUCTURE.modes(5), lambda T, xi: np.ones(5), 1.0),
}


@pytest.mark.parametrize("kind", SHORT)
def test_what_is_printed_of_a_handle_is_short(kind: str) -> None:
    text = repr(SHORT[kind]())
    assert len(text) < 160
    assert "\n" not in text
    assert "array(" not in text
