"""How far the energy of free motion of a structure may rise above that at the start, for a while.

The energy is (v^T M v + u^T K u)/2, motion begins with any u_0, v_0 and the consistent a_0, and M, C, K are any on
which the scheme is stable. Three arguments decide it, in which y = (u, v) in the energy norm:

- ||R(h L)|| <= 1 (`structures`): it never rises.
- A method of two steps that is G-stable has g |y_n|^2 <= |Y_n|_G^2 <= |Y_1|_G^2 with g = g_22 - g_12^2/g_11, the least
  of the form over the older y, and |Y_1|_G^2 <= (g_11 + 2 |g_12| + g_22) |y_0|^2 where the start does not let it rise.
- Where every step is allowed and the first step of an undamped oscillator grows with a power of Omega (its overshoot),
  no bound holds for all structures.

Where none applies it is open, and small structures are searched, in floating point.
"""

from itertools import islice
from math import sqrt
from typing import Any

from sympy import Rational

from ..algebra.algebraic import Field
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import kind_of, knot, steps_back
from ..oscillator.evaluation import Evaluation
from ..oscillator.overshoot import overshoot
from .structure_form import MultiStepForm, OperatorForm, Rows
from .structure_growth import Structure, candidates, step_matrix

STRUCTURES, STEPS = 24, 48  # that are searched, and how long each moves
Numbers = list[list[float]]


def transient(parameters: ParameterSet, rows: Rows, *, every_step: bool, bound: Any) -> str:
    """The verdict in words. every_step: stable on every structure at every step; bound: else, of `structures`, or None.

    Rows are those of the scheme at the parameters.
    """
    if never_rises(rows):
        return "none: the energy of free motion never exceeds that at the start, with any damping."
    if every_step:
        most = of_two_steps(rows)
        if most is not None:
            return f"bounded: the energy is at most {most} times that at the start, by G-stability."
        found = overshoot(Evaluation.at(parameters))
        if found.u or found.v:
            return (
                f"unbounded: the first step of an undamped oscillator has the overshoot {found}, powers of Omega with "
                "which u_1 and v_1/omega grow as Omega -> oo."
            )
    return searched(rows, bound)


def never_rises(rows: Rows) -> bool:
    """Whether a step is a function of the operator whose norm in the energy is at most 1 on every structure."""
    form = OperatorForm.of(rows)
    return form is not None and form.bounded(rows.field)


def of_two_steps(rows: Rows) -> Rational | None:
    """The largest energy over that at the start of a G-stable method whose start does not let it rise; else None."""
    form, start = MultiStepForm.of(rows), rows.step.scheme.start_scheme
    if form is None or form.G is None or start is None or not never_rises(Rows(ParameterSet.of(start, None, {}))):
        return None
    old, both, new = (Rational(int(x.numerator), int(x.denominator)) for x in form.G)
    return (old + 2 * abs(both) + new) / (new - both**2 / old)


def searched(rows: Rows, bound: Any) -> str:
    """What the search found, in words."""
    if rows.D is not None or _start(rows) is None:
        return "open; not searched, for what is kept or starts it is not u, v, a at the ends of steps."
    found = [_largest(rows, structure) for structure in islice(candidates(bound), STRUCTURES)]
    return (
        f"open; of {STRUCTURES} structures of two modes with one damper across them, in {STEPS} steps, the largest "
        f"energy is {max(found):.4g} times that at the start."
    )


def _start(rows: Rows) -> tuple[Rows, int] | None:
    """The scheme of the first steps, and how many they are; None where the state is not u, v, a of whole steps."""
    step, scheme = rows.step, rows.step.scheme
    back = [steps_back(s) for s in step.state]
    if not {*knot(0)[:2]} <= {*step.state} or any(k.denominator > 1 or k < 0 for k in back):
        return None
    if not isinstance(scheme.start, Scheme) and scheme.start:
        return None
    first = scheme.start_scheme
    if first is None:
        return (rows, 0) if set(step.state) <= set(knot(0)) else None
    own = Rows(ParameterSet.of(first, None, {}))
    return (own, int(max(back))) if set(own.step.state) <= set(knot(0)) else None


def _largest(rows: Rows, structure: Structure) -> float:
    """The largest energy over that at the start within STEPS steps, of a structure with M = I and diagonal K."""
    n = len(structure[0])
    C, K = ([[float(e) for e in row] for row in part] for part in structure[1:])
    begin, ahead = _start(rows) or (rows, 0)
    unit = [[float(i == j) for j in range(2 * n)] for i in range(2 * n)]  # columns: u_0 of unit energy, then h v_0
    u = [[e / sqrt(K[i][i]) for e in unit[i]] for i in range(n)]
    v = unit[n:]
    a = [[-sum(C[i][k] * v[k][j] + K[i][k] * u[k][j] for k in range(n)) for j in range(2 * n)] for i in range(n)]
    state = [row for s in begin.step.state for row in (u, v, a)[kind_of(s)]]
    past = [_by_kind(begin, state, n)]
    for _ in range(ahead):
        state = _times(_floats(begin, structure), state)
        past.append(_by_kind(begin, state, n))
    state = [row for s in rows.step.state for row in past[ahead - int(steps_back(s))][kind_of(s)]]
    A, most = _floats(rows, structure), max(_energy(x, K) for x in past)
    for _ in range(STEPS):
        state = _times(A, state)
        most = max(most, _energy(_by_kind(rows, state, n), K))
    return most


def _by_kind(rows: Rows, state: Numbers, n: int) -> dict[int, Numbers]:
    """u, h v, h^2 a at t_n by their numbers 0, 1, 2, as far as a state has them."""
    return {kind_of(s): state[k * n : k * n + n] for k, s in enumerate(rows.step.state) if steps_back(s) == 0}


def _energy(found: dict[int, Numbers], K: Numbers) -> float:
    """The largest eigenvalue of X^T X, X of as many columns as starts: the largest energy of a start of unit energy."""
    rows = [[sqrt(K[i][i]) * e for e in row] for i, row in enumerate(found[0])] + found[1]
    x, value = [1.0] * len(rows[0]), 0.0
    for _ in range(12):
        y = [sum(e * f for e, f in zip(row, x, strict=True)) for row in rows]
        x = [sum(row[j] * e for row, e in zip(rows, y, strict=True)) for j in range(len(x))]
        value = sum(e * e for e in x) ** 0.5
        if not value:
            return 0.0
        x = [e / value for e in x]
    return value


def _floats(rows: Rows, structure: Structure) -> Numbers:
    field = rows.field
    assert isinstance(field, Field)
    return [[field.nearest(e) if e else 0.0 for e in row] for row in step_matrix(rows, structure).to_list()]


def _times(A: Numbers, X: Numbers) -> Numbers:
    columns = list(zip(*X, strict=True))
    return [[sum(e * f for e, f in zip(row, column, strict=True)) for column in columns] for row in A]
