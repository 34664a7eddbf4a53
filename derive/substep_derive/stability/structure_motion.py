"""Step -> free motion of one structure with M = I from its start: u and h v at the ends of steps, exact.

Motion begins with any u_0, h v_0 and the consistent a_0, by what the scheme declares: expressions, or another scheme.
"""

from dataclasses import dataclass

from sympy import Expr, Symbol, cancel, fraction

from ..algebra.field_matrices import FieldMatrix, identity
from ..declare.errors import DeclarationError
from ..declare.parameter_set import ParameterSet
from ..declare.symbols import K0, C, K_t, M, N, f, kind_of, knot, steps_back
from .structure_form import Rows
from .structure_growth import lifted, solved, stacked

Parts = dict[Symbol, tuple[Expr, Expr, Expr]]  # of a symbol the coefficients that 1, h C and h^2 K multiply


@dataclass(frozen=True)
class FreeMotion:
    """x_(k+1) = A x_k, (u, h v)_(k+1) = R x_k, x_0 = S (u_0, h v_0), all over one domain.

    before: (u, h v) of steps that another scheme marches, that at the start among them, in terms of (u_0, h v_0).
    """

    A: FieldMatrix
    R: FieldMatrix
    S: FieldMatrix
    before: tuple[FieldMatrix, ...]

    @classmethod
    def of(cls, rows: Rows, C: FieldMatrix, K: FieldMatrix) -> "FreeMotion":
        """C, K (n, n): h C and h^2 K over the parameters' field or rational functions over it.

        Raises DeclarationError where what starts or is reported divides by C or K, as in KR-alpha.
        """
        n, domain, step = C.shape[0], C.domain, rows.step
        found = solved(rows, [identity(n, domain), C, K])

        def combined(e: Expr, values: dict[Symbol, FieldMatrix]) -> FieldMatrix:
            lift, total = lifted(rows, domain), None
            for s, parts in _parts(rows, e, values).items():
                numbers = (lift(rows.field.number(part)) for part in parts)
                for c, by in zip(numbers, (identity(n, domain), C, K), strict=True):
                    if c:
                        share = c * (by * values[s])
                        total = share if total is None else total + share
            assert total is not None
            return total

        A, R = stacked(found[s] for s in step.after), stacked(combined(e, found) for e in step.reported[:2])
        unit = identity(2 * n, domain)
        u, v = unit[:n, :], unit[n:, :]
        at_start = dict(zip(knot(0), (u, v, -(C * v) - K * u), strict=True))
        first = step.scheme.start_scheme
        if first is None:
            own = dict(step.scheme.start) | {s: s for s in step.state if s in at_start}
            values = [combined(own[s], at_start) for s in step.state]
            if rows.D is not None:  # the symbols of accelerations stand for D^-1 M a
                D = sum((c * part for c, part in zip(map(lifted(rows, domain), rows.D[1:]), (C, K), strict=True)),
                        lifted(rows, domain)(rows.D[0]) * identity(n, domain))  # fmt: skip
                values = [D.lu_solve(x) if kind_of(s) == 2 else x for s, x in zip(step.state, values, strict=True)]
            return cls(A, R, stacked(values), (unit,))
        other = Rows(ParameterSet.of(first, None, {}))
        begun, ahead = cls.of(other, C, K), int(max(map(steps_back, step.state)))
        states, outputs = [begun.S], [*begun.before]
        for _ in range(ahead):
            outputs.append(begun.R * states[-1])
            states.append(begun.A * states[-1])
        place = {s: k * n for k, s in enumerate(other.step.state)}

        def at(s: Symbol) -> FieldMatrix:
            row = place[knot(0)[kind_of(s)]]
            return states[ahead - int(steps_back(s))][row : row + n, :]

        return cls(A, R, stacked(at(s) for s in step.state), tuple(outputs))


def _parts(rows: Rows, e: Expr, symbols: dict[Symbol, FieldMatrix]) -> Parts:
    plain = e.replace(N, lambda u: K0 * u).replace(K_t, lambda _: K0).replace(f, lambda _: 0)
    plain = plain.subs({**rows.values, M: 1}).expand()
    found = {}
    for s in (s for s in symbols if plain.has(s)):
        slope = cancel(plain.diff(s))
        if fraction(slope)[1].has(C, K0):
            raise DeclarationError(f"expected sums of multiples of the step's symbols, C and K times these, got {e}")
        found[s] = (slope.subs({C: 0, K0: 0}), slope.diff(C), slope.diff(K0))
    return found
