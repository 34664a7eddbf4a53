"""Closed forms against stepping the textbook's equations, and against each other."""

import nonlinear_oracle
import numpy as np
import oracle
import pytest
import sympy as sp
from declared import BY_NAME, NAMES, derived, for_oracle, near, random_parameters
from oracle import amplification as stepped
from oracle import entry
from substep_derive import Scheme, derive
from substep_derive.algebra.constant import reduced
from substep_derive.declare.symbols import K0, C, K_t, M, N, Omega, beta, f, gamma, gamma_t, h, mu, xi
from substep_derive.step.step import Step
from sympy import Matrix, Rational, cancel, symbols


def point(scheme: Scheme, rng: np.random.Generator) -> tuple[dict[str, Rational], Rational, Rational]:
    """Random parameters, Omega and xi, exact."""
    omega = Rational(int(rng.integers(1, 600)), 100)
    return random_parameters(scheme, rng), omega, Rational(int(rng.integers(0, 100)), 100)


def at(values: dict, omega: Rational, damping: Rational) -> dict:
    return {sp.Symbol(key): value for key, value in values.items()} | {Omega: omega, xi: damping}


def floats(values: dict[str, Rational]) -> dict[str, float]:
    return {key: float(value) for key, value in values.items()}


@pytest.mark.parametrize("name", NAMES)
def test_every_entry_equals_the_stepped_one(name: str) -> None:
    scheme, d = BY_NAME[name], derived(name)
    rng = np.random.default_rng(sum(map(ord, name)))
    for _ in range(8):
        values, omega, damping = point(scheme, rng)
        other, numbers = for_oracle(scheme, values)
        assert d.state == entry(other).state
        exact = np.array(d.A.subs(at(values, omega, damping) | near(scheme)), dtype=float)
        expected = np.array(stepped(other, float(omega), float(damping), floats(numbers)), dtype=float)
        assert np.abs(exact - expected).max() <= 1e-12 * max(1.0, np.abs(expected).max())


@pytest.mark.parametrize("name", NAMES)
def test_forced_step_and_what_it_reports_equal_the_stepped_ones(name: str) -> None:
    scheme, d = BY_NAME[name], derived(name)
    rng = np.random.default_rng(1 + sum(map(ord, name)))
    for _ in range(4):
        values, omega, damping = point(scheme, rng)
        where = at(values, omega, damping) | near(scheme)
        x0 = rng.normal(size=len(d.state))

        def load(tau: float) -> float:
            return 0.3 + tau * (1.7 - 0.4 * tau)

        other, numbers = for_oracle(scheme, values)
        x1, reported = entry(other).step(x0, float(omega), float(damping), floats(numbers), load)
        forces = Matrix([load(float(tau.subs(where))) for tau in d.stencil])
        after = d.A.subs(where) * Matrix(x0) + d.load.subs(where) * forces
        assert np.allclose(np.array(after, dtype=float).ravel(), x1, rtol=1e-12, atol=1e-12)
        a = d.amplification
        outputs = (a.outputs.N * Matrix(x0) + a.outputs.load_N * forces).subs(where) / a.outputs.den.subs(where)
        own_report, rest = [], list(outputs)
        for place in a.in_state:
            own_report.append(float(after[place]) if place >= 0 else float(rest.pop(0)))
        if name != "kr_alpha_plain_start":  # the oracle reports the corrected velocity
            assert np.allclose(own_report, reported, rtol=1e-12, atol=1e-12)


@pytest.mark.matrix
@pytest.mark.parametrize("name", [s for s in NAMES if s not in ("kr_alpha_plain_start", "central_difference_lagged")])
def test_a_step_that_nobody_has_written_is_the_one_that_is_declared(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """As the oracle takes it then: here against the steps that are written. Without one a scheme states its claims.

    But for one whose report is not the oracle's, as above, and one whose velocities stand at half steps.
    """
    scheme = BY_NAME[name]
    values, omega, damping = point(scheme, np.random.default_rng(7))
    other, numbers = for_oracle(scheme, values)
    claims = scheme.published
    assert nonlinear_oracle.written(other) or (claims is not None and None not in (claims.order, claims.rho_inf))
    x0 = np.random.default_rng(8).normal(size=len(scheme.state))
    rest = float(omega), float(damping if scheme.takes_damping else 0)

    def load(tau: float) -> float:
        return 0.3 + tau * (1.7 - 0.4 * tau)

    expected = entry(other).step(x0, *rest, floats(numbers), load)
    for module in (oracle, nonlinear_oracle):
        monkeypatch.setattr(module, "written", lambda _: False)
    found = entry.__wrapped__(name).step(x0, *rest, floats(values), load)
    for one, same in zip(found, expected, strict=True):
        assert np.allclose(one, same, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("name", NAMES)
def test_characteristic_polynomial_is_that_of_the_matrix(name: str) -> None:
    scheme, d = BY_NAME[name], derived(name)
    values, omega, damping = point(scheme, np.random.default_rng(2 + sum(map(ord, name))))
    where = at(values, omega, damping)
    matrix = d.A.subs(where).applyfunc(reduced)
    expected = sp.Poly(reduced(matrix.charpoly(mu).as_expr().subs(mu, 1 + mu)), mu).monic()
    assert sp.Poly(d.charpoly.as_expr().subs(where), mu).monic() == expected
    assert reduced(d.det.subs(where) - matrix.det()) == 0


def test_the_thesis_s_order_is_the_reversed_one() -> None:
    d = derive("newmark_bdf2")
    assert d.state == ("u", "h*v", "h^2*a")
    assert d.A_thesis[2, 0] == d.A[0, 2]
    assert d.A_thesis[0, 1] == d.A[2, 1]


def test_bathe_is_the_composite_at_half_and_silva_bezerra_its_trapezoidal_member() -> None:
    half, quarter = Rational(1, 2), Rational(1, 4)
    composite = derive("newmark_bdf2")
    bathe = composite.A.subs({gamma_t: half, beta: quarter, gamma: half})
    assert (bathe - derive("bathe").A).applyfunc(cancel) == sp.zeros(3, 3)
    silva = composite.A.subs({beta: quarter, gamma: half})
    assert (silva - derive("silva_bezerra").A).applyfunc(cancel) == sp.zeros(3, 3)


def test_effective_stiffness_and_residual_are_the_thesis_s_with_damping() -> None:
    first, second = derive("newmark_bdf2").balances
    u0, v0, a0, ug, vg, u1 = symbols("u_0 v_0 a_0 u_g v_g u_1")
    sub = gamma_t * h
    a = (ug - u0) / (beta * sub**2) - v0 / (beta * sub) - (1 / (2 * beta) - 1) * a0  # (3.4)
    v = (
        gamma / (beta * sub) * (ug - u0)
        + (1 - gamma / beta) * v0
        + sub * (1 - gamma - gamma * (1 / (2 * beta) - 1)) * a0
    )
    assert first.unknown == ug
    assert cancel(first.recover_a - a) == 0
    assert cancel(first.recover_v - v) == 0  # (3.5)
    assert cancel(first.residual - (M * a + C * v + N(ug) - f(gamma_t))) == 0  # (3.8)
    assert first.tangent == K_t(ug)  # (3.10)
    stiffness = M / (beta * sub**2) + gamma * C / (beta * sub) + K_t(ug)  # (3.9)
    assert cancel(first.effective_stiffness - stiffness) == 0
    c1, c2 = (1 - gamma_t) / (gamma_t * h), -1 / ((1 - gamma_t) * gamma_t * h)  # (3.14), (3.15)
    c3 = (2 - gamma_t) / ((1 - gamma_t) * h)  # (3.16)
    v = c1 * u0 + c2 * ug + c3 * u1
    a = c1 * v0 + c2 * vg + c3 * c1 * u0 + c3 * c2 * ug + c3**2 * u1  # (3.17)
    assert second.unknown == u1
    assert cancel(second.recover_v - v) == 0
    assert cancel(second.recover_a - a) == 0
    assert cancel(second.residual - (M * a + C * v + N(u1) - f(1))) == 0  # (3.20)
    assert cancel(second.effective_stiffness - (c3**2 * M + c3 * C + K_t(u1))) == 0  # (3.21)


@pytest.mark.parametrize("name", NAMES)
def test_effective_system_is_consistent(name: str) -> None:
    for k, system in enumerate(derived(name).balances):
        slope = sp.diff(system.residual, system.unknown)
        assert cancel(slope.doit() - system.effective_stiffness.doit()) == 0
        if system.beside:  # the row of a block: the chain rule leads from displacements to its own acceleration
            scheme = BY_NAME[name]
            (stage,) = [stage for stage in Step.of(scheme).stages if not stage.alone]
            z = stage.z[list(stage.balances).index(scheme.balances[k])]
            row = {system.unknown: system.effective_stiffness, **system.beside}
            mass = sum(e * stage.in_z.get(s, s).diff(z) for s, e in row.items())
            forces = {atom: sp.Dummy() for atom in (mass - system.effective_mass).atoms(K_t)}
            left = (mass - system.effective_mass).subs(near(scheme)).subs(forces)
            assert all(abs(e) < 1e-30 for e in sp.Poly(left, C, M, h, *forces.values()).coeffs())
        elif not system.explicit and not system.tangent.atoms(sp.Derivative):
            mass = system.effective_stiffness * system.c_u
            assert cancel(mass - system.effective_mass) == 0
        else:
            assert not system.explicit or not system.effective_mass.atoms(K_t)


@pytest.mark.parametrize(
    ("name", "stages", "explicit"),
    [
        ("newmark", 1, False),
        ("bathe", 2, False),
        ("rk4", 4, True),
        ("houbolt", 1, False),
        ("kr_alpha_plain_start", 1, True),
        ("noh_bathe", 2, True),
        ("wilson_theta", 1, False),
    ],
)
def test_explicit_is_found_and_not_declared(name: str, stages: int, explicit: bool) -> None:
    systems = derived(name).balances
    assert [system.explicit for system in systems] == [explicit] * stages


def test_structure_dependent_coefficients_stay_symbolic_in_the_effective_mass() -> None:
    (system,) = derived("kr_alpha").balances
    assert {M, C, K0} <= system.effective_mass.free_symbols


def test_leading_terms_and_limits_of_known_schemes() -> None:
    assert derive("bathe").rho_inf == 0
    assert derive("silva_bezerra").rho_inf == 0
    assert (
        cancel(derive("newmark_bdf2").rho_inf.args[0] ** 2 - ((2 * beta - gamma) / (2 * beta * (1 - gamma_t))) ** 2)
        == 0
    )
    average = derive("newmark", beta="1/4", gamma="1/2")
    assert average.rho_inf == 1
    assert average.series.order == 2
    assert average.series.period_error[2].subs(xi, 0) == Rational(1, 12)
    assert derive("newmark", beta=0, gamma="1/2").rho_inf == sp.oo
    assert derive("newmark").series.order == 1
    for name, order in (("sdirk2", 2), ("crouzeix3", 3), ("forest_ruth", 4)):  # at the root that is the default
        assert derive(name).series.order == order
    fox_goodwin = derive("newmark", beta="1/12", gamma="1/2").series
    assert all(
        term.subs(xi, 0) == 0 for term in (*fox_goodwin.period_error.values(), *fox_goodwin.numerical_damping.values())
    )
    assert derive(BY_NAME["rk4"]).series.order == 4


@pytest.mark.parametrize("damping", [Rational(0), Rational(1, 20), Rational(7, 10)])
@pytest.mark.parametrize(
    "name", ["newmark", "bathe", "newmark_bdf2", "wilson_theta", "generalized_alpha", "houbolt", "rk4"]
)
def test_series_predicts_the_eigenvalue(name: str, damping: Rational) -> None:
    """Both errors from 40-digit eigenvalues of A at Omega = 1e-4 agree with the series to O(Omega)."""
    import mpmath

    scheme = BY_NAME[name]
    values = random_parameters(scheme, np.random.default_rng(3))
    d = derive(scheme.fix(values) if values else scheme)
    with mpmath.workdps(60):
        small = Rational(1, 10**4)
        p = sp.Poly(d.charpoly.as_expr().subs({Omega: small, xi: damping}), mu)
        roots = mpmath.polyroots(
            [mpmath.mpf(int(c.p)) / int(c.q) for c in p.monic().all_coeffs()], maxsteps=200, extraprec=400
        )
        root = min((1 + r for r in roots if r.imag > 0), key=lambda r: abs(r - 1))
        phi, ratio = mpmath.arg(root), mpmath.mpf(int(damping.p)) / int(damping.q)
        root_d = mpmath.sqrt(1 - ratio**2)
        found = (-mpmath.log(abs(root)) / phi - ratio / root_d, mpmath.mpf(1) / 10**4 * root_d / phi - 1)
        for value, terms in zip(found, (d.series.numerical_damping, d.series.period_error), strict=True):
            series = sum((sp.N(c.subs(xi, damping), 50) * small**k for k, c in terms.items()), sp.Integer(0))
            scale = max((abs(float(c.subs(xi, damping))) * 1e-4**k for k, c in terms.items()), default=0.0)
            assert abs(float(value - mpmath.mpf(str(series)))) <= 1e-6 * scale + 1e3 * 1e-16


def test_derivation_does_not_depend_on_the_order_of_relations() -> None:
    scheme = BY_NAME["newmark_bdf2"]
    shuffled = Scheme(
        scheme.name,
        dict(reversed(list(scheme.relations.items()))),
        scheme.balances,
        scheme.parameters,
        reference=scheme.reference,
    )
    assert derive(shuffled).A == derive(scheme).A
