"""The examples are the models that their docstrings describe: exact frequencies, deflections, energies and masses."""

from typing import Any

import numpy as np
import pytest
from scipy.linalg import eigh

import substep as ss
from substep.structures.examples import Section, bar, cantilever, continua, frame, frames, plate, simple_beam, solid


def frequencies(model: ss.Structure) -> Any:
    """Circular frequencies, ascending."""
    return np.sqrt(eigh(model.M.toarray(), model.K.toarray(), eigvals_only=True)[::-1] ** -1)


def whole(model: ss.Structure, q: Any) -> dict[str, float]:
    """Displacement by name, of free ones q."""
    return dict(zip(model.names, model.T @ q, strict=True))


def deflected(model: ss.Structure) -> dict[str, float]:
    """By name, under the load at t = 1."""
    return whole(model, np.linalg.solve(model.K.toarray(), model.force(1.0)))


def nearest(found: Any, exact: Any) -> Any:
    """Of each exact frequency, the one of the model that is nearest to it."""
    return found[np.abs(found[:, None] / exact - 1).argmin(axis=0)]


def test_a_cantilevers_frequencies_and_deflection() -> None:
    """Roots of cos x cosh x = -1, and P L^3/(3 EI)."""
    section, L = frames.STEEL, 3.0
    model = cantilever(12, load=ss.Step(1e3))
    roots = np.array([1.8751040687, 4.6940911330, 7.8547574382])
    exact = roots**2 * np.sqrt(section.EI / section.mass) / L**2
    assert nearest(frequencies(model), exact) == pytest.approx(exact, rel=2e-4)
    assert deflected(model)["uy at 3"] == pytest.approx(1e3 * L**3 / (3 * section.EI), rel=1e-9)


def test_a_deep_beams_frequencies() -> None:
    """Those of a simply supported Timoshenko beam, each n a system of two equations."""
    area, inertia, E, rho, L = 4.0, 16 / 12, 200e9, 8000.0, 10.0
    GA = 5 / 6 * area * E / 2.6
    exact = []
    for n in range(1, 4):
        k = n * np.pi / L
        pair = eigh([[GA * k * k, -GA * k], [-GA * k, E * inertia * k * k + GA]], np.diag([rho * area, rho * inertia]))
        exact.append(np.sqrt(pair[0][0]))
    error = [np.abs(nearest(frequencies(simple_beam(n)), exact) / exact - 1) for n in (20, 40)]
    assert error[1].max() < 1e-3
    assert error[0] / error[1] == pytest.approx(4.0, rel=0.05)  # the mass of a deep element is not exact
    assert exact[0] / 2 / np.pi == pytest.approx(42.6, abs=0.05)


@pytest.mark.parametrize("ratio", [0.1, 1.0, 30.0])
def test_a_portal_frames_sway(ratio: float) -> None:
    """H h^3/(12 EI) (2 + 3k)/(1 + 6k) with k = (EI/l of the beam)/(EI/h of the columns), from slope deflection."""
    EI, h, width = 2e3, 3.0, 6.0
    column = Section(EA=1e10, EI=EI, mass=1.0)
    model = frame(1, 1, height=h, width=width, per_member=1, column=column,
                  beam=Section(EA=1e10, EI=ratio * EI * width / h, mass=1.0), load=ss.Step(10.0))  # fmt: skip
    exact = 10.0 * h**3 / (12 * EI) * (2 + 3 * ratio) / (1 + 6 * ratio)
    assert deflected(model)["ux at 0 3"] == pytest.approx(exact, rel=1e-5)


def test_a_frames_members_share_their_nodes() -> None:
    model = frame(2, 3, per_member=2)
    assert len(model.names) == 3 * (4 + 2 * 4 + 2 * 4 + 2 * 3)
    assert model.size == len(model.names) - 3 * 4
    assert np.linalg.eigvalsh(model.K.toarray())[0] > 0.0


def test_a_bars_frequencies() -> None:
    """Fixed-free: (n - 1/2) pi c/L, approached from above by the consistent and from below by the lumped mass."""
    exact = (np.arange(1, 4) - 0.5) * np.pi * 2.0 / 3.0
    for lumped, sign in ((False, 1), (True, -1)):
        found = frequencies(bar(60, length=3.0, E=4.0, lumped=lumped))[:3]
        assert found == pytest.approx(exact, rel=1e-3)
        assert (sign * (found - exact) > 0).all()


def test_a_plates_frequencies() -> None:
    """pi^2 (m^2 + n^2)/a^2 sqrt(D/(rho t))."""
    D = 200e9 * 0.05**3 / 12 / 0.91
    exact = np.pi**2 / 100 * np.sqrt(D / 400) * np.array([2, 5, 5, 8])
    error = [frequencies(plate(n))[:4] / exact - 1 for n in (5, 10)]
    assert (error[1] > 0).all()
    assert error[1].max() < 1e-4
    assert error[0] / error[1] == pytest.approx(16.0, rel=0.1)


def test_a_solids_energies() -> None:
    """Exact for displacements linear in x: V (lambda + 2 mu)/2 stretched, V mu/2 sheared, rho V/6 moving."""
    E, nu, rho, size = 7.0, 0.25, 3.0, (2.0, 1.0, 0.5)
    lame, mu, V = E * nu / (1 + nu) / (1 - 2 * nu), E / 2 / (1 + nu), 1.0
    for lumped in (False, True):
        model = solid((4, 2, 2), size=size, E=E, nu=nu, rho=rho, lumped=lumped, load=ss.Step(1.0))
        assert model.size == 3 * 4 * 3 * 3
        for component, modulus in (("ux", lame + 2 * mu), ("uy", mu), ("uz", mu)):
            x = [float(name.split()[2]) if name.startswith(component) else 0.0 for name in model.names]
            q = model.T.T @ np.array(x)
            assert 0.5 * q @ model.K @ q == pytest.approx(0.5 * V * modulus, rel=1e-12)
            if not lumped:
                assert 0.5 * q @ model.M @ q == pytest.approx(0.5 * rho * V * 4 / 3, rel=1e-12)
        assert model.full_mass.sum() == pytest.approx(3 * rho * V, rel=1e-12)
        loaded = [(name, P) for name, P in zip(model.names, model.T @ model.force(1.0), strict=True) if P]
        assert loaded == [("uz at 2 1 0.5", 1.0)]


def test_without_scikit_fem_the_error_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(continua, "find_spec", lambda _: None)
    for model in (plate, solid):
        with pytest.raises(ValueError, match=r"scikit-fem.*pip install 'substep\[fem\]'"):
            model()


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: cantilever(2.5), "elements to be a whole number"),  # type: ignore[arg-type]
        (lambda: cantilever(length=-1.0), "length > 0"),
        (lambda: frame(0), "stories to be a whole number"),
        (lambda: bar(rho=0.0), "rho > 0"),
        (lambda: plate(thickness=0.0), "thickness > 0"),
        (lambda: solid((2, 0, 2)), "cells in y to be a whole number"),
        (lambda: Section.rectangle(1.0, -2.0, E=1.0, rho=1.0), "depth > 0"),
        (lambda: frames.assembled([(0, 0), (0, 0)], [(0, 1, frames.STEEL)]), "between two places"),
    ],
)
def test_wrong_dimensions_are_refused(call: Any, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        call()
