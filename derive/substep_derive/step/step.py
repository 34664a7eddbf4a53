"""Scheme -> Step: a declaration lowered once, to the equations of its step and the order in which they are solved.

All relations together make every new symbol affine in the balances' new accelerations z. A symbol belongs to the
first balance that determines it; a balance reads what earlier balances determined and its own z. Balances that read
each other's z, as those of Gauss's methods do, are solved together, as one stage.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from types import MappingProxyType

from sympy import Expr, Integer, Symbol, default_sort_key, factor

from ..algebra import rational
from ..algebra.constant import constant_of
from ..declare.errors import DeclarationError
from ..declare.scheme import Balance, Scheme
from ..declare.symbols import C, M, N, N_discrete, f, knot, knot_of, successor


@dataclass(frozen=True)
class Stage:
    """Balances that are solved together, their new accelerations z, and what becomes known with them.

    It is one balance, unless several read each other's accelerations. relations: those of the declared ones that belong
    to this stage. in_z: every other symbol of the stage, affine in z and in the symbols of earlier stages. moved: those
    of them at which the balances take the internal force; none in an explicit stage.
    """

    balances: tuple[Balance, ...]
    z: tuple[Symbol, ...]
    relations: Mapping[Symbol, Expr]
    in_z: Mapping[Symbol, Expr]
    moved: frozenset[Symbol]

    @property
    def alone(self) -> bool:
        """Whether it is a single balance."""
        return len(self.balances) == 1

    def moved_by(self, k: int) -> list[Symbol]:
        """The displacements among `moved` at which the k-th balance takes the internal force, by name."""
        return sorted(_displacements(self.balances[k]) & self.moved, key=str)

    def c_u(self, k: int = 0) -> Expr:
        """The derivative by the k-th z of the displacement that moves with that balance; 0 for an explicit balance.

        Where the balance takes the force of a mixture, as at (1 - alpha_f) u_1 + alpha_f u_0, that is of u_1 itself.
        """
        slopes = (self.in_z[s].diff(self.z[k]) for s in self.moved_by(k) if s in self.in_z)
        return factor(sum(slopes, 0 * self.z[k]))

    def c_v(self, k: int = 0) -> Expr:
        """The derivative by the k-th z of the velocity that the balance's damping force is taken at."""
        return factor(self.balances[k].damping.subs(self.in_z).diff(self.z[k]))

    def c_a(self, k: int = 0) -> Expr:
        """The derivative by the k-th z of the balance's inertia."""
        return factor(self.balances[k].inertia.subs(self.in_z).diff(self.z[k]))


@dataclass(frozen=True)
class Step:
    """One step of a scheme.

    unknowns: symbols that it determines; state: old symbols that it reads; after: for each of these, its successor in
    the next step. equations: expressions that are 0, first of the relations, then of the balances. reported: u, v, a at
    t_n + h; own_acceleration: whether a is the scheme's own a_1, else it follows from the equation of motion. start:
    the state at t = 0 from u_0, v_0, a_0 and loads; None where another scheme marches the first steps.
    """

    scheme: Scheme
    unknowns: tuple[Symbol, ...]
    state: tuple[Symbol, ...]
    after: tuple[Symbol, ...]
    equations: tuple[Expr, ...]
    reported: tuple[Expr, Expr, Expr]
    own_acceleration: bool
    start: tuple[Expr, ...] | None

    @classmethod
    def of(cls, scheme: Scheme) -> "Step":
        """Lowered once for equal schemes."""
        return _step(scheme)

    @property
    def outputs(self) -> tuple[Expr, ...]:
        """What is reported and follows from the step itself: u, v and, where the scheme has its own, a."""
        return self.reported if self.own_acceleration else self.reported[:2]

    @cached_property
    def stencil(self) -> tuple[Expr, ...]:
        """Instants of all loads, in steps after t_n."""
        return instants([*self.equations, *self.reported], self.scheme.typical)

    @cached_property
    def accelerations(self) -> tuple[Symbol, ...]:
        """For each balance the new acceleration z it is solved for: the one in its inertia.

        A balance whose inertia is a difference of velocities gets a symbol of its own for it.
        """
        new, found = set(self.unknowns), []
        for balance in self.scheme.balances:
            candidates = [s for s in self.unknowns if s in balance.inertia.free_symbols & new and s.name[0] == "a"]
            candidates = [s for s in candidates if s not in found]
            found.append(candidates[0] if candidates else Symbol(f"a_*{len(found) + 1}"))
        return tuple(found)

    @cached_property
    def relations(self) -> Mapping[Symbol, Expr]:
        """The declared relations, and those of accelerations that are symbols of their own."""
        pairs = zip(self.accelerations, self.scheme.balances, strict=True)
        own = {z: balance.inertia for z, balance in pairs if z not in self.unknowns}
        return MappingProxyType({**self.scheme.relations, **own})

    @cached_property
    def solved(self) -> Mapping[Symbol, Expr]:
        """Every new symbol but the balances' accelerations, affine in these and in the state."""
        unknowns = [s for s in self.unknowns if s not in self.accelerations]
        return affine(self.relations, unknowns, self.scheme.name)

    @cached_property
    def prior(self) -> Mapping[Symbol, Expr]:
        """The new symbols that follow from the state alone."""
        return {s: e for s, e in self.solved.items() if self._level[s] == 0}

    @cached_property
    def together(self) -> tuple[tuple[int, ...], ...]:
        """Places of the balances that are solved together: that read each other's z, directly or through others."""
        z, balances = self.accelerations, self.scheme.balances
        reads = [
            {j for j, zj in enumerate(z) if any(self.solved.get(s, s).has(zj) for s in b.symbols)} for b in balances
        ]
        for j, through in enumerate(reads):
            for k, own in enumerate(reads):
                own |= {k, *(through if j in own else ())}
        return tuple(dict.fromkeys(tuple(j for j in sorted(own) if k in reads[j]) for k, own in enumerate(reads)))

    @cached_property
    def _level(self) -> Mapping[Symbol, int]:
        """For each new symbol the number of the stage that determines it, from 1 on, and 0 for none."""
        z = self.accelerations
        of_z = {z[j]: k for k, places in enumerate(self.together, start=1) for j in places}
        level = {s: max((k for zk, k in of_z.items() if e.has(zk)), default=0) for s, e in self.solved.items()}
        return level | of_z

    @cached_property
    def stages(self) -> tuple[Stage, ...]:
        """The balances in the order in which they are solved, those together that read each other's accelerations.

        Raises DeclarationError when a balance reads an acceleration that a later balance defines, which does not read
        its own.
        """
        level, found = self._level, []
        for k, places in enumerate(self.together, start=1):
            balances, z = (tuple(of[j] for j in places) for of in (self.scheme.balances, self.accelerations))
            for j, balance in zip(places, balances, strict=True):
                if late := [s for s in sorted(balance.symbols, key=str) if level.get(s, 0) > k]:
                    raise DeclarationError(
                        f"{self.scheme.name}: balance {j + 1} reads {late[0]}, which depends on the acceleration of a "
                        "later balance; write the balances in the order in which they are solved"
                    )
            own = {
                s: e
                for s, e in self.relations.items()
                if max((level.get(x, 0) for x in (e - s).free_symbols), default=0) == k
            }
            in_z = affine(own, [s for s in level if level[s] == k and s not in z], self.scheme.name)
            moved = frozenset(s for b in balances for s in _displacements(b) if level.get(s) == k)
            found.append(Stage(balances, z, MappingProxyType(own), in_z, moved))
        return tuple(found)

    @cached_property
    def placed(self) -> tuple[tuple[Stage, int], ...]:
        """For each balance the stage that it is solved in, and its place there."""
        found = {z: (stage, j) for stage in self.stages for j, z in enumerate(stage.z)}
        return tuple(found[z] for z in self.accelerations)


def _displacements(balance: Balance) -> set[Symbol]:
    """The symbols at which a balance takes the internal force."""
    return {s for atom in balance.force.atoms(N, N_discrete) for s in atom.free_symbols}


@cache
def _step(scheme: Scheme) -> Step:
    u1, v1, a1 = knot(1)
    unknowns, state = scheme.unknowns, scheme.state
    equations = [symbol - expression for symbol, expression in scheme.relations.items()]
    equations += [M * b.inertia + C * b.damping + b.force - b.load for b in scheme.balances]
    u, v = scheme.report.get(u1, u1), scheme.report.get(v1, v1)
    own = a1 in unknowns or a1 in scheme.report
    a = scheme.report.get(a1, a1) if own else (f(Integer(1)) - C * v - N(u1)) / M
    start = scheme.start if scheme.start_scheme is None else None
    return Step(
        scheme,
        unknowns,
        state,
        tuple(successor(s) for s in state),
        tuple(equations),
        (u, v, a),
        own,
        None if start is None else tuple(start.get(s, s) for s in state),
    )


def instants(expressions: Iterable[Expr], typical: Mapping[Symbol, Expr]) -> tuple[Expr, ...]:
    """Arguments of all loads f(tau), in their order of time at typical parameters."""
    found = {load.args[0] for e in expressions for load in e.atoms(f)}
    return tuple(sorted(found, key=lambda tau: (tau.subs(typical), default_sort_key(tau))))


def affine(relations: Mapping[Symbol, Expr], unknowns: Sequence[Symbol], scheme: str) -> Mapping[Symbol, Expr]:
    """The relations solved for the unknowns, each in terms of every other symbol."""
    return _affine(tuple(relations.items()), tuple(unknowns), scheme)


@cache  # equal relations are met again, as those of one scheme with its constant exact and in doubles
def _affine(
    relations: tuple[tuple[Symbol, Expr], ...], unknowns: tuple[Symbol, ...], scheme: str
) -> Mapping[Symbol, Expr]:
    if not unknowns:
        return {}
    equations = [symbol - expression for symbol, expression in relations]
    symbols = {s for e in equations for s in e.free_symbols}
    others = sorted((s for s in symbols - set(unknowns) if knot_of(s)), key=str)
    matrix, known = rational.slopes(equations, unknowns), rational.slopes(equations, others)
    try:
        numerators, den = rational.solve(matrix, -known)
    except rational.SingularMatrix as error:
        raise DeclarationError(
            f"{scheme}: the relations for {', '.join(map(str, unknowns))} do not determine them; "
            "one of them repeats another"
        ) from error
    numbers = constant_of(equations) is not None  # of its field, which have one form
    solution = numerators / den if numbers else rational.in_factors(numerators, den)
    solved = {
        symbol: sum((solution[i, j] * other for j, other in enumerate(others)), Integer(0))
        for i, symbol in enumerate(unknowns)
    }
    return MappingProxyType(solved)
