"""The account of energy of a linear run by the scheme's own energy, in which what the scheme dissipates is exact."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from ..core.arrays import Array
from ..core.errors import called_as
from ..core.exports import Exported
from ..core.loads import Load, values_at
from ..core.response import Response
from ..structures.march.response import StructureResponse
from ..structures.structure import Structure
from .modified_energy import ModifiedEnergy

SMALL = 1e-9  # of what rounding leaves of a jump of the acceleration, or beside the diagonal of modal damping
CLOSED = 1e-6  # of the largest energy that an account may leave over: rounding leaves much less, another step more
KINDS = {"u": 0, "h*v": 1, "h^2*a": 2}  # what a state's labels begin with, and the power of h


@dataclass(frozen=True, eq=False)
class OwnEnergy(Exported):
    """The scheme's own energy (n,) at the times t (n,), s, and what has changed it since the first of them, (n,) each.

    energy - energy[0] = work - damped - numerical + left. On a linear model `left` is rounding, and energy is (k/2) U^2
    of each mode, with its stiffness k and the amplitude U of u in the scheme's free undamped motion through the state.
    work: of the loads. damped: by the damping, as a force on the undamped scheme. numerical: by the scheme itself. On a
    nonlinear scene energy is the modified energy, T + V with further terms in powers of the step, work and damped are
    0, and `left` is what powers beyond these and the start have added: small where steps resolve the motion. In the
    unit of the run's energy.
    """

    axes: ClassVar = dict.fromkeys(("t", "energy", "work", "damped", "numerical"), ("t",))

    t: Array
    energy: Array
    work: Array
    damped: Array
    numerical: Array

    @property
    def left(self) -> Array:
        """What the account does not explain (n,)."""
        return self.energy - self.energy[0] - (self.work - self.damped - self.numerical)


@dataclass(frozen=True, eq=False)
class _Motion:
    """u, v, a of m modes of unit mass, rows (3, n, m), omega, xi (m,), and J loads with a factor each (m, J)."""

    rows: Array
    omega: Array
    xi: Array
    loads: Sequence[Load]
    factors: Array


@called_as('own_energy(march(scene, "bathe", dt=0.1, t_end=10.0))')
def own_energy(response: Response, modes: int | None = None) -> OwnEnergy:
    """The account of energy of a linear oscillator, or by modes of a linear structure, after a march of constant steps.

    A scheme's own energy is the quadratic form of its state that a free undamped step multiplies by one number, the
    product of its principal pair of eigenvalues: see `substep_derive.oscillator.energy`, after Hughes, The Finite
    Element Method (1987), 9.4, and Erlicher, Bonaventura & Bursi, Comput. Mech. 28 (2002). What that number takes is
    the scheme's dissipation; the work of loads and damping has closed forms as well. modes: how many of a structure's,
    from the lowest on, all by default.

    Rows of a start by another scheme, or with an acceleration that does not fit the equation of motion, are left out.
    On a nonlinear scene without a load the account is that of the modified energy: see `energy_drift`, which raises
    what is raised there. Raises ValueError for chosen steps, for rows of some steps only, and
    for a structure that is not linear or not held, whose damping couples modes, or of which not all degrees of freedom
    were kept; DeclarationError for a scheme with two or more spurious eigenvalues, and for a step at which the
    principal pair is real.

    >>> own = ss.own_energy(ss.march(ss.scene("linear_oscillator", omega=2.0), "bathe", dt=0.2, t_end=10.0))
    >>> print(f"{own.numerical[-1] / own.energy[0]:.3%}")
    0.861%
    """
    from ..derived import facade  # noqa: PLC0415 (SymPy, and all facts)

    if response.statistics is not None or response.times is not None:
        raise ValueError(
            "expected a run of constant steps, for the scheme's own energy; march with dt= and without at="
        )
    if not isinstance(response, StructureResponse) and not response.scene.info.oscillator:
        return _of_nonlinear(response)
    s, h = response.scheme, response.step
    energy, parameters = facade.derived(s.info.source).energy, {name: float(x) for name, x in s.parameters.items()}
    if not energy.reported:
        raise ValueError(
            f"expected a scheme whose runs report its state, for its own energy, got {s.name}, which keeps an "
            "auxiliary state, or another velocity than that of the end of a step; take another scheme"
        )
    motion = _of_structure(response, modes) if isinstance(response, StructureResponse) else _of_scene(response)
    x, begin = _states(energy.state, motion.rows, h)
    dropped = "h^2*a" not in energy.state and any(kind == KINDS["h^2*a"] for kind, _ in s.history)
    if energy.starts_otherwise or (dropped and np.abs(response.jump).max() > SMALL * np.abs(response.a[0]).max()):
        begin = max(begin, 1)
    x = x[begin:]
    numbers = [energy.in_numbers(omega * h, xi, parameters) for omega, xi in zip(motion.omega, motion.xi, strict=True)]
    instants = response.t[begin:-1, None] + h * np.array(numbers[0].stencil)
    loads = np.array([values_at(g, instants) for g in motion.loads]).reshape(len(motion.loads), *instants.shape)
    own, work, damped, numerical = np.zeros(len(x)), *np.zeros((3, len(x)))
    for k, of in enumerate(numbers):
        now, after, load = x[:-1, :, k], x[1:, :, k], h**2 * np.tensordot(motion.factors[k], loads, 1)
        both = 0.5 / h**2 * (after + now @ np.transpose(of.A))
        of_mode = 0.5 / h**2 * _products(x[:, :, k], x[:, :, k] @ np.array(of.P))
        own += of_mode
        work[1:] += _products(both, load @ np.transpose(of.work))
        damped[1:] += _products(both, now @ np.transpose(of.damped) + load @ np.transpose(of.damped_load))
        numerical[1:] += of.loss * of_mode[:-1]
    account = OwnEnergy(response.t[begin:], own, *(np.cumsum(sums) for sums in (work, damped, numerical)))
    if not np.abs(account.left).max() <= CLOSED * max(own.max(), *(np.abs(x).max() for x in (work, damped, numerical))):
        raise ValueError(
            "expected rows that one step takes to the next, for the scheme's own energy, got others; march without "
            "stride="
        )
    return account


def _of_nonlinear(r: Response) -> OwnEnergy:
    if len(r.newton_iterations) != len(r.t) - 1:
        raise ValueError(
            f"expected rows of all {len(r.newton_iterations)} steps, for the scheme's own energy, got "
            f"{len(r.t) - 1} after the start; march without stride="
        )
    found, states = ModifiedEnergy.of(r.scene, r.scheme), np.concatenate([r.u, r.v], axis=1).T
    kept, rates, nothing = found.kept(states), found.rates(states), np.zeros(len(r.t))
    energy = r.energy + sum((r.step**power * x for power, x in kept.items()), nothing)
    rate = sum((r.step**power * x for power, x in rates.items()), nothing)
    lost = np.concatenate([[0.0], np.cumsum(-np.diff(r.t) * (rate[1:] + rate[:-1]) / 2)])
    return OwnEnergy(r.t, energy, nothing, nothing, lost)


def _products(x: Array, y: Array) -> Array:
    """Inner products (n,) of rows (n, m)."""
    return np.einsum("nm,nm->n", x, y)


def _of_scene(r: Response) -> _Motion:
    assert r.scene.info.oscillator
    omega, xi, mass = r.scene.info.oscillator(*r.scene.parameters.values())
    loads = [] if r.scene.load is None else [r.scene.load]
    rows = mass**0.5 * np.array([r.u, r.v, r.a])
    return _Motion(rows, np.array([omega]), np.array([xi]), loads, np.full((1, len(loads)), mass**-0.5))


def _of_structure(r: StructureResponse, modes: int | None) -> _Motion:
    structure = r.structure
    if not isinstance(structure, Structure) or structure.internal is not None or structure.contacts is not None:
        raise ValueError(
            "expected a linear structure for the scheme's own energy, got an internal force, springs or contacts; "
            "march with account=True for an account by quadrature"
        )
    basis = structure.modes(structure.size if modes is None else modes)
    if basis.rigid:
        raise ValueError("expected a structure that is held, for the scheme's own energy, got rigid modes; give fixed=")
    coupling = np.abs(basis.damping - np.diag(np.diag(basis.damping)))
    if coupling.max(initial=0.0) > SMALL * np.abs(basis.damping).max(initial=0.0):
        raise ValueError(
            "expected damping that does not couple the modes, for the scheme's own energy, got a C that does; take "
            "Rayleigh's or modal damping, or march with account=True for an account by quadrature"
        )
    places = [structure.place(dof) for dof in r.dofs]
    if missing := set(range(structure.T.shape[0])) - set(places):
        raise ValueError(
            f"expected all degrees of freedom, for the scheme's own energy, got none of {min(missing)}; march without "
            "dofs"
        )
    by_mode = (structure.full_mass @ basis.shapes)[places]
    rows = np.array([np.asarray(x) @ by_mode for x in (r.u, r.v, r.a)])
    return _Motion(rows, basis.omega, np.diag(basis.damping) / (2 * basis.omega), r.loads, basis.load_factors)


def _states(labels: Sequence[str], rows: Array, h: float) -> tuple[Array, int]:
    """The states (n, len(labels), m) at all rows, and the first of them of which all parts are rows."""
    found, begin = [], 0
    for label in labels:
        quantity, _, back = label.partition("[")
        lag, kind = -int(back.rstrip("]") or 0), KINDS[quantity]
        found.append(h**kind * np.roll(rows[kind], lag, axis=0))
        begin = max(begin, lag)
    return np.stack(found, axis=1), begin
