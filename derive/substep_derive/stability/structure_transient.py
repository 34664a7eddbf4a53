"""How far the energy of free motion of a structure may rise above that at the start, for a while.

The energy is (v^T M v + u^T K u)/2, motion begins with any u_0, v_0 and the consistent a_0, and M, C, K are any on
which the scheme is stable. Five arguments decide it, in which y = (u, v) in the energy norm:

- ||R(h L)|| <= 1 (`structures`): it never rises.
- A method of k steps that is G-stable has g |y_n|^2 <= |Y_n|_G^2 <= |Y_1|_G^2, with g = 1/(G^-1)_kk the least of the
  form over the older y, and |Y_1|_G^2 <= sum |G_ij| |y_0|^2 where the start does not let it rise.
- Where every oscillator is stable and the first step of oscillators with Omega = t^p, 2 xi Omega = t^q grows with a
  power of t (the scheme's overshoot, for q = -oo), no bound holds for all structures.
- Let h^2 K < W M be the bound and A the step of an oscillator at Omega^2 = W, or one at the bound of damping. Where an
  eigenvalue of A on the unit circle has a Jordan block that moves u or v, the powers of A grow without bound, so that
  by continuity those at smaller Omega have no common bound.
- With h^2 K/W + h C/D < M the numerical range of h L in the energy norm is inside the triangle -D, +-i sqrt(W): with
  t = |v|^2/|y|^2, c = h v^T C v/|v|^2 and w = h^2 v^T K v/|v|^2 < W (1 - c/D) a value -x + i y of it has x = t c and
  y^2 <= 4 t (1 - t) w < 4 (1 - t) (t - x/D) W <= W (1 - x/D)^2. If |R| <= 1 in the triangle, then ||R(h L)^n|| <=
  1 + sqrt(2) (M. Crouzeix & C. Palencia, SIAM J. Matrix Anal. Appl. 38 (2017) 649-655).

Where none applies it is open, and small structures are searched, in floating point.
"""

from collections.abc import Sequence
from fractions import Fraction
from itertools import islice, product
from math import sqrt

from sympy import QQ, Poly, Rational

from ..algebra.algebraic import Field
from ..algebra.field_matrices import FieldMatrix, field_matrix, identity
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.symbols import Omega, lam
from ..oscillator.evaluation import Evaluation
from ..oscillator.overshoot import overshoot
from .structure_form import MultiStepForm, OperatorForm, Rows, within_triangle
from .structure_growth import Structure, candidates, exact, oscillator
from .structure_motion import FreeMotion

STRUCTURES, STEPS = 24, 48  # that are searched, and how long each moves
POWERS = range(-1, 4)  # of t in Omega and in 2 xi Omega, of oscillators whose first step is looked at
BELOW = range(-1, 0)  # those in Omega where Omega is bounded
Numbers = list[list[float]]
Limits = tuple[Fraction, Fraction | None]


def transient(parameters: ParameterSet, rows: Rows, *, every_step: bool, bound: Limits | None) -> str:
    """The verdict in words. every_step: every oscillator is stable; bound: else, of `structures`, or None.

    Rows are those of the scheme at the parameters.
    """
    try:
        known = _bounded(rows, every_step, bound) or _unbounded(parameters, rows, every_step, bound)
        return known or searched(rows, bound)
    except DeclarationError as error:
        return f"open; not searched: {error}."


def _bounded(rows: Rows, every_step: bool, bound: Limits | None) -> str | None:
    """By which argument the energy does not rise, or to how much; None without one."""
    if never_rises(rows):
        return "none: the energy of free motion never exceeds that at the start, with any damping."
    most = of_steps(rows) if every_step else None
    if most is not None:
        return f"bounded: the energy is at most {most} times that at the start, by G-stability."
    form = OperatorForm.of(rows)
    if form and bound and bound[1] and within_triangle(form, rows.field, bound[0], bound[1]):
        return (
            "bounded: the energy is at most (1 + sqrt(2))^2 = 3 + 2 sqrt(2) times that at the start, since the "
            "numerical range of h L is where |R| <= 1 (Crouzeix & Palencia 2017)."
        )
    return None


def _unbounded(parameters: ParameterSet, rows: Rows, every_step: bool, bound: Limits | None) -> str | None:
    """On which structures the energy rises beyond all bounds; None if none was found."""
    found = overshoot(Evaluation.at(parameters)) if every_step else None
    if found and (found.u or found.v):
        return (
            f"unbounded: the first step of an undamped oscillator has the overshoot {found}, powers of Omega with "
            "which u_1 and v_1/omega grow as Omega -> oo."
        )
    if every_step or (bound and bound[1] is None):
        ray = growing_first_step(rows, POWERS if every_step else BELOW)
        if ray is not None:
            return (
                f"unbounded: on oscillators with {ray[0]} the energy after the first step grows as t^{ray[1]}, t -> oo."
            )
    edge = bound and unbounded_at(rows, bound)
    return f"unbounded: {edge}" if edge else None


def never_rises(rows: Rows) -> bool:
    """Whether a step is a function of the operator whose norm in the energy is at most 1 on every structure."""
    form = OperatorForm.of(rows)
    return form is not None and form.bounded(rows.field)


def of_steps(rows: Rows) -> Rational | None:
    """The largest energy over that at the start of a G-stable method whose start does not let it rise; else None."""
    form, start = MultiStepForm.of(rows), rows.step.scheme.start_scheme
    G = None if form is None else form.G
    if G is None or start is None or not never_rises(Rows(ParameterSet.of(start, None, {}))):
        return None
    most = sum(abs(g) for row in G for g in row) * field_matrix(G, QQ).inv().to_list()[-1][-1]
    return Rational(int(most.numerator), int(most.denominator))


def growing_first_step(rows: Rows, powers: Sequence[int]) -> tuple[str, int] | None:
    """Oscillators in words, and the power of t with which their energy after the scheme's first step grows; or None."""
    over = rows.field.domain.frac_field(Omega)
    best: tuple[str, int] | None = None
    for p, q in product(powers, POWERS):
        Omega_t, damping = (over.gens[0] ** k for k in (p, q))
        motion = FreeMotion.of(rows, *(field_matrix([[e]], over) for e in (damping, Omega_t**2)))
        (uu, uv), (vu, vv) = (motion.R * motion.S).to_list()
        degrees = [e.numer.degree() - e.denom.degree() for e in (uu, uv * Omega_t, vu / Omega_t, vv) if e]
        if max(degrees) > (best[1] // 2 if best else 0):
            best = (f"Omega = t^{p}, 2 xi Omega = t^{q}", 2 * max(degrees))
    return best


def unbounded_at(rows: Rows, bound: Limits) -> str | None:
    """The end of a bound at which powers of an oscillator's step grow in u or v, in words; None if none was found."""
    W, D = bound
    if rows.field.domain != QQ:
        return None
    for stiffness, damping in ((W, Fraction(0)), *([] if D is None else [(Fraction(0), D)])):
        if _has_block(FreeMotion.of(rows, *exact(rows, oscillator(stiffness, damping))[1:]), without_u=not stiffness):
            limit = f"h^2 K -> {W} M" if stiffness else f"h C -> {D} M"
            return f"the double eigenvalue -1 of the limit {limit} has a Jordan block, in which u or v grows as n."
    return None


def _has_block(motion: FreeMotion, *, without_u: bool) -> bool:
    """Whether the start has a share in a Jordan block of size 2 of the eigenvalue -1, and u or v in its vector.

    without_u: only v from v_0 counts, since displacements have no energy without stiffness.
    """
    rest, times = Poly.from_list(motion.A.charpoly(), lam, domain=QQ), 0
    while rest.eval(-1) == 0:
        rest, times = rest.exquo(Poly(lam + 1, lam, domain=QQ)), times + 1
    if times != 2:
        return False
    y = (motion.A + identity(motion.A.shape[0], QQ)) * motion.S
    found = field_matrix([[QQ(0)] * 2 for _ in range(y.shape[0])], QQ)
    for c in rest.rep.to_list():
        found = motion.A * found + c * y
    moved = (motion.R * found).to_list()
    return bool(moved[1][1]) if without_u else any(map(any, moved))


def searched(rows: Rows, bound: Limits | None) -> str:
    """What the search found, in words."""
    found = [_largest(rows, structure) for structure in islice(candidates(bound), STRUCTURES)]
    return (
        f"open; of {STRUCTURES} structures of two modes with one damper across them, in {STEPS} steps, the largest "
        f"energy is {max(found):.4g} times that at the start."
    )


def _largest(rows: Rows, structure: Structure) -> float:
    """The largest energy over that at the start within STEPS steps, of a structure with M = I and diagonal K."""
    motion = FreeMotion.of(rows, *exact(rows, structure)[1:])
    A, R, S, *before = (_floats(rows, part) for part in (motion.A, motion.R, motion.S, *motion.before))
    n, root = len(structure[0]), [sqrt(row[i]) for i, row in enumerate(structure[2])]
    scales = [*root, *[1.0] * n]  # of u and h v in the energy norm

    def energy(Y: Numbers) -> float:
        return _norm([[scales[i] * e / scales[j] for j, e in enumerate(row)] for i, row in enumerate(Y)])

    most, state = max(map(energy, before)), S
    for _ in range(STEPS):
        most = max(most, energy(_times(R, state)))
        state = _times(A, state)
    return most


def _norm(X: Numbers) -> float:
    """The largest eigenvalue of X^T X."""
    x, value = [1.0] * len(X[0]), 0.0
    for _ in range(12):
        y = [sum(e * f for e, f in zip(row, x, strict=True)) for row in X]
        x = [sum(row[j] * e for row, e in zip(X, y, strict=True)) for j in range(len(x))]
        value = sum(e * e for e in x) ** 0.5
        if not value:
            return 0.0
        x = [e / value for e in x]
    return value


def _floats(rows: Rows, matrix: FieldMatrix) -> Numbers:
    field = rows.field
    assert isinstance(field, Field)
    return [[field.nearest(e) if e else 0.0 for e in row] for row in matrix.to_list()]


def _times(A: Numbers, X: Numbers) -> Numbers:
    columns = list(zip(*X, strict=True))
    return [[sum(e * f for e, f in zip(row, column, strict=True)) for column in columns] for row in A]
