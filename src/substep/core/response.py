"""What a march returns."""

import math
import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .arrays import Array
from .exports import Histories, History, to_dataset, to_frame
from .fighting import Acting, ending, known, of_scene, reacts_until, reason
from .impacts import Impact, Touching, impacts, require_each_step
from .loads import Load
from .outcome import Happening, Statistics, Status
from .powers import numerical, power_of_each, powers
from .state import State
from .unkept import unkept

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from pandas import DataFrame

    from .result_dataset import ResultDataset
    from .scenes import Scene
    from .schemes import Scheme


@dataclass(frozen=True, eq=False, repr=False)
class Response:
    """Histories u, v (n+1, ndof), and t, energy, angular_momentum (n+1,), which are computed when first read.

    status: "completed", or why the march stopped; then all arrays end at the last good state and
    t_failed is the end of the step that failed. newton_iterations (n, balances): 0 where a balance is
    linear; where another scheme marches the first steps, the sum over its balances counts as the first balance's.
    a (n+1, ndof) is the scheme's own acceleration, else M^-1 (F - C v - N). angular_momentum is None for a
    scene without one; outputs holds the scene's own, such as strain.

    Where the march chose its steps: statistics says what they cost (None for a constant step), t is what is stored, and
    newton_iterations has a row for each accepted step, none where rows were asked for on a grid.
    """

    u: Array
    v: Array
    newton_iterations: NDArray[np.int64]
    status: Status
    t_failed: float | None
    scene: "Scene"
    scheme: "Scheme"
    step: float  # s between two rows; NaN where steps are uneven
    own_a: Array | None
    times: Array | None = None  # s, where they are not multiples of the step
    statistics: Statistics | None = None
    started: State | None = None  # where the march went on from
    last: Callable[[], State] | None = None  # where it stands, as far as the march knows it
    memories: Array | None = None  # (n+1, k) what the laws of the scene remember
    t_events: Array | None = None  # s, where the march was to end at an event: of each the time, NaN without one
    before: tuple[float, Array] | None = None  # where its first step began, if before the first row: t, s; u, v, a
    happenings: tuple[Happening, ...] = ()  # of contacts and frictions, where steps were chosen, in the order of time
    growth: float = math.inf  # the largest energy of a step over that of the start is at most this

    @cached_property
    def state(self) -> State:
        """Where the run stands: what `march(start=)` goes on from, for this scheme or another, this load or another.

        After a failure it is the last row, without a history of the scheme. Raises ValueError where that row does not
        hold all degrees of freedom.
        """
        if self.last is not None:
            return self.last()
        u, v, a = self._last_row
        memory = {name: x[-1] if x.ndim > 1 else float(x[-1]) for name, x in self.memory.items()}
        return State(float(self.t[-1]), u, v, a, memory=memory)

    @cached_property
    def failure(self) -> str:
        """Why the march has no step to t_failed: which constraints, contacts, frictions or masses, and the cure.

        "" where it is completed, or stopped for another reason. It is looked for at the last row, and where the step
        leads from there: see `substep.core.unkept` and `substep.core.fighting`.
        """
        if self.status not in ("newton_failed", "step_too_small", "non_finite") or self.t_failed is None:
            return ""
        why, blown_up = "", self.status == "non_finite"
        with suppress(np.linalg.LinAlgError):  # of a last row that is beyond all bounds
            acting = self.acting(-1, self.t_failed)
            why = self._unkept() or (acting and (known if blown_up else reason)(acting)) or self._ending()
        default = {"newton_failed": "take a smaller step", "step_too_small": "allow a smaller step, or a larger tol"}
        why = why or (not blown_up and self._jumping()) or default.get(self.status, "")
        return why and f"the step to t = {self.t_failed:.6g} s was not solved: {why}"

    def acting(self, row: int, end: float) -> Acting | None:
        """The contacts and frictions in a step from a row to the time `end`, s; None without any."""
        return of_scene(self, row, end)

    def _unkept(self) -> str:
        """Which constraints are not kept from the last row on, in words."""
        assert self.t_failed is not None
        return unkept(self, reacts_until(self.scheme, float(self.t[-1]), self.t_failed))

    def _jumping(self) -> str:
        """Which force of a scene jumps, in words, so that no step need have a solution."""
        if not self.scene.info.jumps:
            return ""
        (coordinate, sign), *_ = self.scene.info.jumps
        return (
            f"the force on '{coordinate}' jumps with {sign}, so that a step that ends where it does has no solution; "
            "declare what rubs by frictions= and what stops by contacts=, or smooth it, as by tanh in place of sign"
        )

    def _ending(self) -> str:
        """Which mass is about to be singular, in words."""
        return ending(self, blown_up=self.status == "non_finite")

    @cached_property
    def jump(self) -> Array:
        """How far a (d,) in the first row is from the one of the equation of motion there: 0 for a consistent start.

        A scheme that carries a feels it in its first steps. `State.consistent` starts without it.
        """
        t, u, v = self.t[:1], np.asarray(self.u)[:1], np.asarray(self.v)[:1]
        return (np.asarray(self.a)[:1] - self.scene.acceleration(t, u, v, *self.memory_of_rows(slice(1))))[0]

    @property
    def memory(self) -> Mapping[str, Array]:
        """What the laws of the scene remember, each (n+1,), by name; empty where they remember nothing.

        Of each constraint it is the multiplier with which the last balance of a step was solved: see `multipliers`;
        of each contact the pressure.
        """
        rows = self.memories
        return {} if rows is None else {name: rows[:, k] for k, name in enumerate(self.scene.info.memory)}

    @property
    def multipliers(self) -> Mapping[str, Array]:
        """The multiplier (n+1,) of each constraint of the scene, by name, from the equations of motion at u, v and t.

        It is as accurate as u and v, also where the scheme's own one, in `memory`, is of lower order. Empty where there
        are no constraints.
        """
        if not (names := self.scene.info.multipliers):
            return {}
        found = self.scene.multipliers(self.t, self.u, self.v, *self.memory_of_rows(slice(None)))
        return {name: found[:, k] for k, name in enumerate(names)}

    @property
    def gaps(self) -> Mapping[str, Array]:
        """The gap (n+1,) of each contact of the scene, by name; 0 in contact. Empty without contacts."""
        if not (names := self.scene.info.contacts):
            return {}
        found = self.scene.gaps(self.t, self.u)
        return {name: found[:, k] for k, name in enumerate(names)}

    @cached_property
    def impacts(self) -> tuple[Impact, ...]:
        """The impacts of all contacts in the order of time, from the rows; empty without contacts.

        Of each the step in which it begins, the impulse until the contact opens, the rates of the gap before and after,
        and the energy lost: see `substep.core.impacts`. `print(*r.impacts, sep="\\n")` has one a line. Raises
        ValueError for a response that has no row for each step.
        """
        if (found := self._contacts_in_rows()) is None:
            return ()
        require_each_step(self)
        return impacts(self, found)

    def _contacts_in_rows(self) -> Touching | None:
        """The contacts in the rows; None without any."""
        names, c = self.scene.info.contacts, len(self.scene.info.multipliers)
        if not names:
            return None
        these = slice(c, c + len(names))
        x, rates, _ = self.scene.drift(self.t, self.u, self.v)
        along = np.abs(self.scene.directions(self.t, self.u)[:, these])
        of_u, of_v = (np.einsum("ndk,nk->nd", along, np.abs(y)) for y in (self.u, self.v))
        pressures = np.column_stack([self.memory[name] for name in names])
        of = tuple((name, None) for name in names)
        kept = not self.scene.info.impulsive or self.scheme.kind == "explicit"  # see `Contact`
        return Touching(of, pressures, -x[:, these], -rates[:, these], of_u, of_v, -self.energy, kept)

    @property
    def energy_dissipated(self) -> Array:
        """The energy (n+1,), J, that the laws of the scene have dissipated, exactly along the path that they took.

        Raises AttributeError for a scene without such laws.
        """
        if "dissipated" not in self.memory:
            raise AttributeError(
                "expected a scene whose laws dissipate energy, such as hysteretic_oscillator; this one has none"
            )
        return self.memory["dissipated"]

    @cached_property
    def powers(self) -> Mapping[str, Array]:
        """The power (n+1,), W, of what gives energy to the scene or takes it, by name: only of what is there.

        dissipation, forces and load as they are declared; time, of energies that hold it; constraints, by their
        multipliers, which is 0 but for the scheme's error unless they move; friction, by the forces that steps compute.
        `power_of_each` has their parts.
        """
        return powers(self)

    @cached_property
    def power_of_each(self) -> Mapping[str, Array]:
        """The power (n+1,), W, of each force that `powers` adds up, by the name there and what it is declared for.

        `forces x` and `load x` on the coordinate x, `constraints rod` of the constraint rod, `friction pad` of the
        friction pad; dissipation and time have no parts. All of them together are the sum of `powers`.
        """
        return power_of_each(self)

    @cached_property
    def numerical(self) -> Array:
        """The energy (n+1,), J, that the scheme itself has dissipated so far: what no power and no law accounts for.

        The powers are added up by Simpson's rule over the rows, whose error is in it too. Raises ValueError for a scene
        with contacts, whose reactions act within a step: `impacts` says what each of them takes.
        """
        return numerical(self)

    def memory_of_rows(self, rows: slice) -> tuple[Array, ...]:
        """Some rows of what laws remember, as a last argument of the scene's functions; nothing where there is none."""
        return () if self.memories is None else (self.memories[rows],)

    @property
    def loads(self) -> Sequence[Load | None]:
        """The loads, as functions of time."""
        return (self.scene.load,)

    @property
    def has_a(self) -> bool:
        """Whether `a` is known."""
        return True

    def at_times(self, times: Array, u: Array) -> dict[str, Any]:
        """What else there is of each row, by the names of fields, at other times, where the displacement is u.

        Of laws what they would remember if it were committed then, on a straight path from the row before.
        """
        if self.memories is None:
            return {}
        k = np.clip(np.searchsorted(self.t, times, side="right") - 1, 0, len(self.t) - 1)
        return {"memories": self.scene.committed(u, self.memories[k], times - self.t[k])}

    @property
    def _last_row(self) -> tuple[Array, Array, Array | None]:
        """u, v, a (d,) in the last row; None for an a that is not known."""
        return np.array(self.u[-1]), np.array(self.v[-1]), np.array(self.a[-1])

    @cached_property
    def t(self) -> Array:
        """Times (n+1,), s."""
        return self.step * np.arange(float(self.u.shape[0])) if self.times is None else self.times

    @cached_property
    def a(self) -> Array:
        """Acceleration (n+1, ndof)."""
        if self.own_a is not None:
            return self.own_a
        first = self.scene.a0 if self.started is None or self.started.a is None else self.started.a
        of_rows = self.scene.acceleration(self.t, self.u, self.v, *self.memory_of_rows(slice(None)))
        return np.concatenate([first[None], of_rows[1:]])

    @cached_property
    def energy(self) -> Array:
        """Kinetic energy and potential (n+1,), J."""
        return self.scene.energy(self.t, self.u, self.v, *self.memory_of_rows(slice(None)))

    @cached_property
    def momenta(self) -> Mapping[str, Array]:
        """Noether's momenta (n+1,), of each rigid motion of the coordinates that energies and reactions do not resist.

        By what is moved: `x` or `x_1 + x_2` of lengths in kg m/s, `phi` of an angle and `x y` of a rotation of that
        plane in kg m^2/s. They are constant on motions without other forces. Empty for a scene without one.
        """
        return self.scene.momenta(self.t, self.u, self.v)

    @property
    def angular_momentum(self) -> Array | None:
        """Angular momentum (n+1,), kg m^2/s: the first of `momenta` of a turn; None for a scene without one."""
        turned = self.scene.info.turned
        return None if turned is None else self.momenta[turned]

    @cached_property
    def outputs(self) -> Mapping[str, Array]:
        """The scene's named outputs, each (n+1,)."""
        return self.scene.outputs(self.t, self.u, self.v, *self.memory_of_rows(slice(None)))

    @property
    def force(self) -> Array:
        """The force (n+1,) of the scene's law with a memory. Raises AttributeError for a scene without one."""
        if "force" not in self.outputs:
            raise AttributeError("expected a scene with one law, such as hysteretic_oscillator; this one has none")
        return self.outputs["force"]

    @property
    def strain(self) -> Array:
        """Axial strain (n+1,). Raises AttributeError for a scene without one."""
        if "strain" not in self.outputs:
            raise AttributeError("expected a scene with a strain, such as elastic_pendulum; this one has none")
        return self.outputs["strain"]

    def _histories(self) -> Histories:
        """What can be exported."""
        units = [unit for _, unit in self.scene.coordinates]
        unit = units[0] if len(set(units)) == 1 else "of the coordinate"
        found = {
            "u": History(self.u, unit, "displacement"),
            "v": History(self.v, f"{unit}/s", "velocity"),
            "a": History(self.a, f"{unit}/s^2", "acceleration"),
            "energy": History(self.energy, "J", "kinetic energy and potential"),
        }
        for name, unit in self.scene.info.momenta:
            turned = name == self.scene.info.turned
            known = "angular_momentum" if turned else re.sub(r"\W+", "_", f"momentum_{name}")
            found[known] = History(self.momenta[name], unit, f"{'angular ' * turned}momentum of {name}")
        found |= {name: History(x, "", name) for name, x in (*self.outputs.items(), *self.memory.items())}
        if self.scene.info.multipliers:
            of_motion = "multiplier of a constraint, from the equations of motion"
            found |= {f"{name}_multiplier": History(x, "", of_motion) for name, x in self.multipliers.items()}
        attrs = self._attrs | {"scene": self.scene.name}
        attrs |= {f"scene_{name}": x for name, x in self.scene.parameters.items()}
        return Histories(self.t, found, [name for name, _ in self.scene.coordinates], "coordinate", attrs)

    @property
    def _subject(self) -> str:
        """What was marched, in a few words."""
        return self.scene.name

    @property
    def _pace(self) -> str:
        """How many rows a period of the oscillator has, by which a step in ms or an omega in Hz shows; else nothing."""
        period = getattr(self.scene, "period", None)
        return "" if period is None or self.step != self.step else f"{period / self.step:.3g} rows a period, "

    @property
    def _attrs(self) -> dict[str, Any]:
        parameters = {f"scheme_{name}": float(x) for name, x in self.scheme.parameters.items()}
        failed = {} if self.t_failed is None else {"t_failed": self.t_failed}
        return {"scheme": self.scheme.name, **parameters, "status": self.status, **failed}

    def to_xarray(self) -> "ResultDataset":
        """u, v, a over t and coordinate, energy and the scene's own outputs over t; with units and settings."""
        return to_dataset(self._histories())

    def save(self, path: str | Path) -> None:
        """Write `to_xarray` and, where it is known, `state` to a netCDF file, which `substep.load` reads.

        What that gives goes on by `march(start=)`. Raises OSError where the file cannot be written.
        """
        found = self.to_xarray()
        with suppress(ValueError):  # of a last row without all degrees of freedom
            found.state = self.state
        found.save(path)

    def to_pandas(self) -> "DataFrame":
        """The same with a row for each time and a column for each history, such as "u x".

        Raises ImportError where pandas is not installed.
        """
        return to_frame(self._histories())

    def plot(self, *quantities: str, axes: "Axes | Sequence[Axes] | None" = None) -> "Figure":
        """The figure of quantities over t, u alone by default: u, v, a, energy or another of `to_xarray`, a panel each.

        axes: Matplotlib's, one for each quantity, to draw into in place of a new figure. Raises ValueError for an
        unknown quantity and for another number of axes.
        """
        from .history_figure import to_figure  # noqa: PLC0415 (loads Matplotlib)

        given = ", ".join(f"{name} = {float(x):.4g}" for name, x in self.scheme.given.items())
        scheme = f"{self.scheme.name} at {given}" if given else self.scheme.name
        end = "" if self.status == "completed" else f", {self.status}"
        return to_figure(self._histories(), quantities or ("u",), axes, f"{scheme} on {self._subject}{end}")

    @property
    def _jumped(self) -> str:
        """How far the start is from the equation of motion, in words, if that is more than rounding."""
        jump = float(np.abs(self.jump).max())
        return f", a starts {jump:.3g} from the equation of motion" if jump > 1e-6 * float(np.abs(self.a).max()) else ""

    def __repr__(self) -> str:
        why = f"; {self.failure}" if self.failure else ""
        end = f"{len(self.t)} rows to t = {self.t[-1]:.6g} s, {self._pace}{self.status}{self._jumped}{why}"
        return f"{type(self).__name__}({self.scheme} on {self.scene}, {end})"
