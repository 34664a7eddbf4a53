"""What schemes are where the mass moves, derived in trees: orders of both readings, and the energy to expect."""

import numpy as np
import pytest
from declared import BY_NAME, NAMES, OF_STIFFNESS, UNDAMPED, mixes_otherwise
from substep_derive import DeclarationError, ModifiedMotion, order_of_rates
from substep_derive.declare.catalogue import find_scene
from substep_derive.nonlinear.modified import modified_equation
from substep_derive.oscillator.evaluation import Evaluation
from substep_kernels.facts import CATALOGUE

import substep as ss

MIXED = (name for name, s in BY_NAME.items() if mixes_otherwise(s) and name != "discontinuous_galerkin_p1")
REFUSED = ("energy_momentum", "gholampour", *sorted({*OF_STIFFNESS, *UNDAMPED, *MIXED}))
READ = [name for name in NAMES if name not in REFUSED]
SLOW = ("butcher6", "gauss3", "radau_iia3", "crouzeix4", "four_substep")
# their balances mix forces of inertia of one instant with forces of another, so that what they keep as acceleration is
# that of another instant too; that of ss32, which does so as well, is not
LOSES = ("ss32", *(name for name in READ if CATALOGUE[name]["order"][2] < CATALOGUE[name]["order"][0]))


def at_defaults(name: str) -> Evaluation:
    return Evaluation.at_defaults(name)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.thorough) if name in SLOW else name for name in READ]
)
def test_no_scheme_loses_an_order_where_forces_have_rates(name: str) -> None:
    """Orders on a constant damping were found from other trees, and by runs."""
    constant = CATALOGUE[name]["nonlinear_order"]
    moving, _ = order_of_rates(at_defaults(name))
    assert moving[:2] == tuple(min(order, 6) for order in constant[:2])


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_reading_is_refused_by_name(name: str) -> None:
    with pytest.raises(DeclarationError, match=f"{name}: expected .* take another scheme"):
        order_of_rates(at_defaults(name))


@pytest.mark.parametrize("name", [name for name in READ if name not in SLOW])
def test_mixed_forces_of_inertia_lose_an_order_if_they_stand_at_another_instant(name: str) -> None:
    """The other reading of a balance: sum of M(u_k) a_k. Runs of it have 1.05 (test_lagrange)."""
    if name in ("discontinuous_galerkin_p1", "theta_method"):  # their inertia is a difference of velocities
        with pytest.raises(DeclarationError, match="expected a mixture of accelerations at knots, got v_0"):
            order_of_rates(at_defaults(name), mixed=True)
        return
    (plain, _), (mixed, wrong) = (order_of_rates(at_defaults(name), mixed=m) for m in (False, True))
    if name in LOSES:
        assert mixed[:2] == (1, 1)
        assert wrong[0].tree == "M[N[]; v]"
    else:
        assert mixed[:2] == tuple(min(order, 5) for order in plain[:2])


@pytest.mark.usefixtures("uncompiled")
@pytest.mark.every_scheme
@pytest.mark.parametrize(
    "name",
    [
        name if name in ("average_acceleration", "bathe") else pytest.param(name, marks=pytest.mark.thorough)
        for name in READ
    ],
)
def test_the_energy_that_is_reported_on_the_double_pendulum(name: str) -> None:
    scene, order = ss.scene("double_pendulum"), min(CATALOGUE[name]["nonlinear_order"][:2])
    dt = 2.5e-3 if order in (4, 5) else 5e-3
    if name in ("central_difference_lagged", "discontinuous_galerkin_p1"):
        with pytest.raises(DeclarationError, match="take another scheme"):
            ss.march(scene, name, dt=dt, t_end=dt)
        return
    found = ss.energy_drift(scene, name, t_end=1.0)
    r = ss.march(scene, name, dt=dt, t_end=1.0)
    rows = r.energy[:: round(5e-3 / dt)]
    predicted, marched = (e[20:] - e[20] for e in (found.energy(dt), rows))  # after what the start has left
    assert abs(predicted - marched).max() < 0.05 * abs(marched).max()


def test_no_modified_energy_is_claimed_where_the_mass_moves() -> None:
    found = ModifiedMotion.of(BY_NAME["backward_euler"], find_scene("double_pendulum"), 1)
    assert [*found.energy_rates] == [1]
    with pytest.raises(DeclarationError, match="expected a constant mass and forces of the coordinates"):
        _ = found.energy


@pytest.mark.parametrize("name", ["bathe", "houbolt", "hht_alpha", "bdf3"])
def test_a_damper_taken_as_any_force_of_rates_changes_no_term(name: str) -> None:
    """On N(u, v) = u + C v the terms are those of a constant damping."""
    constant, moving = (modified_equation(at_defaults(name), 3, damping=not r, rates=r) for r in (False, True))

    def at(equation: object, xi: float) -> np.ndarray:
        of = equation.of  # type: ignore[attr-defined]

        def value(tree: int) -> np.ndarray:
            kind, branches = of.keys[tree]
            if kind in "uv":
                return np.array([kind == "u", kind == "v"], dtype=float)
            if not branches:
                return np.array([1.0, 2 * xi * of.rates])
            by_rate = kind == "C" or branches[0] < 0
            of_branch = value(max(branches[0], ~branches[0]))
            return (len(branches) == 1) * (2 * xi if by_rate else 1.0) * of_branch

        number = equation.evaluation.field.expression  # type: ignore[attr-defined]
        terms = equation.terms.items()  # type: ignore[attr-defined]
        return np.array([sum(float(number(c)) * value(tree) for tree, c in level.items()) for _, level in terms])

    for xi in (0.0, 0.3, 2.0):
        assert at(moving, xi) == pytest.approx(at(constant, xi), rel=1e-12, abs=1e-12)
