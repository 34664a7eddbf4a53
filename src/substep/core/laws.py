"""Laws with memory, the forces of springs and dampers; each is declared once, and tried when it is first used."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ..derived import modules
from .arrays import Array
from .entries import ParameterInfo, constant
from .errors import real_array, unknown_name
from .kernel_modules import called, loaded, printed

if TYPE_CHECKING:
    from ..derived.modules import LawDeclaration

LAWS: tuple[str, ...] = loaded("law_index").LAWS
TRIED, COMMITS, FINE = 200, 6, 60  # random springs on which a declaration is tried, commits of each, and bisections
ROUNDING = 1e-9


class Evaluated(NamedTuple):
    """Of springs (..., n) each: force, its slopes by e and its rate, energy stored; memory (..., n, k) to commit."""

    force: Array
    tangent: Array
    damping: Array
    memory: Array
    stored: Array


@dataclass(frozen=True, eq=False, repr=False)
class Law:
    """A law with its parameters, for one spring or for n; make one with `substep.law`."""

    name: str
    module: ModuleType
    parameters: Mapping[str, Any]  # numbers, or (n,)
    source: Any  # the name, or the declaration of a law of the user's own

    @property
    def memory(self) -> tuple[str, ...]:
        """Names of what it remembers; the energy that it has dissipated is the last, where it keeps account of it."""
        return self.module.MEMORY

    @property
    def of_rate(self) -> bool:
        """Whether the force depends on the rate of the elongation."""
        return self.module.OF_RATE

    def unstrained(self, n: int = 1) -> Array:
        """What n springs remember (n, k) before they are strained."""
        found = np.empty((n, len(self.memory)))
        for k, x in enumerate(self.module.unstrained(**printed(self.parameters))):
            found[:, k] = x
        return found

    def evaluate(
        self, e: ArrayLike, e_dot: ArrayLike = 0.0, memory: Array | None = None, elapsed: float = 0.0
    ) -> Evaluated:
        """The force at elongations e (..., n), m, of rates e_dot, m/s, from what was committed elapsed s before.

        memory (..., n, k): by default that before they are strained. The path from there to e is monotonic.

        Raises ValueError for a memory of another shape. Of what is not finite, as in a run that overflows, the force is
        not either.
        """
        e = np.atleast_1d(np.ascontiguousarray(e, dtype=float))
        given = self.unstrained(e.size) if memory is None else np.asarray(memory, dtype=float)
        if memory is not None and given.shape != (*e.shape, len(self.memory)):
            raise ValueError(
                f"expected the memory of {self.name} with the shape {(*e.shape, len(self.memory))}, of each spring "
                f"{', '.join(self.memory) or 'nothing'}, got {given.shape}; give that of an earlier `evaluate`, .memory"
            )
        kept = by_name(given)
        force, tangent, damping, stored, rates = (np.empty(e.shape) for _ in range(5))
        rates[...] = e_dot
        new, since = np.empty((len(kept), *e.shape)), np.array([elapsed], dtype=float)
        table = by_name(self.table(e.shape))
        called(self.module.evaluate)(e.size, table, e, rates, kept, since, force, tangent, damping, new, stored)
        return Evaluated(force, tangent, damping, np.moveaxis(new, 0, -1), stored)

    def table(self, shape: tuple[int, ...]) -> Array:
        """The parameters (..., n, p) of springs."""
        found = np.empty((*shape, len(self.parameters)))
        for k, x in enumerate(self.parameters.values()):
            found[..., k] = x
        return found

    def loop(self, e: ArrayLike) -> tuple[Array, Array]:
        """Force (m,) and memory (m, k) of one spring, committed at each of the elongations (m,): a loop to draw.

        Raises ValueError for a law of the rate or of the time, of which elongations alone say nothing, and for other
        shapes and numbers that are not finite.
        """
        path = np.atleast_1d(real_array("e", e))
        if path.ndim != 1 or any(np.ndim(x) for x in self.parameters.values()):
            raise ValueError(
                f"expected a row of elongations of one spring, got shape {path.shape}, and parameters of "
                f"{max(map(np.size, self.parameters.values()), default=1)}; give one after the other"
            )
        strained = self.evaluate([1.0])
        later = self.evaluate([1.0], memory=strained.memory, elapsed=1.0).force
        if self.of_rate or later[0] != self.evaluate([1.0], memory=strained.memory).force[0]:
            raise ValueError(
                f"expected a law of the elongation alone for a loop, got {self.name}, whose force depends on the rate "
                "or the time; march a hysteretic_oscillator with it, and draw r.force over r.u"
            )
        memory, forces, kept = self.unstrained(), list[float](), list[Array]()
        for x in path:
            found = self.evaluate([x], memory=memory)
            memory = found.memory
            forces.append(float(found.force[0]))
            kept.append(memory[0])
        return np.array(forces), np.array(kept)

    def __reduce__(self) -> tuple[Any, ...]:
        return _remade, (self.source, dict(self.parameters))

    def __repr__(self) -> str:
        return f"Law({', '.join([self.name, *(f'{name}={x}' for name, x in self.parameters.items())])})"


def by_name(rows: Array) -> Array:
    """Parameters or memory (..., n, k) of springs as a law's kernel takes them: (k, ..., n)."""
    return np.ascontiguousarray(np.moveaxis(rows, -1, 0))


def laws() -> tuple[str, ...]:
    """Names of all laws.

    >>> "bouc_wen" in ss.laws()
    True
    """
    return LAWS


def law(name: str | Law | LawDeclaration, **parameters: ArrayLike) -> Law:
    """The law of that name, or of a declaration of your own (`substep_derive.Law`), with numbers or rows (n,) of them.

    Raises ValueError for unknown names, missing parameters, bad values, and for a declaration whose force jumps or
    whose update does not commit to itself.

    >>> steel = ss.law("bilinear", k=10.0, q_y=1.0, alpha=0.1)
    >>> steel.loop([0.05, 0.2, 0.1])[0].round(3)
    array([0.5, 1.1, 0.1])
    """
    if isinstance(name, Law):
        if parameters:
            raise ValueError(
                f"expected a name or a declaration with parameters, got {name} and {', '.join(parameters)}; write "
                f"law({name.name!r}, ...)"
            )
        return name
    if not isinstance(name, str) and not hasattr(name, "update"):
        raise ValueError(
            f"expected a law by name, {', '.join(LAWS)}, or a declaration by substep_derive.Law, got {name!r}; give one"
        )
    if isinstance(name, str):
        if name not in LAWS:
            raise unknown_name("a law", name, LAWS)
        label, module = name, loaded(f"laws.{name}")
    else:
        label, module = name.name, tried(name)
    infos = _parameters(module)
    if unknown := [key for key in parameters if key not in infos]:
        raise unknown_name(f"a parameter of {label}", unknown[0], list(infos))
    values: dict[str, Any] = {}
    for key, info in infos.items():
        what = f"parameter {key} of {label}"
        value = info.inside(
            what, real_array(what, parameters[key] if key in parameters else info.default_of(label, values))
        )
        if value.ndim > 1:
            raise ValueError(f"expected {what} as a number or a row of them, one a spring, got shape {value.shape}")
        values[key] = value.copy() if value.ndim else float(value)  # the caller's may change later
    return Law(label, module, MappingProxyType(values), name)


def _remade(source: Any, parameters: dict[str, Any]) -> Law:
    """A law from what a pickled one keeps."""
    return law(source, **parameters)


def _parameters(module: ModuleType) -> dict[str, ParameterInfo]:
    literals: list[tuple[Any, ...]] = module.PARAMETERS
    return {name: ParameterInfo(name, *domain, default=constant(default)) for name, *domain, default in literals}


@cache
def tried(declaration: LawDeclaration) -> ModuleType:
    """The module of a declared law, once it has been tried at random: on springs of random parameters and paths.

    Raises ValueError for a force that jumps in the elongation, and for an update that does not commit to itself.
    """
    module = modules.own_law_module(declaration)
    rng = np.random.default_rng(0)
    values = {name: _drawn(info, rng) for name, info in _parameters(module).items()}
    law = Law(declaration.name, module, values, declaration)
    memory, e, elapsed = law.unstrained(TRIED), np.zeros(TRIED), 0.0
    with np.errstate(all="ignore"):
        for _ in range(COMMITS):
            new = e + rng.normal(size=TRIED) * 10.0 ** rng.uniform(-2, 1, TRIED)
            _require_continuous(law, e, new, memory, elapsed)
            found = law.evaluate(new, 0.0, memory, elapsed)
            again = law.evaluate(new, 0.0, found.memory, 0.0)
            _require_same(law, "memory", found.memory, again.memory, new)
            _require_same(law, "force", found.force[:, None], again.force[:, None], new)
            memory, e, elapsed = found.memory, new, 0.01
    return module


def _drawn(info: ParameterInfo, rng: np.random.Generator) -> Array:
    """Random values of a parameter, inside its interval."""
    low, high = info.low, info.high
    if low is not None and high is not None:
        return low + (high - low) * rng.uniform(0.02, 0.98, TRIED)
    spread = 10.0 ** rng.uniform(-1, 1, TRIED)
    return spread if low is None and high is None else low + spread if low is not None else (high or 0.0) - spread


def _require_same(law: Law, what: str, one: Array, again: Array, e: Array) -> None:
    scale = np.abs(one) + np.abs(e)[:, None] + 1e-300
    worst = np.abs(again - one) / scale
    if not (worst <= ROUNDING).all():
        i = int(np.nanargmax(worst.max(axis=1))) if np.isfinite(worst).any() else 0
        raise ValueError(
            f"{law.name}: expected an update that commits to itself: with the same e once more nothing changes, "
            f"got another {what} at e = {e[i]:.6g}: {one[i]} then {again[i]}; write the new memory as a function of e "
            "that is already there where e is"
        )


def _require_continuous(law: Law, e: Array, new: Array, memory: Array, elapsed: float) -> None:
    """Of each path the half in which the force changes more, many times: what is left of the change is a jump."""
    low, high = e.copy(), new.copy()
    before, after = (law.evaluate(x, 0.0, memory, elapsed).force for x in (low, high))
    scale = np.abs(before) + np.abs(after)
    for _ in range(FINE):
        middle = 0.5 * (low + high)
        at = law.evaluate(middle, 0.0, memory, elapsed).force
        scale = np.maximum(scale, np.abs(at))
        first = np.abs(at - before) > np.abs(after - at)
        low, before = np.where(first, low, middle), np.where(first, before, at)
        high, after = np.where(first, middle, high), np.where(first, at, after)
    jumps = ~(np.abs(after - before) <= 1e-6 * scale)
    if jumps.any():
        i = int(np.argmax(jumps))
        raise ValueError(
            f"{law.name}: expected a force that is continuous in the elongation, got a jump from {before[i]:.6g} to "
            f"{after[i]:.6g} at e = {low[i]:.6g}; close it by a stiff branch"
        )
