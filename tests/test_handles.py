"""Handles of schemes and scenes: what the index says of them, when two are equal, and what marches the first steps."""

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
from substep_kernels.scenes import SCENES
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
    with pytest.raises(ValueError, match="expected a value for EA of elastic_pendulum, got none; add EA="):
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
