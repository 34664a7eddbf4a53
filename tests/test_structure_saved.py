"""Marches of structures on disk: they go on where they were stopped, know each other, and are asked as others are."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from scipy.sparse.linalg import LinearOperator
from small_frame import PUSH, RECORD, K, M, frame

import substep as ss


@pytest.mark.parametrize("scheme", ["bathe", "houbolt", "kr_alpha"])
def test_a_march_on_disk_goes_on_where_it_was_stopped(tmp_path: Any, scheme: str, monkeypatch: Any) -> None:
    monkeypatch.setattr("substep.structures.march.saved.BUFFER", 60)  # numbers: a checkpoint every few rows
    solved = [0]

    def march(count: float, **more: Any) -> Any:
        solved[0] = 0

        def solver(A: Any) -> Any:
            def solve(b: Any) -> Any:
                solved[0] += 1
                if solved[0] > count:
                    raise KeyboardInterrupt
                return np.linalg.solve(A, b)

            return solve

        damped = frame(C=ss.Rayleigh(0.1, 0.01), load=([1.0, 0.0, 0.0], np.sin), solver=solver)
        return ss.march(damped, scheme, 0.1, 8.0, stride=2, **more)

    whole = march(np.inf)
    stopped = march(50, save=tmp_path / "run")
    assert stopped.status == "interrupted"
    assert 3 < len(stopped.u) < len(whole.u)
    finished = march(np.inf, save=tmp_path / "run")
    again = march(np.inf, save=tmp_path / "run")
    for r in (finished, again):
        same(r, whole)
    with pytest.raises(ValueError, match="another path"):
        ss.march(frame(), scheme, 0.1, 8.0, save=tmp_path / "run")


def hardening(factor: float, **more: Any) -> ss.Structure:
    return ss.structure(
        M, internal_force=lambda u: K @ u + factor * u**3, tangent=lambda u: K + np.diag(3.0 * factor * u**2), **more
    )


@pytest.mark.parametrize("start", [{"u0": [0.1, 0.0, 0.2]}, {"v0": 0.1}, {"load": PUSH}], ids=["u0", "v0", "load"])
def test_another_internal_force_is_another_march(tmp_path: Any, start: dict[str, Any]) -> None:
    """Also where its tangent at the start is the same."""
    first = ss.march(hardening(2.0, **start), "bathe", 0.1, 1.0, save=tmp_path / "run")
    again = ss.march(hardening(2.0, **start), "bathe", 0.1, 1.0, save=tmp_path / "run")
    assert np.array_equal(first.u, again.u)
    with pytest.raises(ValueError, match="another path"):
        ss.march(hardening(2.001, **start), "bathe", 0.1, 1.0, save=tmp_path / "run")


@pytest.mark.filterwarnings("ignore:.* has (dissipated|gained)")
@pytest.mark.parametrize("newton", ["simplified", "full"])
@pytest.mark.parametrize("scheme", ["bathe", "houbolt", "energy_momentum"])
def test_a_nonlinear_march_goes_on_to_the_bit(tmp_path: Any, scheme: str, newton: Any, monkeypatch: Any) -> None:
    """A tangent that is kept is taken again where it was taken."""
    monkeypatch.setattr("substep.structures.march.saved.BUFFER", 90)
    calls = [0]

    def march(count: float, t_end: float = 3.0, **more: Any) -> Any:
        calls[0] = 0

        def potential(u: Any) -> Any:
            calls[0] += 1
            if calls[0] > count:
                raise KeyboardInterrupt
            return 0.5 * u @ K @ u + 12.5 * np.sum(u**4)

        stiffening = hardening(50.0, v0=3.0, potential=potential, load=([1.0, 0.0, 0.0], np.sin))
        return ss.march(stiffening, scheme, 0.1, t_end, newton=newton, **more)

    whole = march(np.inf)
    stopped = march(0.6 * calls[0], save=tmp_path / "run")  # the account takes the potential in each step
    assert stopped.status == "interrupted"
    assert 3 < len(stopped.u) < len(whole.u)
    same(march(np.inf, save=tmp_path / "run"), whole)
    march(np.inf, 1.3, save=tmp_path / "another")
    same(march(np.inf, save=tmp_path / "another"), whole)


def same(found: Any, expected: Any) -> None:
    """To the bit."""
    assert found.status == "completed"
    for name in ("u", "v", "a", "energy", "newton_iterations"):
        assert np.array_equal(getattr(found, name), getattr(expected, name)), name
    assert np.array_equal(found.account.numerical, expected.account.numerical)


def rod(u: Any) -> tuple[float, Any]:
    return (u @ u - 1.0) / 2.0, u.copy()


def touching(kind: str, **more: Any) -> ss.Structure:
    """Masses that meet a stop, once or again and again, or rub, or hang from a rod."""
    pulled: dict[str, Any] = {"load": ([1.0, 0.0, 0.0], lambda t: 3.0 * np.sin(2.0 * t))}
    pad, stop = {"friction": {"pad": ([0.0, 1.0, 0.0], 0.3)}}, {"contacts": {"stop": ({2: -1.0}, 0.05)}}
    given: dict[str, Any] = {
        "stop": stop, "remembered": {**stop, "remembered": True}, "bounces": {**stop, "restitution": 0.5}, "rubs": pad,
        "both": {**stop, **pad, "restitution": 0.2},
        "yields": {**stop, "springs": [({0: 1.0}, ss.law("bilinear", k=5.0, q_y=0.4))]},
    }  # fmt: skip
    if kind == "rod":
        return ss.structure(
            np.eye(2),
            np.zeros((2, 2)),
            u0=[1.0, 0.0],
            load=({1: -9.81}, np.ones_like),
            **{"constraints": {"rod": rod}, **more},
        )
    return ss.structure(M, K, **{**pulled, **given[kind], **more})


@pytest.mark.filterwarnings("ignore:.* has (dissipated|gained)")
@pytest.mark.parametrize(
    ("kind", "scheme"),
    [
        *product(["stop", "remembered", "rubs", "yields"], ["average_acceleration", "bathe", "generalized_alpha"]),
        *product(["stop", "bounces", "rubs", "both", "yields"], ["central_difference"]),
        ("bounces", "average_acceleration"), ("both", "average_acceleration"), ("both", "generalized_alpha"),
        ("rod", "bathe"), ("rod", "generalized_alpha"),
    ],
)  # fmt: skip
def test_what_touches_goes_on_to_the_bit(tmp_path: Any, kind: str, scheme: str) -> None:
    """From ends where reactions act, which the next step takes."""
    whole = ss.march(touching(kind), scheme, 0.02, 6.0, stride=2)
    assert whole.touched is not None
    acting = whole.t[np.any(whole.touched[:, 0] != 0.0, axis=1)]
    ends = *np.quantile(acting[acting < 6.0], [0.1, 0.6], method="nearest"), 6.0, 6.0
    *_, found = (ss.march(touching(kind), scheme, 0.02, end, stride=2, save=tmp_path / "run") for end in ends)
    same(found, whole)
    assert np.array_equal(found.touched, whole.touched)
    more = ss.march(touching(kind), scheme, 0.02, 7.0, start=found.state, account=False)
    assert np.array_equal(more.u, ss.march(touching(kind), scheme, 0.02, 7.0, start=whole.state, account=False).u)


def test_other_contacts_are_another_march(tmp_path: Any) -> None:
    scheme = "average_acceleration"
    ss.march(touching("both"), scheme, 0.02, 1.0, save=tmp_path / "run")
    for other in (
        {"restitution": 0.3},
        {"contacts": {"stop": ({2: -1.0}, 0.06)}},
        {"friction": {"pad": ({1: 1.0}, 0.2)}},
    ):
        with pytest.raises(ValueError, match="contacts; give save another path"):
            ss.march(touching("both", **other), scheme, 0.02, 1.0, save=tmp_path / "run")
    ss.march(touching("rod"), "bathe", 0.02, 1.0, save=tmp_path / "rod")
    with pytest.raises(ValueError, match="constraints; give save another path"):
        longer = {"rod": lambda u: (rod(u)[0] * (1.0 + u[1]), rod(u)[1] * (1.0 + u[1]) + np.array([0.0, rod(u)[0]]))}
        ss.march(touching("rod", constraints=longer), "bathe", 0.02, 1.0, save=tmp_path / "rod")


@pytest.mark.filterwarnings("ignore:.* has (dissipated|gained)")
def test_an_account_goes_on_to_the_bit_where_a_force_takes_velocities(tmp_path: Any) -> None:
    def march(t_end: float, **more: Any) -> Any:
        drag = ss.structure(
            M, internal_force=lambda u, v: K @ u + v * np.abs(v), tangent=lambda u, v: (K, np.diag(2.0 * np.abs(v))),
            v0=1.0,
        )  # fmt: skip
        return ss.march(drag, "generalized_alpha", 0.1, t_end, **more)

    whole = march(4.0)
    march(1.5, save=tmp_path / "run")
    same(march(4.0, save=tmp_path / "run"), whole)


@pytest.mark.parametrize("start", [{"u0": 0.1}, {"u0": 0.0, "load": PUSH}], ids=["drawn", "pushed"])
def test_forces_that_differ_in_their_damping_only_are_two_marches_also_from_rest(tmp_path: Any, start: Any) -> None:
    def march(c: float, t_end: float = 1.0) -> Any:
        drag = ss.structure(M, internal_force=lambda u, v: K @ u + c * v, tangent=lambda u, v: (K, c * M), **start)
        return ss.march(drag, "bathe", 0.1, t_end, save=tmp_path / "run", account=False)

    march(0.1)
    assert march(0.1, 2.0).status == "completed"
    with pytest.raises(ValueError, match="internal force"):
        march(0.2, 3.0)


@pytest.mark.filterwarnings("ignore:.* has (dissipated|gained)")
@pytest.mark.parametrize("scheme", list(BY_NAME))
def test_a_saved_march_is_continued_to_a_later_end(tmp_path: Any, scheme: str) -> None:
    """Of every scheme, also from an end within the steps that another scheme marches for it."""
    loaded = frame(load=[PUSH, ([1.0, 0.0, 0.0], np.sin)])
    arguments = {"dt": 0.1, "stride": 2}
    for t_end in (0.2, 1.1, 3.0):
        found = ss.march(loaded, scheme, t_end=t_end, save=tmp_path / "run", **arguments)
        same(found, ss.march(loaded, scheme, t_end=t_end, **arguments))


def test_what_differs_from_a_saved_march_is_said(tmp_path: Any) -> None:
    path = tmp_path / "run"
    call: dict[str, Any] = {"scheme": "bathe", "dt": 0.1, "t_end": 2.0, "save": path}
    ss.march(frame(load=PUSH), **call)
    for changed, message in (
        (
            {"scheme": "newmark"},
            r"another scheme \(Scheme\(bathe\) there, Scheme\(newmark, .* here\); give save another",
        ),
        ({"dt": 0.05}, r"another dt \(0.1 there, 0.05 here\); give"),
        ({"dofs": [1]}, r"another dofs \(\[0, 1, 2\] there, \[1\] here\)"),
        ({"stride": 2, "account": False}, r"another stride \(1 there, 2 here\), account \(True there, False here\)"),
        ({"t_end": 1.0}, "t_end of at least 2, which the march .* has reached, got 1;"),
    ):
        with pytest.raises(ValueError, match=message):
            ss.march(frame(load=PUSH), **{**call, **changed})
    for structure, what in (
        (frame(), "loads"),
        (frame(load=PUSH, u0=0.0), "start"),
        (frame(load=PUSH, C=ss.Rayleigh(0.1, 0.0)), "C"),
        (frame(load=PUSH, names=("a", "b", "c")), "names"),
        (replace(frame(load=PUSH), K=2.0 * K), "K"),
    ):
        with pytest.raises(ValueError, match=f"got another {what}; give save another path, or remove"):
            ss.march(structure, **call)
    (tmp_path / "folder").mkdir()
    (tmp_path / "file").write_text("mine")
    for other in ("folder", "file"):
        with pytest.raises(ValueError, match="expected a saved march or nothing at .*something else"):
            ss.march(frame(), **{**call, "save": tmp_path / other})


def test_damping_that_is_known_by_its_products_is_recognised_by_these(tmp_path: Any) -> None:
    def damped(factor: float) -> ss.Structure:
        return frame(load=PUSH, C=LinearOperator(M.shape, matvec=lambda x: factor * x, dtype=np.float64))

    call: dict[str, Any] = {"dt": 0.1, "save": tmp_path / "run", "account": False}
    ss.march(damped(0.1), "bathe", t_end=1.0, **call)
    with pytest.raises(ValueError, match="got another C; give save another path"):
        ss.march(damped(9.0), "bathe", t_end=2.0, **call)
    assert ss.march(damped(0.1), "bathe", t_end=2.0, **call).status == "completed"


@pytest.mark.parametrize("scheme", ["bathe", "rk4"])
def test_histories_beyond_the_limit_stay_on_disk(tmp_path: Any, scheme: str, monkeypatch: Any) -> None:
    """All that is asked of them is that of histories in memory, also of a run that was stopped."""
    monkeypatch.setattr("substep.structures.march.saved.BUFFER", 60)
    limit = [0.55]

    def load(t: Any) -> Any:
        if np.size(t) == 1 and np.max(t) > limit[0]:
            raise KeyboardInterrupt
        return np.sin(t)

    moved = frame(load=([1.0, 0.0, 0.0], load)).ground_motion(RECORD, 1.0)
    monkeypatch.setattr("substep.structures.march.fixed_steps.BLOCK", 1)  # loads are asked for step by step
    for status in ("interrupted", "completed"):
        expected = ss.march(moved, scheme, 0.1, 1.0)
        with monkeypatch.context() as patched:
            patched.setattr("substep.structures.march.saved.IN_MEMORY", 0)
            found = ss.march(moved, scheme, 0.1, 1.0, save=tmp_path / "run")
        assert found.status == expected.status == status
        assert not isinstance(found.u, np.ndarray)
        for name in ("t", "u", "v", "a", "absolute_a"):
            assert np.array_equal(np.asarray(getattr(found, name)), getattr(expected, name)), name
        assert found.to_xarray().equals(expected.to_xarray())
        assert repr(found) == repr(expected)
        limit[0] = np.inf


@pytest.mark.parametrize("scheme", ["houbolt", "newmark", "generalized_alpha"])
@pytest.mark.parametrize("nonlinear", [False, True])
def test_a_saved_march_that_is_complete_goes_on_as_if_it_had_just_been_made(
    scheme: str, nonlinear: bool, tmp_path: Any
) -> None:
    """Also with the tangent that an iteration has kept, and where only some degrees of freedom were."""
    K = np.array([[2.0, -1.0], [-1.0, 1.0]])
    force: dict[str, Any] = {"internal_force": lambda u: K @ u + u**3, "tangent": lambda u: K + np.diag(3.0 * u**2)}
    model = ss.structure(np.eye(2), **force if nonlinear else {"K": K}, u0=[1.0, 0.0])
    call: dict[str, Any] = {"dt": 0.1, "account": False}
    again = [ss.march(model, scheme, **call, t_end=1.0, dofs=[1], save=tmp_path / "store") for _ in range(3)][-1]
    then = ss.march(model, scheme, **call, t_end=2.0, start=again)
    assert np.array_equal(then.u, ss.march(model, scheme, **call, t_end=2.0).u[10:])
