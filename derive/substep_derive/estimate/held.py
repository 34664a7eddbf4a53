"""Scheme -> one step as linear equations, with the values that it reports and those that it could evaluate besides.

Values that a declaration has no symbol for get one here, with a label that no declaration may use:
u_*end, v_*end: what the scheme reports at t_n + h. a_*end: the acceleration there from the equation of motion.
a_*start: the same of the step before, at t_n. u_*embedded, v_*embedded: the second values of an embedded pair.
"""

from dataclasses import dataclass
from functools import cache

from sympy import Dummy, Expr, Matrix, Symbol, zeros

from ..algebra import rational
from ..declare.scheme import Scheme
from ..declare.symbols import C, Knot, M, N, N_discrete, f, knot, knot_of, lattice, shifted
from ..oscillator.amplification import coefficients
from ..step.step import Step, instants

END, START, EMBEDDED, HALVED = (knot(f"*{name}") for name in ("end", "start", "embedded", "halved"))


@dataclass(frozen=True)
class HeldStep:
    """matrix * (unknowns, state, loads, forces) = 0, entries polynomials in Omega, xi and the parameters.

    unknowns: new symbols, those of END and perhaps of EMBEDDED. stencil: the loads' instants. forces: the arguments of
    N, one or, for a discrete gradient, two displacements; their columns hold what is not linear in the displacement.
    """

    scheme: Scheme
    unknowns: tuple[Symbol, ...]
    state: tuple[Symbol, ...]
    stencil: tuple[Expr, ...]
    forces: tuple[tuple[Expr, ...], ...]
    matrix: Matrix

    @classmethod
    def of(cls, scheme: Scheme) -> "HeldStep":
        """Derived once for equal schemes. Raises DeclarationError as `Amplification.of`."""
        return _held(scheme)


@cache
def _held(scheme: Scheme) -> HeldStep:
    step = Step.of(scheme)
    u, v, _ = step.reported
    added = {END.u: u, END.v: v}
    added |= {getattr(EMBEDDED, (knot_of(s) or ("u", ""))[0]): e for s, e in scheme.embedded.items()}
    equations = [*step.equations, *(symbol - e for symbol, e in added.items()), M * END.a + C * END.v + N(END.u) - f(1)]
    unknowns, state = (*step.unknowns, *added, END.a), step.state
    stencil = instants(equations, scheme.typical)
    atoms = sorted({atom for e in equations for atom in e.atoms(N, N_discrete)}, key=str)
    linear = coefficients(equations, [*unknowns, *state], stencil)
    own = zeros(len(equations), len(atoms))
    for k, atom in enumerate(atoms):
        one = Dummy()
        loads = {load: 0 for e in equations for load in e.atoms(f)}
        for i, e in enumerate(equations):
            if e.has(atom):
                own[i, k] = coefficients(
                    [e.subs(atom, one).subs(loads).replace(_is_force, lambda _: 0)], [one, *unknowns, *state], ()
                )[0, 0]
    matrix = rational.clear_rows(linear.row_join(own))
    return HeldStep(scheme, unknowns, state, stencil, tuple(atom.args for atom in atoms), matrix)


def _is_force(e: Expr) -> bool:
    return isinstance(e, N | N_discrete)


def earlier(symbol: Symbol) -> Symbol:
    """The same value of the step before: u_-1 for u_0, u_*g-1 for a sub-step's u_g, a_*start for a_*end."""
    kind, label = knot_of(symbol) or ("", "")
    if lattice(label) is not None:
        return shifted(symbol, -1)
    at_start = Knot(*START)
    return getattr(at_start, kind) if symbol in END else Symbol(f"{kind}_*{label.lstrip('*')}-1")
