"""What a program can and cannot do: each ability that an adapter declares is used, and each lack of one is survived."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from audited_steppers import generalized_alpha, trapezoidal_load
from substep_audit.claims import judged
from substep_audit.defaults import written_out
from substep_audit.history import states_before
from substep_audit.identify import Match, agreement, identify, levels
from substep_audit.loads import load_taking
from substep_audit.measured_stability import eigenvalues, tolerance_of
from substep_audit.orders import observed_orders
from substep_audit.probes import driven_runs, own_runs
from substep_audit.programs.adapter import Integrator, Load

import substep as ss

pytestmark = pytest.mark.usefixtures("few_members")

TRAPEZOIDAL = "newmark(beta = 1/4, gamma = 1/2)"
STEPS = trapezoidal_load(0, 0, 1)
FEW = (0.3, 1.0, 3.0)  # Omega

ONE_RUN = '''
"""The average acceleration method in a program that knows one model only, and cannot begin again."""
from adapter import Integrator, serve

models = []


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    models.append(omega)
    if len(models) > 1:
        raise RuntimeError("there is a model already")
    rows = [(u0, v0, load(0.0) - 2 * xi * omega * v0 - omega**2 * u0)]
    for i in range(n):
        u, v, a = rows[-1]
        p, q = u + dt * v + dt**2 / 4 * a, v + dt / 2 * a
        z = (load((i + 1) * dt) - 2 * xi * omega * q - omega**2 * p) / (1 + xi * omega * dt + (omega * dt / 2) ** 2)
        rows.append((p + dt**2 / 4 * z, q + dt / 2 * z, z))
    return zip(*rows)


serve("One", "1.0", "none", {"told": Integrator(one_run=True), "untold": Integrator()}, run)
'''


def is_a(stepper: ss.Stepper, omegas: tuple[float, ...] = FEW) -> Match:
    """The first of the schemes that it is found to be."""
    own = own_runs(stepper, omegas)
    return identify(own, own).matches[0]


def test_a_program_of_one_model_a_process_has_a_process_a_run(tmp_path):
    (tmp_path / "one.py").write_text(ONE_RUN)
    with ss.Program(str(tmp_path / "one.py")) as program:
        assert is_a(program.stepper("told"), (1.0, 3.0)).text == TRAPEZOIDAL
        stepper = program.stepper("untold")
        with pytest.raises(ValueError, match="there is a model already"):
            own_runs(stepper, (1.0,), (0.0,))
    with pytest.raises(ValueError, match="expected a program with an adapter"):
        ss.Program(str(tmp_path / "none.py"))


def at_rest(can: str) -> Callable[..., Any]:
    """The average acceleration method, which refuses what it cannot be given."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load) -> Any:
        assert ("u" in can or u0 == 0.0) and ("v" in can or v0 == 0.0)
        return STEPS(omega, xi, dt, n, u0, v0, load)

    return run


@pytest.mark.parametrize("can", ["", "u", "v"])
def test_a_program_that_starts_from_rest_is_identified_by_superposition(can):
    stepper, whole = ss.Stepper(at_rest(can), Integrator(sets=can)), ss.Stepper(STEPS)
    for load in (Load(), Load("harmonic", 1.0, 1.3, 0.9)):
        given = 2.0, 0.1, 0.3, 9, 1.0, 0.7, None
        ours, theirs = (s.histories(*given, replace(load, called=[])) for s in (stepper, whole))
        np.testing.assert_allclose(ours, theirs, atol=1e-13)
    assert is_a(stepper).text == TRAPEZOIDAL
    assert {order[0] for order in observed_orders(stepper).values()} == {2.0}


def test_an_absolute_tolerance_hides_no_digits():
    """Results that are right to 1e-6 only, whatever their size."""

    def run(*given: Any, **named: Any) -> Any:
        return np.round(STEPS(*given, **named), 6)

    told, untold = (ss.Stepper(run, Integrator(absolute=x)) for x in (1e-6, 0.0))
    assert is_a(told).text == TRAPEZOIDAL and is_a(told).error < 1e-13
    own = own_runs(untold, FEW)
    match = agreement(ss.scheme("newmark"), own, own)
    assert match is None or match.error > 1e-9


def test_single_precision_is_survived_and_stated():
    report = ss.audit(generalized_alpha(0, 0, 0.25, 0.5, dtype=np.float32), ss.Claims("newmark"))
    assert report.matches[0].text == TRAPEZOIDAL
    assert [(cause.kind, cause.text) for cause in report.deviations] == [("precision", "results hold 7 digits")]


def leapfrog(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load) -> Any:
    """Central differences, undamped, with velocities half a step before the displacements."""
    u, v = [u0], [v0 - dt / 2 * (load(0.0) - omega**2 * u0)]
    for i in range(n):
        v.append(v[-1] + dt * (load(i * dt) - omega**2 * u[-1]))
        u.append(u[-1] + dt * v[-1])
    return u, v, None


@pytest.mark.thorough
@pytest.mark.parametrize("wrong", [False, True])
def test_velocities_at_half_steps_are_compared_by_the_means_of_neighbours(wrong):
    """Declared as such, they are no deviation, and neither are others, of which it is told that they are not found."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load) -> Any:
        u, v, a = leapfrog(omega, xi, dt, n, u0, v0, load)
        return u, [x * (1.01 if wrong else 1.0) for x in v], a

    report = ss.audit(ss.Stepper(run, Integrator(outputs="uv", late={"v": -0.5}, damping=False)))
    assert "central_difference" in {match.scheme.name for match in report.matches} and not report.deviations
    assert report.instants == ({} if wrong else {"v": -0.5}) and not report.energy
    assert [line.partition(",")[0] for line in report.left_out] == (
        ["v: stands -0.5 steps from the end of its step"] if wrong else []
    )


@pytest.mark.parametrize("late", [-1, 1])
@pytest.mark.parametrize("calls", [1, 2])
def test_what_is_late_by_whole_steps_is_moved_to_where_it_stands(late, calls):
    """Of runs of the average acceleration method, or of Bathe's method in two calls a step, of which v is late."""
    steps = composite if calls == 2 else STEPS

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load) -> Any:
        u, v, a = map(np.array, steps(omega, xi, dt, n + calls, u0, v0, load))
        before = np.concatenate([np.full(calls, 7.0), v[: 1 - calls or None]])
        return u[: n + 1], before[: n + 1] if late == -1 else v[calls:], a[: n + 1]

    given = 2.0, 0.1, 0.3, 9, 1.0, 0.7, None, Load()
    whole = ss.Stepper(steps, Integrator(calls=calls)).histories(*given)
    moved = ss.Stepper(run, Integrator(calls=calls, late={"v": late})).histories(*given)
    if late == 1:
        assert np.isnan(moved[0, 1])
        moved[0, 1] = 0.7
    np.testing.assert_array_equal(moved, whole)


def composite(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load) -> Any:
    """Bathe's method as two calls a step: the average acceleration method, then three-point backward differences."""
    k, c, rows = omega**2, 2 * xi * omega, [(u0, v0, load(0.0) - 2 * xi * omega * v0 - omega**2 * u0)]
    for i in range(1, n + 1):
        u, v, a = rows[-1]
        if i % 2:
            p, q, b, g = u + dt * v + dt**2 / 4 * a, v + dt / 2 * a, dt**2 / 4, dt / 2
        else:
            w, x, _ = rows[-2]
            g = 2 * dt / 3
            q = (4 * v - x) / 3
            p, b = (4 * u - w) / 3 + g * q, g * g
        z = (load(i * dt) - c * q - k * p) / (1 + c * g + k * b)
        rows.append((p + b * z, q + g * z, z))
    return zip(*rows, strict=True)


def test_two_calls_make_one_step_of_a_composite_scheme():
    assert is_a(ss.Stepper(composite, Integrator(calls=2))).scheme.name == "bathe"


def started_otherwise(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load) -> Any:
    """The average acceleration method after five steps of backward Euler."""
    u, v, rows = u0, v0, [(u0, v0, load(0.0) - 2 * xi * omega * v0 - omega**2 * u0)]
    for i in range(1, min(n, 5) + 1):
        v = (v + dt * (load(i * dt) - omega**2 * u)) / (1 + 2 * xi * omega * dt + (omega * dt) ** 2)
        u += dt * v
        rows.append((u, v, load(i * dt) - 2 * xi * omega * v - omega**2 * u))
    for i in range(len(rows), n + 1):
        u, v, a = rows[-1]
        p, q = u + dt * v + dt**2 / 4 * a, v + dt / 2 * a
        z = (load(i * dt) - 2 * xi * omega * q - omega**2 * p) / (1 + xi * omega * dt + (omega * dt / 2) ** 2)
        rows.append((p + dt**2 / 4 * z, q + dt / 2 * z, z))
    return zip(*rows, strict=True)


def test_first_steps_of_another_scheme_are_left_out():
    told, untold = (ss.Stepper(started_otherwise, Integrator(startup=n)) for n in (5, 0))
    match = is_a(told)
    assert match.text == TRAPEZOIDAL and match.start == "own"
    assert load_taking(match, driven_runs(told)).text == "f(t_n + h)"
    found = [eigenvalues(own_runs(s, (1.0,), (0.0,)), 0, tolerance_of(s)).roots for s in (told, untold)]
    assert [len(roots) for roots in found] == [2, 4]
    own = own_runs(untold, FEW)
    match = agreement(ss.scheme("newmark"), own, own)
    assert match is None or match.what != "matrix"


def bdf2(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Load, before: Any) -> Any:
    """Second-order backward differences of u and v, from one state before t = 0."""
    assert len(before) == 1
    rows = [tuple(before[0]), (u0, v0, load(0.0) - 2 * xi * omega * v0 - omega**2 * u0)]
    g = 2 * dt / 3
    for i in range(1, n + 1):
        (w, x, _), (u, v, _) = rows[-2:]
        p, q = (4 * u - w) / 3, (4 * v - x) / 3
        z = (load(i * dt) - 2 * xi * omega * q - omega**2 * (p + g * q)) / (1 + 2 * xi * omega * g + (omega * g) ** 2)
        rows.append((p + g * (q + g * z), q + g * z, z))
    return zip(*rows[1:], strict=True)


def test_a_history_before_the_start_is_supplied():
    stepper = ss.Stepper(bdf2, Integrator(history=1))
    assert is_a(stepper).scheme.name == "bdf2"
    assert {order[0] for order in observed_orders(stepper).values()} == {2.0}


def test_of_u_alone_a_scheme_started_otherwise_is_found_by_its_recursion():
    """What u shows then is the scheme's: no eigenvalues of another one, and no reason to doubt the claim."""
    own = own_runs(ss.Stepper(bdf2, Integrator(history=1, outputs="u")), FEW)
    assert levels(own) == ("matrix", "recursion")
    found = identify(own, own, ss.scheme("bdf2"), whats=("recursion",))
    assert (found.matches[0].text, found.matches[0].what, found.matches[0].start) == ("bdf2", "recursion", "own")
    assert judged(ss.Claims("bdf2"), found, {}, 0.0, None)[0].verdict == "true"
    assert levels(own_runs(ss.Stepper(bdf2, Integrator(history=1)), FEW[:1])) == (
        "matrix", "displacements", "spectrum"
    )  # fmt: skip


@pytest.mark.parametrize(
    ("weights", "text"),
    [
        ({1.0: 1.0}, "f(t_n + h)"),
        ({0.5: 1.0}, "f(t_n + 1/2 h)"),
        ({0.0: 0.25, 1.0: 0.75}, "1/4 f(t_n) + 3/4 f(t_n + h)"),
        ({0.3: 1.0}, "f(t_n + 3/10 h)"),
        ({-2.0: 1.0}, "at no fixed instants that were found"),
    ],
)
@pytest.mark.parametrize("asks", [False, True])
def test_of_u_alone_the_recursion_tells_the_load(weights, text, asks):
    """Whatever the first steps are: what the load adds to the recursion knows nothing of them."""

    def run(omega: float, xi: float, dt: float, n: int, u0: float, v0: float, load: Any, before: Any) -> Any:
        taken = load if asks else load.at
        return bdf2(
            omega, xi, dt, n, u0, v0, lambda t: sum(w * taken(t + (x - 1) * dt) for x, w in weights.items()), before
        )

    stepper = ss.Stepper(run, Integrator(history=1, outputs="u"))
    own = own_runs(stepper, FEW)
    found = identify(own, own, ss.scheme("bdf2"), whats=("recursion",))
    taking = load_taking(found.matches[0], driven_runs(stepper))
    if 0.3 in weights and not asks:  # nothing says at which instants to look
        text = "at no fixed instants that were found"
    assert taking.text.partition(";")[0] == text
    assert taking.start == ("computed" if taking.kind == "unknown" else "own")


@pytest.mark.parametrize("kind", ["none", "constant", "ramp", "harmonic"])
def test_states_before_the_start_are_those_of_the_motion(kind):
    """From the earliest of them, steps of the fourth order by Runge and Kutta come back to the start."""
    omega, xi, h, rows = 1.7, 0.1, 0.3, 3
    load = Load(kind, 0.8, 1.3, 0.4, offset=0.2, slope=-0.3)
    states = states_before(omega, xi, h, rows, 1.0, 0.7, load)

    def rate(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([y[1], load.at(t) - 2 * xi * omega * y[1] - omega**2 * y[0]])

    m = 600
    t, y, d = -rows * h, states[-1, :2], rows * h / m
    for _ in range(m):
        a = rate(t, y)
        b = rate(t + d / 2, y + d / 2 * a)
        c = rate(t + d / 2, y + d / 2 * b)
        t, y = t + d, y + d / 6 * (a + 2 * b + 2 * c + rate(t + d, y + d * c))
    np.testing.assert_allclose(y, [1.0, 0.7], atol=1e-11)
    assert states[0, 2] == pytest.approx(rate(-h, states[0, :2])[1], abs=1e-13)


def test_instants_of_calls_are_those_of_programs_that_call():
    called = {}
    for given in ("function", "samples"):
        runs = driven_runs(ss.Stepper(STEPS, Integrator(load=given)))
        called[given] = load_taking(is_a(ss.Stepper(STEPS)), runs).called
    assert called == {"function": (0.0, 0.5), "samples": ()}


def test_long_motion_is_left_out_of_a_program_whose_steps_are_dear():
    stepper = ss.Stepper(STEPS, Integrator(seconds=1.0))
    report = ss.audit(stepper, ss.Claims("newmark"))
    assert not report.energy and not report.growth and not report.deviations
    assert "left out   long free motion" in report.text
    assert ss.audit(STEPS).energy


@pytest.mark.parametrize(
    ("defaults", "text"),
    [
        ({"beta": 0.3025, "gamma": 0.6}, "the same with beta = 0.3025, gamma = 0.6 written out, to "),
        ({"gamma": 0.6, "beta": 0.3025}, "it is then newmark(beta = 3/5, gamma = 121/400)"),
        ({"beta": 0.3, "gamma": 0.6}, "it is then newmark(beta = 3/10, gamma = 3/5)"),
    ],
    ids=["same", "swapped", "few digits"],
)
def test_defaults_are_run_as_such_and_written_out(defaults, text):
    """A program that takes its two arguments by their places."""

    def run(values: tuple[float, ...]) -> Callable[..., Any]:
        return generalized_alpha(0.0, 0.0, *(values or (0.3025, 0.6)))

    stepper = ss.Stepper(run(()), Integrator(defaults=defaults), written_out=run(tuple(defaults.values())))
    own = own_runs(stepper, FEW)
    found = written_out(stepper, agreement(ss.scheme("newmark"), own, own))
    assert found is not None and text in found.text
    assert found.same == (not found.deviations) == text.startswith("the same")
    assert written_out(ss.Stepper(STEPS), None) is None


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"load": "sample"}, "expected a load that is one of function, each step"),
        ({"sets": "ux"}, "expected sets of the letters u, v and a, got 'ux'"),
        ({"outputs": "va"}, "expected displacements at the ends of the steps"),
        ({"late": {"u": 1.0}}, "expected displacements at the ends of the steps"),
        ({"sets": "u", "load": "none"}, "expected an integrator that sets u and v"),
    ],
)
def test_abilities_that_no_program_has_are_refused(wrong, text):
    with pytest.raises(ValueError, match=text):
        Integrator(**wrong)
