"""The integrators that programs name: every entry is a scheme or says why not, and what was measured agrees."""

import warnings
from fractions import Fraction
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, NAMES
from substep_audit.dialects import dialect, dialects
from substep_audit.named_integrators import NamedIntegrator, named_integrators, value_of
from substep_derive.declare.symbols import f

import substep as ss

ROOT = Path(__file__).parents[1]
EVERY = {f"{program}.{name}": x for program, of in named_integrators().items() for name, x in of.items()}
ONES = {name: x for name, x in EVERY.items() if x.scheme}
AUDITED = [name for name in ONES if f"{EVERY[name].program.lower()}.{EVERY[name].name}" in dialects()]


def made(x: NamedIntegrator, **arguments: float) -> ss.Scheme:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return x.of(**{**x.example, **arguments})


def test_every_program_that_is_asked_for_is_there() -> None:
    """The programs of structural dynamics that people use most, and those whose integrators are tables of many."""
    asked = {
        *("OpenSees", "suanPan", "Abaqus", "Ansys", "LS-DYNA", "Code_Aster", "CalculiX", "Nastran", "SOFA", "Chrono"),
        *("MFEM", "PETSc", "deal.II", "Simulink", "SciML"),
    }
    assert asked <= named_integrators().keys()
    assert len(EVERY) > 300


@pytest.mark.parametrize("name", EVERY)
def test_an_entry_is_a_scheme_or_says_why_not(name: str) -> None:
    x = EVERY[name]
    assert x.read
    if x.why_not:
        with pytest.raises(ValueError, match="expected an integrator that is a scheme of the catalogue, got"):
            ss.scheme_of(x.program, x.name)
        return
    s = made(x)
    assert s.name in NAMES
    assert {key for key, default in x.arguments.items() if not default} == x.example.keys()
    if x.when:
        with pytest.warns(UserWarning, match=f"is {s.name} .* only"):
            ss.scheme_of(x.program.upper(), x.name, **x.example)
    else:
        assert ss.scheme_of(x.program.lower(), x.name, **x.example) == s


@pytest.mark.parametrize("name", AUDITED)
def test_what_is_read_is_what_was_measured(name: str) -> None:
    """The dialects were found by running the programs; equal schemes may have different names, and states.

    Eigenvalues of the one with the smaller state are those of the other, and both are all where states are alike.
    """
    x = EVERY[name]
    measured = f"{x.program.lower()}.{x.name}"
    taken = dialects()[measured].arguments
    near = {k: value * 0.97 for k, value in x.example.items() if k in taken}
    for given in (x.example, near):
        values: dict[str, float] = dict(x.example) | given
        for argument, default in x.arguments.items():
            values.setdefault(argument, float(value_of(default, values)) if default else float("nan"))
        read, found = made(x, **values), dialect(measured, **{k: values[k] for k in taken})
        for Omega in (0.3, 1.0, 4.0):
            for xi in (0.0, 0.2) if read.info.damping and found.info.damping else (0.0,):
                mine, theirs = (np.linalg.eigvals(s.amplification(Omega, xi)) for s in (read, found))
                less, more = sorted((z[np.abs(z) > 1e-6] for z in (mine, theirs)), key=len)
                apart = np.abs(less[:, None] - more)
                assert apart.min(axis=1).max() < 1e-7, (read, found)
                assert len(less) < len(more) or apart.min(axis=0).max() < 1e-7, (read, found)


def test_arguments_are_those_of_the_program() -> None:
    call: Any = ss.scheme_of
    for program, name, given, message in (
        ("OpenSees", "Newmarks", {}, "got 'Newmarks'; .*Newmark[,1']"),
        ("OpenSee", "HHT", {}, "did you mean 'OpenSees'"),
        ("OpenSees", "Newmark", {"gamma": 0.5}, "expected beta, which OpenSees's Newmark has no default for, got none"),
        ("OpenSees", "Newmark", {"gamma": 0.5, "beat": 0.25}, "did you mean 'beta'"),
        ("OpenSees", "Newmark", {"gamma": "1/2", "beta": 0.25}, "expected gamma"),
        ("OpenSees", "Newmark", {"gamma": 0.5, "beta": -1.0}, "beta of newmark"),
    ):
        with pytest.raises(ValueError, match=message):
            call(program, name, **given)


@pytest.mark.parametrize(("text", "value"), {"(2 - a)**2/4": 0.3025, "-a/3 + 1": 0.7, "3/2 - a": 0.6}.items())
def test_expressions_are_evaluated(text: str, value: float) -> None:
    assert value_of(text, {"a": Fraction(9, 10)}) == Fraction(str(value))
    assert float(value_of("2 - 2**(1/2)", {})) == 2 - 2**0.5


@pytest.mark.parametrize(
    "text",
    ["b", "1/(a - a)", "(a - 1)**(1/2)", "abs(a)", "a.real", "__import__('os')", "a if a else 1", "'a'", "a and a"],
)
def test_nothing_else_is_evaluated(text: str) -> None:
    with pytest.raises(ValueError, match="expected an expression in a, got|expected arguments at which"):
        value_of(text, {"a": 0.9})


def test_the_page_is_what_is_generated(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT))
    from audits.named import page

    text = page()
    assert (ROOT / "docs" / "catalogue_of_programs.md").read_text(encoding="utf-8") == text
    assert all(f"`{x.name}`" in text or f"`{x.name} (" in text for x in EVERY.values())


M, C, STIFF, CUBIC, H = 1.3, 0.2, 4.0, 9.0, 0.1


def opensees_generalized_alpha(alphaM: float, alphaF: float, cubic: float, steps: int, iterations: int) -> np.ndarray:
    """u of M a + C v + STIFF u + cubic u^3 = cos(2 t), as newStep, formUnbalance and update of its source do."""
    beta, gamma = (1 + alphaM - alphaF) ** 2 / 4, 0.5 + alphaM - alphaF
    c2, c3 = gamma / (beta * H), 1 / (beta * H**2)
    U, V = 0.4, -0.3
    A = (1 - C * V - STIFF * U - cubic * U**3) / M
    rows = [U]
    for n in range(steps):
        Ut, Vt, At = U, V, A
        V = (1 - gamma / beta) * Vt + H * (1 - gamma / (2 * beta)) * At
        A = -Vt / (beta * H) + (1 - 1 / (2 * beta)) * At
        u, v, a = Ut, (1 - alphaF) * Vt + alphaF * V, (1 - alphaM) * At + alphaM * A  # what the nodes have
        for _ in range(iterations):
            left = np.cos(2 * H * (n + alphaF)) - M * a - C * v - STIFF * u - cubic * u**3
            change = left / (alphaF * (STIFF + 3 * cubic * u**2) + alphaF * c2 * C + alphaM * c3 * M)
            U, V, A = U + change, V + c2 * change, A + c3 * change
            u, v, a = (1 - alphaF) * Ut + alphaF * U, (1 - alphaF) * Vt + alphaF * V, A  # no longer weighted
        rows.append(U)
    return np.array(rows)


@pytest.mark.parametrize(
    ("name", "cubic", "iterations"), [("GeneralizedAlpha", 0.0, 1), ("GeneralizedAlpha with iterations", CUBIC, 60)]
)
@pytest.mark.filterwarnings("ignore:.* has dissipated")
def test_generalized_alpha_of_opensees_is_what_its_source_does(name: str, cubic: float, iterations: int) -> None:
    steps, given = 20, {"alphaM": 1.1, "alphaF": 0.8}
    force, tangent = (lambda u: STIFF * u + cubic * u**3), (lambda u: np.diag(STIFF + 3 * cubic * u**2))
    own: dict[str, Any] = {"internal_force": force, "tangent": tangent} if cubic else {"K": [[STIFF]]}
    load = ([1.0], lambda t: np.cos(2 * t))
    model = ss.structure([[M]], C=[[C]], u0=[0.4], v0=[-0.3], load=load, **own)
    found = ss.march(model, made(EVERY[f"OpenSees.{name}"], **given), dt=H, t_end=steps * H)
    expected = opensees_generalized_alpha(**given, cubic=cubic, steps=steps, iterations=iterations)
    assert np.abs(found.u[:, 0] - expected).max() < 1e-10
    once_more = opensees_generalized_alpha(**given, cubic=cubic, steps=steps, iterations=iterations + 1)
    assert (np.abs(once_more - expected).max() > 1e-4) == (iterations == 1)


@pytest.mark.parametrize("rho", [(0.2, 0.5, 0.9), (0.0, 0.0, 0.0), (1.0, 1.0, 1.0), (0.3, 0.6, 1.0)])
def test_gssss_v0_weighs_the_load_by_its_weighted_time_field(rho: tuple[float, ...]) -> None:
    """W_1 = (1/2 + w_1/3 + w_2/4 + w_3/5)/(1 + w_1/2 + w_2/3 + w_3/4), w as in suanPan and OpenSeismoMatlab."""
    both, product = rho[0] + rho[1], rho[0] * rho[1]
    w = (
        9 - 11 * both + 19 * product,
        -30 * (3 - 4 * both + 6 * product),
        7.5 * (25 - 37 * both + 53 * product),
        -35 * (3 - 5 * both + 7 * product),
    )
    W1 = sum(x / (k + 2) for k, x in enumerate(w)) / sum(x / (k + 1) for k, x in enumerate(w))
    (balance,) = BY_NAME["gssss_v0"].balances
    values = dict(zip(BY_NAME["gssss_v0"].values, rho, strict=True))
    assert float(balance.load.coeff(f(1)).subs(values)) == pytest.approx(W1, rel=1e-12)


def test_an_argument_of_which_nothing_is_left_is_refused() -> None:
    """Ansys takes GAMMA, or ALPHA and DELTA: with all three, GAMMA was read by nothing."""
    with pytest.raises(ValueError, match=r"GAMMA, or all that Ansys's NMK takes from it, got both.*GAMMA = 0.1"):
        ss.scheme_of("Ansys", "NMK", GAMMA=0.1, ALPHA=0.3, DELTA=0.7)
    both = ss.scheme_of("Ansys", "NMK", ALPHA=0.3, DELTA=0.7)
    assert (float(both.parameters["beta"]), float(both.parameters["gamma"])) == (0.3, 0.7)
    one = ss.scheme_of("Ansys", "NMK", GAMMA=0.1)
    assert float(one.parameters["beta"]) == pytest.approx(1.1**2 / 4.0, rel=1e-15)
