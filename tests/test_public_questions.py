"""What people wrote in public questions, typed here as they would: the answer says what is meant, or is the right one.

The questions with their addresses are `docs/questions.md`, whose lines `test_docs` runs.
"""

import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import substep as ss

PAGE = Path(__file__).parents[1] / "docs" / "questions.md"
ADDRESS = re.compile(r"\]\((https?://[^)]+)\)")
MASS, K = np.eye(2), np.array([[20.0, -10.0], [-10.0, 10.0]])


@pytest.mark.parametrize(
    ("written", "name"),
    {
        "VelocityVerlet": "central_difference",  # SciML
        "NewmarkBeta": "newmark",
        "GeneralizedAlpha": "generalized_alpha",  # OpenSees, Exudyn
        "HHTAlpha": "hht_alpha",
        "CentralDifference": "central_difference",
        "NewmarkExplicit": "central_difference",
        "WilsonTheta": "wilson_theta",
        "NewMark": "newmark",
        "rho_infinity Bathe": "rho_inf_bathe",
        "one-step theta method": "theta_method",
        "average constant acceleration": "average_acceleration",
        "Störmer": "central_difference",
    }.items(),
)
def test_names_as_programs_and_papers_write_them(written: str, name: str) -> None:
    assert ss.scheme(written).name == name


TYPED: dict[str, tuple[Callable[[], Any], str]] = {
    "an alpha of OpenSees": (lambda: ss.scheme("HHT", alpha=0.9), r'ss\.dialect\("opensees\.HHT", alpha=0\.9\)$'),
    "an alpha_m of OpenSees": (
        lambda: ss.scheme("generalized_alpha", alpha_m=1.1, alpha_f=0.8),
        r'count it from 1: ss\.dialect\("opensees\.GeneralizedAlpha", alphaM=1\.1, alphaF=0\.8\)$',
    ),
    "rho_inf of Exudyn": (lambda: ss.scheme("generalized_alpha", spectralRadius=0.8), "here it is rho_inf"),
    "rho_inf of PETSc": (lambda: ss.scheme("generalized_alpha", radius=0.8), "here it is rho_inf"),
    "Bathe's delta": (lambda: ss.scheme("newmark", delta=0.5), "here it is gamma"),
    "the symplectic Euler method": (
        lambda: ss.scheme("SymplecticEuler"),
        r"which is tchamwa_wielgosz at phi=1; write ss\.scheme\('tchamwa_wielgosz', phi=1\)",
    ),
    "KRAlphaExplicit of OpenSees": (
        lambda: ss.scheme("KRAlphaExplicit"),
        "which may be kr_alpha or kr_alpha_plain_start; write which",
    ),
    "leap-frog": (
        lambda: ss.scheme("leap-frog"),
        "may be central_difference_lagged or central_difference; write which",
    ),
    "Gear's method": (lambda: ss.scheme("Gear's method"), "which may be bdf2 or bdf3 or bdf4; write which"),
    "a damping ratio as zeta": (
        lambda: ss.response_spectrum([0.0, 1.0], dt=0.01, zeta=0.05),
        "got an unexpected keyword argument 'zeta'; here it is xi, the damping ratio; it takes",
    ),
    "frequencies of pyrotd": (
        lambda: ss.response_spectrum([0.0, 1.0], dt=0.01, osc_freqs=[1.0]),
        "here it is frequencies, in Hz; it takes",
    ),
    "a damping ratio of a structure": (lambda: ss.structure(MASS, K, zeta=0.05), "here it is C, as ss.modal_damping"),
    "a force as f": (lambda: ss.structure(MASS, K, f=np.ones(2)), "'f'; here it is load, pairs of a vector"),
    "small letters": (
        lambda: ss.structure(m=MASS, k=K, c=K),
        r"'m'; did you mean 'M'\? got .*'k'; did you mean 'K'\? got .*'c'; did you mean 'C'\? it takes M, K",
    ),
    "a load's period": (lambda: ss.Harmonic(1.0, T=2.0), "'T'; here it is omega = 2 pi/T; it takes amplitude, omega"),
    "a load's frequency": (lambda: ss.Harmonic(1.0, f=2.0), "here it is omega = 2 pi f;"),
    "a pulse's period": (lambda: ss.HalfSine(1.0, T=2.0), "here it is duration, of the pulse: half a period"),
    "a record's units": (lambda: ss.Record(0.1, [0.0, 1.0], units="g"), "'units'; here it is unit;"),
    "a file's units": (lambda: ss.read_record("motion.AT2", units="g"), "'units'; here it is unit;"),
    "a spectrum's units": (lambda: ss.response_spectrum([0.0, 1.0], dt=0.01, units="g"), "'units'; here it is unit;"),
    "a spectrum's omega": (
        lambda: ss.response_spectrum([0.0, 1.0], dt=0.01, omega=[1.0]),
        "here it is periods = 2 pi/omega;",
    ),
    "a sampling rate": (lambda: ss.response_spectrum([0.0, 1.0], sampling_rate=100.0), "here it is dt = 1/sampling_r"),
    "damping_ratio": (lambda: ss.response_spectrum([0.0, 1.0], dt=0.01, damping_ratio=0.05), "here it is xi, the"),
    "a ratio of modes": (lambda: ss.modal_damping(zeta=0.05), "'zeta'; here it is xi, the damping ratio; it takes xi"),
    "a history's frequency": (
        lambda: ss.response_spectrum([0.0, 1.0, 0.0], dt=0.01, periods=[1.0]).history(f=1.0),
        "'f'; here it is T = 1/f; it takes T, xi",
    ),
    "Newmark's alpha of Bathe's books": (lambda: ss.scheme("newmark", alpha=0.25), "here it is beta, which Bathe's"),
    "a ratio of a march": (
        lambda: ss.march(ss.structure(MASS, K), "bathe", dt=0.1, t_end=1.0, zeta=0.05),
        r"here it is C, as .* ratios; C is an argument of ss\.structure\(M, K, C=\.\.\.\)",
    ),
    "xi of a march": (
        lambda: ss.march("linear_oscillator", "bathe", dt=0.1, t_end=1.0, xi=0.05),
        r"got 'xi'; xi is an argument of ss\.scene\('linear_oscillator', xi=\.\.\.\)",
    ),
    "rho_inf of a march": (
        lambda: ss.march(ss.structure(MASS, K), "generalized_alpha", dt=0.1, t_end=1.0, rho_inf=0.5),
        r"rho_inf is an argument of ss\.scheme\('generalized_alpha', rho_inf=\.\.\.\)",
    ),
    "the end as T": (lambda: ss.march(ss.structure(MASS, K), "bathe", dt=0.1, T=1.0), "got 'T'; here it is t_end;"),
    "a force as F": (lambda: ss.structure(MASS, K, F=np.ones((2, 9))), "here it is load, pairs of a vector"),
    "an argument that is nothing here": (
        lambda: ss.structure(MASS, K, colour="red"),
        "got an unexpected keyword argument 'colour'; it takes",
    ),
    "a number of steps": (
        lambda: ss.march(ss.structure(MASS, K), "bathe", dt=0.1, steps=10),
        "got 'steps'; here it is t_end = steps dt;",
    ),
    "the interval of solve_ivp": (
        lambda: ss.march("duffing", "bathe", dt=0.1, t_span=(0, 10)),
        "got 't_span'; here it is t_end, as runs begin at t = 0;",
    ),
    "damping as a ratio": (lambda: ss.structure(MASS, K, C=0.05), r"C=ss\.modal_damping\(0\.05, modes=10\)"),
    "damping in percent": (lambda: ss.rayleigh(5.0, 5.0, at=(1.0, 9.0)), "5 % is 0.05"),
    "a start of the structure": (
        lambda: ss.march(ss.structure(MASS, K), "bathe", dt=0.1, t_end=1.0, u0=[1.0, 0.0]),
        r"ss\.structure\(M, K, u0=\.\.\.\); a run begins elsewhere by start=",
    ),
    "a load of the modes": (
        lambda: ss.march(ss.structure(MASS, K).modes(2), "bathe", dt=0.1, t_end=1.0, load=np.ones(2)),
        r"ss\.structure\(M, K, load=\.\.\.\)",
    ),
    "a load as a matrix": (
        lambda: ss.structure(MASS, K, load=np.ones((2, 9))),
        r"\(\{i: 1\.0\}, ss\.Record\(dt, F\[i\]\)\)",
    ),
    "a load as a vector": (
        lambda: ss.structure(MASS, K, load=np.ones(2)),
        r"as \(P, ss\.Step\(1\.0\)\) for a vector P",
    ),
    "a load as a function": (lambda: ss.structure(MASS, K, load=np.sin), r"give \(P, g\), where P says how much"),
    "one degree of freedom": (
        lambda: ss.structure(1.0, 4.0),
        r"M .* got shape \(\); of one degree .* give \[\[1\.0\]\]",
    ),
    "its stiffness": (lambda: ss.structure([[1.0]], 4.0), r"K .* got shape \(\); of one degree .* give \[\[4\.0\]\]"),
    "a diagonal": (lambda: ss.structure([1.0, 1.0], K), r"of a diagonal give np\.diag"),
    "a period of a spectrum": (
        lambda: ss.response_spectrum([0.0, 1.0], dt=0.01, T=[1.0]),
        "argument 'T'; here it is periods, in s; it takes",
    ),
    "the exact response as a scheme": (
        lambda: ss.response_spectrum([0.0, 1.0], dt=0.01, scheme="Nigam-Jennings"),
        r'displacement/\(1 \+ displacement_error\), or take scheme="dormand_prince", .* with refine="auto"',
    ),
    "no mass in an explicit scheme": (
        lambda: ss.march(ss.structure(np.diag([1.0, 0.0]), K), "central_difference", dt=0.1, t_end=1.0),
        "take an implicit scheme, such as bathe",
    ),
}


@pytest.mark.parametrize("typed", TYPED)
def test_what_is_refused_is_answered_with_the_cure(typed: str) -> None:
    call, answer = TYPED[typed]
    with pytest.raises((ValueError, TypeError), match=answer):
        call()


def test_the_symplectic_euler_method_is_what_it_is_said_to_be() -> None:
    """Against its definition: v1 = v0 - h omega^2 u0, u1 = u0 + h v1."""
    omega, h = 3.0, 0.1
    r = ss.march(ss.scene("linear_oscillator", omega=omega), ss.scheme("tchamwa_wielgosz", phi=1), dt=h, t_end=10 * h)
    u, v = 1.0, 0.0
    for n in range(1, 11):
        v -= h * omega**2 * u
        u += h * v
        assert (r.u[n, 0], r.v[n, 0]) == pytest.approx((u, v), abs=1e-12)


def test_a_heading_an_address_each() -> None:
    """Thirty-seven questions, each with where it was asked, at no address twice."""
    asked = re.split(r"^### ", PAGE.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    addresses = [ADDRESS.search(question) for question in asked]
    assert len(asked) == 37
    assert all(addresses)
    assert len({address[1] for address in addresses if address}) == 37
