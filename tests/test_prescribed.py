"""What a scheme makes of a prescribed motion: against plain stepping, and against what is known."""

from collections.abc import Mapping
from functools import cache

import numpy as np
import pytest
from declared import OF_STIFFNESS
from substep_derive import DeclarationError, derive, prescribed
from substep_derive.constrained.prescribed import Prescribed
from substep_derive.declare.catalogue import find
from substep_derive.declare.symbols import C, M, N, N_discrete, h, successor
from substep_derive.step.step import Step
from substep_derive.step.times import passed
from substep_kernels.facts import CATALOGUE
from sympy import Expr, Matrix, Rational, Symbol, simplify, sqrt, symbols

import substep as ss

Array = np.ndarray
REFUSED = {
    **dict.fromkeys(OF_STIFFNESS, "coefficients from the structure"),
    **dict.fromkeys(("gauss2", "lobatto_iiia3"), "a state that a smooth motion determines"),
    "fully_explicit_generalized_alpha": "internal force at one place that no other one takes it at",
    "discontinuous_galerkin_p1": "to take the internal force at one place",
    "stoermer_extrapolation": "to move a displacement",
}
SCHEMES = [name for name in ss.schemes() if name not in REFUSED]
beta, gamma, gamma_t, rho_inf = symbols("beta gamma gamma_t rho_inf")


class Stepping:
    """A step of length h with r given where `held` says: relations, balances and reactions as one system of floats.

    step: the state after it, over that before it and the values of r; reaction: likewise.
    """

    def __init__(self, found: Prescribed, length: float) -> None:
        self.scheme, self.instants = found.scheme, [float(tau) for _, tau in found.held]
        given = ss.scheme(self.scheme.name).parameters
        values = {p.symbol: float(given[p.name]) for p in self.scheme.parameters} | {h: length, C: 0, M: 1}
        if self.scheme.constant is not None:
            values[self.scheme.constant] = float(self.scheme.constant.approximation)
        after = {s: successor(s) for s in self.scheme.state}
        places = {p for b in self.scheme.balances for p in b.force.atoms(N, N_discrete)}
        # a force at a knot that the step before has taken too is that of this step's reaction, a step later
        carried = {p: p.xreplace(after) for p in places if p.xreplace(after) != p and p.xreplace(after) in places}
        reaction = {p: Symbol(f"{'old' if p in carried else 'new'} {p}") for p in sorted(places, key=str)}
        r = [Symbol(f"r_{k}") for k in range(len(self.instants))]
        equations = [s - e for s, e in self.scheme.relations.items()]
        equations += [b.inertia - b.force.xreplace(reaction) for b in self.scheme.balances]
        for (u, _), value in zip(found.held, r, strict=True):
            at_once = self.from_state(u)
            equations.append((u if at_once is None else at_once.xreplace(after)) - value)
        new = [*self.scheme.unknowns, *(s for p, s in reaction.items() if p not in carried)]
        known = [*self.scheme.state, *map(reaction.__getitem__, carried), *r]
        A, B = (np.array(Matrix(equations).jacobian(x).subs(values).tolist(), dtype=float) for x in (new, known))
        solved = dict(zip(new, np.linalg.solve(A, -B), strict=True)) | dict(zip(known, np.eye(len(known)), strict=True))
        rows = [solved[successor(s)] for s in self.scheme.state]
        self.step = np.array([*rows, *(solved[reaction[later]] for later in carried.values())])
        self.displacement = solved[Symbol("u_1")]
        self.reaction = {p: solved[s] for p, s in reaction.items() if p not in carried}
        reported = self.scheme.report.get(Symbol("v_1"), Symbol("v_1"))
        at = {s: solved[s] for s in reported.free_symbols & solved.keys()}
        self.velocity = (
            None if reported.has(N) else sum(float(reported.diff(s).subs(values)) * row for s, row in at.items())
        )

    def from_state(self, u: Symbol) -> Expr | None:
        """A displacement that follows from the state alone, in that; else None."""
        found: Expr = u
        while new := found.free_symbols & self.scheme.relations.keys():
            found = found.subs({s: self.scheme.relations[s] for s in new})
        return None if found.free_symbols & set(self.scheme.unknowns) else found

    def of_exponential(self, length: float) -> Array:
        """The state, and the values of r, that belong to r = exp(t): what solves (e^h - P) y = Q r."""
        n = len(self.step)
        r = np.exp(np.array(self.instants) * length)
        y = np.linalg.solve(np.exp(length) * np.eye(n) - self.step[:, :n], self.step[:, n:] @ r)
        return np.append(y, r)


@cache
def instants_of(name: str) -> Mapping[Symbol, Expr]:
    return passed(Step.of(find(name)))


@cache
def found(name: str) -> Prescribed:
    return prescribed(name)


@pytest.mark.matrix
@pytest.mark.parametrize("name", SCHEMES)
def test_the_errors_are_those_of_steps_on_an_exponential(name: str) -> None:
    """All derivatives of r = exp(t) at t are exp(t), so that an error over h^power tends to the coefficient."""
    p, seen = found(name), []
    sizes = 0.04, 0.02
    for length in sizes:
        stepping = Stepping(p, length)
        x = stepping.of_exponential(length)
        rows = {place: (stepping.reaction[place], place.args, e) for place, e in p.reactions.items()}
        errors = []
        for row, where, term in rows.values():
            if term is not None and term.power < 5:
                tau = sum(float(instant_of(stepping, arg)) for arg in where) / len(where)
                errors.append((row @ x / np.exp(tau * length) - 1) / length**term.power / float(term.coefficient))
        if stepping.velocity is not None and p.velocity is not None and p.velocity.power < 5:
            errors.append((stepping.velocity @ x / np.exp(length) - 1) / length**p.velocity.power)
            errors[-1] /= float(p.velocity.coefficient)
        seen.append(errors)
    assert len(seen[0]) >= 1
    assert np.allclose(2 * np.array(seen[1]) - np.array(seen[0]), 1.0, atol=0.02)


def instant_of(stepping: Stepping, arg: Expr) -> Expr:
    """Where a force is taken, in steps after t_n: u of a motion of velocity 1, which is marched."""
    instants = instants_of(stepping.scheme.name)
    values = {p.symbol: float(ss.scheme(stepping.scheme.name).parameters[p.name]) for p in stepping.scheme.parameters}
    if stepping.scheme.constant is not None:
        values[stepping.scheme.constant] = float(stepping.scheme.constant.approximation)
    return arg.subs(instants).subs(values)


@pytest.mark.matrix
@pytest.mark.parametrize("name", SCHEMES)
def test_a_wrong_start_dies_or_grows_as_it_says(name: str) -> None:
    p = found(name)
    n = len(Stepping(p, 1.0).step)
    P = Stepping(p, 1.0).step[:, :n]
    assert p.decay is not None
    scale = max(1.0, float(p.decay))  # powers of the largest would overflow
    far = [np.linalg.norm(np.linalg.matrix_power(P / scale, k)) for k in (60, 120)]
    if p.decay == 0:
        assert np.abs(np.linalg.matrix_power(P, p.polynomial.degree())).max() < 1e-9 * max(1, np.abs(P).max()) ** 3
    else:
        assert (far[1] / far[0]) ** (1 / 60) == pytest.approx(float(p.decay) / scale, rel=0.04)  # roots may be multiple
        assert p.grows == (scale > 1.0 or far[1] > 1.5 * far[0])


def test_a_constraint_is_an_infinitely_stiff_spring() -> None:
    """Of implicit schemes rho_inf, which is derived from the amplification matrix, is what a wrong start decays by."""
    implicit = [name for name in SCHEMES if CATALOGUE[name]["rho_inf"] != "oo"]
    assert len(implicit) > 25
    for name in implicit:
        assert float(found(name).decay) == pytest.approx(CATALOGUE[name]["values"]["rho_inf"], rel=1e-12, abs=1e-12), (
            name
        )


def test_what_is_known() -> None:
    """From an independent prototype: the multiplier of Bathe's scheme and its kin is of first order only."""
    known = {
        ("average_acceleration", ()): (2, Rational(-1, 6)),
        ("generalized_alpha", (("rho_inf", "4/5"),)): (2, Rational(-19, 108)),
        ("newmark", (("beta", "0.3025"), ("gamma", "0.6"))): (1, Rational(-1, 10)),
        ("bathe", ()): (1, Rational(-1, 2)),
        ("newmark_bdf2", (("gamma_t", "2/5"), ("beta", "1/4"), ("gamma", "1/2"))): (1, Rational(-13, 18)),
        ("backward_euler", ()): (1, Rational(-1)),
    }
    for (name, values), (power, coefficient) in known.items():
        term = prescribed(name, **dict(values)).multiplier
        assert term is not None
        assert (term.power, term.coefficient) == (power, coefficient), name
    assert found("average_acceleration").start == "grows, linearly"
    assert prescribed("generalized_alpha", rho_inf="4/5").decay == Rational(4, 5)
    assert found("bathe").start == "gone after 3 steps at the latest"


def test_closed_forms_say_which_composites_have_a_multiplier_of_second_order() -> None:
    """Newmark's (gamma - 1/2) h; of the scheme of the thesis beta can be chosen, of Bathe's the sub-step."""
    term = derive("newmark").prescribed.multiplier
    assert term is not None
    assert simplify(term.coefficient - (Rational(1, 2) - gamma)) == 0
    second = gamma * (gamma_t**2 - gamma_t + 1) / (3 * gamma_t**2)
    term = derive("newmark_bdf2").prescribed.multiplier
    assert term is not None
    assert simplify(term.coefficient.subs(beta, second)) == 0
    term = prescribed("newmark_bdf2", gamma_t="1/2", gamma="1/2", beta="1/2").multiplier
    assert term is not None
    assert term.power == 2
    term = derive("rho_inf_bathe").prescribed.multiplier
    assert term is not None
    assert simplify(term.coefficient.subs({rho_inf: 0, gamma_t: sqrt(3) - 1})) == 0


@pytest.mark.parametrize("name", REFUSED)
def test_what_cannot_carry_a_constraint_is_refused_with_the_reason(name: str) -> None:
    with pytest.raises(DeclarationError, match=REFUSED[name]):
        prescribed(name)
    assert CATALOGUE[name]["constrained"].startswith("refused")


@pytest.mark.every_scheme
@pytest.mark.parametrize("name", SCHEMES)
def test_schemes_whose_last_displacement_is_no_stage_let_it_drift(name: str) -> None:
    """On r = exp(t) with a long step the displacement at its end is off by more than rounding."""
    stepping = Stepping(found(name), 0.8)
    off = abs(stepping.displacement @ stepping.of_exponential(0.8) - np.exp(0.8))
    assert found(name).at_end == (off < 1e-12)
    assert found(name).at_end or off > 1e-6


@pytest.mark.every_scheme
@pytest.mark.parametrize("name", SCHEMES)
def test_the_table_has_it(name: str) -> None:
    assert CATALOGUE[name]["constrained"] == str(found(name))
