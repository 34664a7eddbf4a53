"""Stability on every structure: M > 0, C >= 0 not proportional, K >= 0, of any size, by exact algebra.

What carries a theorem on one oscillator over to all structures is the form of the step (`structure_form`).

Balance form. Let P(lambda) = a M + h b C + h^2 c K and P phi = 0. With m = phi* M phi > 0 and c, k likewise, not
negative, a m + b c + c k = 0 is the equation of one oscillator, so that |lambda| <= 1 if all oscillators are stable. On
the circle the numbers a, b, c lie in a half plane (else a positive combination vanished there, and by an open mapping
one outside as well), say Re(e^(it) .) >= 0: then H = (e^(it) P + its adjoint)/2 >= 0 with phi* H phi = 0, so that H
phi = 0 and phi* P = 0. A Jordan chain P psi + P' phi = 0 gives phi* P' phi = 0, a double root of the oscillator on the
circle, which its certificate excludes. So eigenvalues on the circle are semisimple, but for motions with K phi = 0 and
C phi = 0, which move freely, as they do exactly.

Operator form. L is dissipative in the energy norm: Re <y, L y> = -v^T C v, with gyroscopic forces too. If |R| <= 1
where Re z <= 0, then ||R(hL)|| <= 1 (von Neumann): the energy never grows, not even for a while. If not, an eigenvalue
s of hL is one of an oscillator with m, c, k as above, and R(s) one of its step.

Under a bound: h^2 k/W + h c/D < m for every phi if h^2 K/W + h C/D < M, so that stability of the oscillators in that
triangle, in Omega^2 and 2 xi Omega, is enough.

Steps of two balances that have neither form may be proved by a multiplier (`structure_multiplier`).
"""

from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from functools import cached_property
from typing import Any, Literal, overload

from sympy import QQ, Rational

from ..algebra.algebraic import Algebraic, RealRoot
from ..algebra.points import RationalPoint, ring_over, simplest_between
from ..declare.parameter_set import ParameterSet
from ..declare.scheme import Scheme
from ..declare.symbols import Omega, xi
from .all_damping import DampingCertificate, certify_all_damping
from .certificate import Certificate, Proof, certificate
from .certificate import certify as of_oscillators
from .hurwitz import Parts, Spectrum, Verdict, bilinear, tidy, verdict
from .structure_form import BalanceForm, MultiStepForm, OperatorForm, Rows
from .structure_growth import Structure, as_text, candidates, growing, oscillator, where
from .structure_multiplier import Multiplier
from .structure_transient import Limits, transient

POLYA = 8  # factors 1 + x + y that are tried to make all coefficients of one sign
PROVED, BOUND, REFUTED, OPEN = "proved", "proved under a bound", "refuted", "open"


@dataclass(frozen=True)
class StructuresCertificate:
    """Whether a scheme is stable on every structure.

    verdict: "proved", "proved under a bound", "refuted" or "open". argument: why, in a sentence. bound: (W, D) such
    that h^2 K/W + h C/D < M suffices; D None: h^2 K < W M. growing: (M, h C, h^2 K) on which the scheme grows,
    rational, verified exactly. transient: how far the energy of free motion may rise for a while, in words, where it is
    stable. text: all of it, with the form of the step.
    """

    scheme: str
    parameters: dict[str, Rational | Algebraic]
    verdict: str
    argument: str
    bound: Limits | None = None
    growing: Structure | None = None
    form: tuple[str, ...] = field(default=(), repr=False)
    transient: str = field(default="", repr=False)

    @cached_property
    def text(self) -> str:
        """The verdict, what the step is, and the argument."""
        values = ", ".join([self.scheme, *(f"{name} = {value}" for name, value in self.parameters.items())])
        lines = [f"{values}; every M > 0, C >= 0, K >= 0", f"Result: {self.verdict}", *self.form, self.argument]
        if self.bound is not None:
            lines.append(f"Bound: {bound_text(self.bound)}")
        lines.append(f"Transient growth: {self.transient}")
        if self.growing is not None:
            lines += [
                f"{name} = {as_text(part)}" for name, part in zip(("M", "h C", "h^2 K"), self.growing, strict=True)
            ]
        return "\n".join(lines)


def bound_text(bound: Limits) -> str:
    """The bound as an inequality between matrices."""
    W, D = bound
    return f"h^2 K < {W} M" if D is None else f"h^2 K/({W}) + h C/({D}) < M"


@overload
def certify(
    scheme: str | Scheme, xi: Any = 0, *, structures: Literal[False] = False, **parameters: Any
) -> Certificate: ...
@overload
def certify(
    scheme: str | Scheme, xi: Any = 0, *, structures: Literal[True], **parameters: Any
) -> StructuresCertificate: ...
def certify(scheme: str | Scheme, xi: Any = 0, *, structures: bool = False, **parameters: Any) -> Any:
    """Decide for which Omega > 0 a scheme is spectrally stable at given parameters and damping ratio; or on structures.

    Values are int, Fraction, Rational, text such as '1/5', or Algebraic; defaults are taken for parameters that are not
    given. All algebraic values must be functions of a single r. structures: whether it is stable on every structure
    instead, M > 0, C >= 0 not proportional, K >= 0; xi has to be left out then, since C holds all damping.

    Raises TypeError for a float, DeclarationError for an unknown scheme or parameter or a value outside its interval,
    ValueError for two different algebraic numbers, a negative xi, or one given for structures.

    >>> certify("newmark_bdf2", gamma_t="1/5", beta="0.3025", gamma="3/5", structures=True).verdict
    'proved'
    """
    if not structures:
        return of_oscillators(scheme, xi, **parameters)
    if xi != 0:
        raise ValueError(f"expected no xi for structures, whose matrix C holds all damping, got {xi}; leave it out")
    decision = _Decision(ParameterSet.of(scheme, None, parameters))
    _ = decision.spectrum  # which there is none of where the equations of the step are dependent
    return decision.certificate if decision.scheme.takes_damping else decision.modes


class _Decision:
    def __init__(self, parameters: ParameterSet) -> None:
        self.parameters, self.scheme, self.field = parameters, parameters.scheme, parameters.field

    def _found(self, verdict: str, argument: str, **more: Any) -> StructuresCertificate:
        values = self.parameters.parameters
        return StructuresCertificate(
            self.scheme.name, values, verdict, argument, form=tuple(self._form),
            transient=self._transient(verdict, more.get("bound")), **more,
        )  # fmt: skip

    def _transient(self, verdict: str, bound: Limits | None) -> str:
        if verdict == REFUTED:
            return "unbounded: there is a structure on which the scheme is not stable."
        if not self.scheme.takes_damping:
            return "that of its undamped modes, `derive(scheme).energy.gained`."
        every = verdict == PROVED or (self.undamped.stable and self._oscillators.stable_for_all_xi)
        if verdict == OPEN and not every:
            bound = self._triangle if self._moves_freely else None
            if bound is None:
                return "open; not searched, for there are oscillators on which the scheme is not stable."
        return transient(self.parameters, self.rows, every_step=every and bound is None, bound=bound)

    @cached_property
    def undamped(self) -> Certificate:
        """The certificate of an oscillator without damping."""
        return certificate(self.parameters.damped(0))

    @cached_property
    def rows(self) -> Rows:
        return Rows(self.parameters)

    @cached_property
    def operator(self) -> OperatorForm | None:
        return OperatorForm.of(self.rows)

    @cached_property
    def balance(self) -> BalanceForm | None:
        return BalanceForm.of(self.rows, len(self.spectrum.p) - 1)

    @cached_property
    def spectrum(self) -> Spectrum:
        """The characteristic polynomial of an oscillator, in Omega and xi."""
        return Spectrum.of(self.parameters)

    @property
    def _form(self) -> Iterator[str]:
        if not self.scheme.takes_damping:
            yield "The scheme takes no damping force: every motion is one of undamped modes."
        elif self.operator is not None:
            R = f"({self.operator.numerator.as_expr()})/({self.operator.den.as_expr()})".replace("**", "^")
            yield f"The step is y_1 = R(h L) y_0, y = (u, v), L = [[0, I], [-M^-1 K, -M^-1 C]], with R(z) = {R}."
        elif self.balance is not None:
            a, b, c = (str(p.as_expr()).replace("**", "^") for p in (self.balance.a, self.balance.b, self.balance.c))
            yield f"The step is one balance: (({a}) M + ({b}) h C + ({c}) h^2 K) phi = 0."
        else:
            yield "The step is neither one balance nor a function of the operator of the first order."

    @cached_property
    def certificate(self) -> StructuresCertificate:
        """The decision."""
        if self.operator is not None and self.operator.bounded(self.field):
            return self._found(
                PROVED,
                "|R| <= 1 where Re z <= 0, exactly; by von Neumann's theorem ||R(h L)|| <= 1 in the energy norm.",
            )
        unstable = self._unstable
        if unstable is not None:
            return self._oscillating(unstable)
        if not self._moves_freely:
            return self._found(
                OPEN, "An oscillator that moves freely has an eigenvalue that is not stable beside 1, 1."
            )
        every = self.undamped.stable and self._oscillators.stable_for_all_xi and _everywhere(self._without_stiffness)
        return self._whatever_step if every else self._within_bound

    @property
    def _is_oscillators(self) -> bool:
        """Whether what all oscillators do decides what every structure does."""
        return self.operator is not None or self.balance is not None

    @property
    def _whatever_step(self) -> StructuresCertificate:
        """Where every oscillator is stable, whatever Omega and xi."""
        if self._is_oscillators:
            return self._found(PROVED, f"Every oscillator is stable, whatever Omega and xi.{self._multi_step}")
        multiplier = Multiplier.of(self.rows)
        if multiplier is None:
            return self._searched(None)
        return self._found(
            PROVED, "On the unit circle the Hermitian parts of S A, S B and S D are positive, exactly, with the "
            f"multiplier S = B* H of `structure_multiplier`, H = {multiplier.text}."
        )  # fmt: skip

    @property
    def _within_bound(self) -> StructuresCertificate:
        bound = self._triangle
        if bound is None:
            return self._found(OPEN, "Not every oscillator is stable, and no bound was found within which all are.")
        if self._is_oscillators:
            return self._found(BOUND, "Every oscillator in the triangle is stable.", bound=bound)
        return self._searched(bound)

    @property
    def modes(self) -> StructuresCertificate:
        """Of a scheme that takes no damping."""
        if self.undamped.stable:
            return self._found(PROVED, "Undamped modes decouple, and each is stable for every Omega.")
        W = _below(self.undamped.proof)
        if not W:
            return self._oscillating(self.undamped)
        return self._found(BOUND, "Undamped modes decouple, and each is stable within the bound.", bound=(W, None))

    @cached_property
    def _oscillators(self) -> DampingCertificate:
        return certify_all_damping(self.scheme, **self.parameters.parameters)

    @property
    def _unstable(self) -> Certificate | None:
        """The certificate of an oscillator that refutes: undamped at every step, or, if it is stable there, damped."""
        if not self.undamped.stable:
            return None if _below(self.undamped.proof) else self.undamped
        stretches = (s.certificate for s in self._oscillators.survey.stretches)
        return next((found for found in stretches if found is not None and not found.stable), None)

    def _oscillating(self, found: Certificate) -> StructuresCertificate:
        """Refuted by one oscillator, at a rational Omega (or Omega^2) where its certificate says so."""
        damping = QQ.convert(found.xi)
        for wanted in (Verdict.OUTSIDE, Verdict.MULTIPLE):
            for piece in found.proof.pieces:
                if piece.verdict is wanted and isinstance(piece.at, RationalPoint):
                    square = found.proof.spectrum.in_square
                    x = piece.at.x
                    own = oscillator(x if square else x**2, 2 * damping * x if damping else 0)
                    if wanted is Verdict.MULTIPLE and self.balance is None:
                        continue  # it may be semisimple
                    if wanted is Verdict.OUTSIDE and where(self.rows, own) is not Verdict.OUTSIDE:
                        continue
                    why = "an eigenvalue outside" if wanted is Verdict.OUTSIDE else "a multiple eigenvalue on"
                    return self._found(REFUTED, f"One oscillator has {why} the unit circle, exactly.", growing=own)
        return self._found(
            OPEN, "One oscillator has a multiple eigenvalue on the unit circle; whether powers grow is not decided."
        )

    def _searched(self, bound: Limits | None) -> StructuresCertificate:
        found, tried = growing(self.rows, candidates(bound))
        where_tried = "" if bound is None else f" with {bound_text(bound)}"
        if found is not None:
            return self._found(
                REFUTED, f"A structure of two degrees of freedom{where_tried} has an eigenvalue outside the unit "
                f"circle, exactly, the {tried}th that was tried.", growing=found,
            )  # fmt: skip
        return self._found(
            OPEN,
            f"Every oscillator{where_tried} is stable; {tried} structures of two modes with one damper across "
            "them were tried exactly, and none grows.",
        )

    # --- bounds -----------------------------------------------------------------------------------------

    @cached_property
    def _without_stiffness(self) -> Proof:
        """The proof for oscillators without stiffness, in 2 xi Omega, with one root 1: a rigid displacement."""
        ring = ring_over(self.field, Omega)
        half = self.field.domain.convert(QQ(1, 2))
        p = [ring.from_dict({(j,): c * half**j for (i, j), c in e.terms() if i == j}) for e in self.spectrum.p]
        while not p[0]:
            p = p[1:]
        p = tidy(p, self.field)
        return Proof.of_spectrum(Spectrum(self.parameters, ring, False, ring.one, p, tidy(bilinear(p), self.field)))

    @property
    def _moves_freely(self) -> bool:
        """Whether without stiffness and damping the eigenvalues are 1, 1 and others that are stable."""
        ring = ring_over(self.field, Omega)
        p = [ring.ground_new(e.coeff(1)) for e in self.spectrum.p]
        while p and not p[0]:
            p = p[1:]
        h = bilinear(p) if p else []
        return len(h) > 2 and not any(h[:2]) and verdict(h[2:], RationalPoint(self.field, QQ(0))).stable

    @cached_property
    def _triangle(self) -> Limits | None:
        """(W, D) such that all oscillators with Omega^2/W + 2 xi Omega/D < 1 are stable; None if none was found."""
        damped = self._without_stiffness
        W, D = _below(self.undamped.proof), None if _everywhere(damped) else _below(damped)
        beside = certificate(self.parameters.damped(Rational(1, 8)), in_square=False)
        if beside.critical_Omega == 0 or not W or D == 0:
            return None
        boundaries = [b for test in Parts.of(self.spectrum).tests for b in test.boundaries if b]
        conditions = [_in_square_and_damping(b) for b in [*boundaries, self.spectrum.common]]
        scales = [Fraction(k, 8) for k in (8, 7, 6, 5, 4, 3, 2, 1)]
        tries = [(W * s, None) for s in scales] if D is None else []
        D = Fraction(2) if D is None else D
        tries += [(W * s, D * t) for s in scales for t in scales]
        for limits in tries:
            if all(self._without_zero(c, limits) for c in conditions):
                return limits
        return None

    def _without_zero(self, condition: dict[tuple[int, int], Any], limits: Limits) -> bool:
        """Whether a polynomial in w and d is proved not to vanish where w/W + d/D < 1, w > 0, d > 0.

        With w = W x/(1 + x + y), d = D y/(1 + x + y) and x, y > 0, as when all coefficients have one sign (Polya).
        """
        W, D = limits
        ring = ring_over(self.field, Omega, xi)
        x, y = ring.gens
        share = 1 + x if D is None else 1 + x + y
        degree = max(p if D is None else p + q for p, q in condition)
        number = lambda value: self.field.domain.convert(QQ(value.numerator, value.denominator))  # noqa: E731
        total = ring.zero
        for (p, q), c in condition.items():
            scale = W**p if D is None else W**p * D**q
            power = degree - (p if D is None else p + q)
            total += (x**p * y**q * share**power).mul_ground(c * number(scale))
        for _ in range(POLYA):
            if len({self.field.sign(c) for c in total.values()}) == 1:
                return True
            total *= share
        return False

    @property
    def _multi_step(self) -> str:
        form = MultiStepForm.of(self.rows)
        G = None if form is None else form.G
        if G is None:
            return ""
        return (
            f" The method is G-stable: sum G_jk <y_(n+j), y_(n+k)> in the energy product never grows, G = {as_text(G)}."
        )


def _everywhere(proof: Proof) -> bool:
    return all(piece.verdict.stable for piece in proof.pieces)


def _below(proof: Proof) -> Fraction:
    """Where the stable interval from 0 ends, in the proof's variable, or a rational slightly below; 0 without one."""
    runs = proof.runs()
    if not runs or runs[0][0] is not proof.pieces[0]:
        return Fraction(0)
    root: RealRoot | None = runs[0][-1].high
    if root is None:
        return Fraction(0)
    while root.rational is None and (root.high - root.low) * 1000 > root.high:
        root.narrow()
    if root.rational is not None:
        return Fraction(int(root.rational.numerator), int(root.rational.denominator))
    simple = simplest_between(root.low * QQ(999, 1000), root.low)
    return Fraction(int(simple.numerator), int(simple.denominator))


def _in_square_and_damping(polynomial: Any) -> dict[tuple[int, int], Any]:
    """A polynomial in Omega and xi as one in w = Omega^2 and d = 2 xi Omega, but for a power of Omega."""
    least = min(i - j for i, j in polynomial.monoms())
    found = {}
    for (i, j), c in polynomial.terms():
        power, odd = divmod(i - j - least, 2)
        if odd:
            raise ValueError(f"expected even powers of Omega beside xi*Omega, got {polynomial}")
        found[power, j] = c / polynomial.ring.domain.convert(QQ(2) ** j)
    return found
