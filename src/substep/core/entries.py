"""What the index says about a scheme or a scene, with names and types: only this module reads an entry's literals.

The committed index (`substep_kernels.index`, `substep_kernels.scene_index`) and the `ENTRY` of a module in the user's
cache hold the same plain literals. `SchemeInfo.of` and `SceneInfo.of` turn one of them into what the rest of the
package reads.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, Literal

from numpy.typing import ArrayLike

from .arrays import Array
from .errors import inside
from .roots import only_root

if TYPE_CHECKING:
    from ..derived.modules import Declaration, SceneDeclaration

Start = Literal["given", "function", "scheme"]


@dataclass(frozen=True)
class ParameterInfo:
    """A parameter's interval (None for no bound) and its default, a function of the parameters declared before it.

    An implicit default is the one root in the interval of a polynomial, whose coefficients, from the lowest power, are
    a function of those parameters. default and polynomial are None for a parameter that has to be given.
    """

    name: str
    low: float | None
    high: float | None
    low_open: bool
    high_open: bool
    default: Callable[..., Any] | None
    polynomial: Callable[..., Sequence[Any]] | None = None

    def default_of(self, owner: str, earlier: Mapping[str, Any]) -> Any:
        """The default, from the values of the parameters before it.

        Raises ValueError for a parameter that has to be given, or whose polynomial has no or more than one root.
        """
        if self.polynomial is not None:
            interval = self.low, self.high, self.low_open, self.high_open
            return only_root(f"{self.name} of {owner}", self.polynomial(*earlier.values()), *interval)
        if self.default is None:
            raise ValueError(f"expected a value for {self.name} of {owner}, got none; add {self.name}=...")
        return self.default(*earlier.values())

    def inside(self, what: str, value: ArrayLike) -> Array:
        """The value as an array, else a ValueError that calls it `what`: it has to be finite and in the interval."""
        return inside(what, value, self.low, self.high, self.low_open, self.high_open)


@dataclass(frozen=True)
class FamilyInfo:
    """Another name for a set of parameters: its argument, such as rho_inf, and each parameter as a function of it."""

    argument: ParameterInfo
    values: Mapping[str, Callable[[Array], Any]]


@dataclass(frozen=True)
class SchemeInfo:
    """What there is to know about a scheme before its kernels are loaded. Equal for the same scheme.

    module: the generated module, or its name in the catalogue, which a member of a family shares with its parent.
    fixed: the parameters that a member fixes. balances: how many a step has. loads: at how many instants a step takes
    the load. state: what is carried from step to step. history, of each entry of the state: 0 for u, 1 for h*v, 2 for
    h^2*a, and how many steps before t_n it stands. start, where the state at t = 0 comes from: "given", u, h*v, h^2*a
    are the state; "function", the module's `start` computes it; "scheme", another scheme marches the first steps.
    starter: with "scheme" only, that scheme's name in the catalogue and its parameters; an empty name stands for the
    declaration's `start_scheme`. damping: whether it takes any; one that does not is for u'' = g(t, u). together:
    whether balances are solved together. decided: parameters that another one
    decides where it is given, and how. declaration: of a scheme of the user's own.
    """

    name: str
    module: str | ModuleType
    parameters: Mapping[str, ParameterInfo] = field(compare=False)
    families: Mapping[str, FamilyInfo] = field(compare=False)
    fixed: Mapping[str, float] = field(compare=False)
    decided: Mapping[str, tuple[str, Callable[[Array], Any]]] = field(compare=False)
    balances: int = field(compare=False)
    loads: int = field(compare=False)
    state: tuple[str, ...] = field(compare=False)
    history: tuple[tuple[int, int], ...] = field(compare=False)
    reference: str = field(compare=False)
    declaration: "Declaration | None" = field(compare=False)
    start: Start = field(default="given", compare=False)
    starter: tuple[str, Mapping[str, float]] | None = field(default=None, compare=False)
    damping: bool = field(default=True, compare=False)
    together: bool = field(default=False, compare=False)

    @classmethod
    def of(
        cls,
        name: str,
        entry: Mapping[str, Any],
        module: ModuleType | None = None,
        declaration: "Declaration | None" = None,
    ) -> "SchemeInfo":
        """From an entry of the index; module and declaration are those of a scheme of the user's own."""
        families = {
            argument: FamilyInfo(ParameterInfo(argument, *domain, default=None), MappingProxyType(values))
            for argument, (*domain, values) in entry.get("families", {}).items()
        }
        changed: dict[str, Any] = {
            "name": name,
            "module": module or entry["module"],
            "parameters": _by_name(ParameterInfo(*literal) for literal in entry["parameters"]),
            "families": MappingProxyType(families),
            "fixed": MappingProxyType(entry.get("fixed", {})),
            "decided": MappingProxyType(entry.get("decided", {})),
            "declaration": declaration,
        }
        return cls(**{key: x for key, x in entry.items() if key != "synonyms"} | changed)

    @property
    def source(self) -> "str | Declaration":
        """What `substep.scheme` makes it from: a name of the catalogue, or the user's declaration."""
        return self.name if self.declaration is None else self.declaration


@dataclass(frozen=True)
class SceneInfo:
    """What there is to know about a scene before its functions are loaded. Equal for the same scene.

    module: the generated module, or its name, where it is committed or printed on first use. coordinates: (name, unit)
    of each. Functions of the parameters: start gives u, v and a at t = 0, None in place of a where it follows from the
    equation of motion; length is what Newton's tolerance is relative to; energy_scale, J, of a scene that starts
    without energy; oscillator gives circular frequency, damping ratio and mass of a linear oscillator, and is None for
    any other scene. outputs: names of further results. momenta: (name, unit) of Noether's. sampled: whether the user
    gives the load. damped: whether its velocity causes a force; conserves: whether that does no work, being one of
    inertia. memory: names of what its laws remember; unstrained: a function of the parameters, its values before
    anything is strained; multipliers: names of those of its constraints; contacts: names of its contacts, whose
    pressures follow in memory; frictions: names of those, which are the last. impulsive: whether steps remember none of
    these reactions; held_gaps: names of the contacts without a restitution, of which the gap is held. jumps: names of
    coordinates whose force jumps, each with the sign by which it does. declaration: of a scene of the user's own.
    """

    name: str
    module: str | ModuleType
    parameters: Mapping[str, ParameterInfo] = field(compare=False)
    coordinates: tuple[tuple[str, str], ...] = field(compare=False)
    start: Callable[..., tuple[Any, Any, Any]] = field(compare=False)
    length: Callable[..., Any] = field(compare=False)
    memory: tuple[str, ...] = field(compare=False)
    reference: str = field(compare=False)
    declaration: "SceneDeclaration | None" = field(compare=False)
    energy_scale: Callable[..., Any] | None = field(default=None, compare=False)
    oscillator: Callable[..., tuple[Any, Any, Any]] | None = field(default=None, compare=False)
    outputs: tuple[str, ...] = field(default=(), compare=False)
    momenta: tuple[tuple[str, str], ...] = field(default=(), compare=False)
    sampled: bool = field(default=False, compare=False)
    damped: bool = field(default=False, compare=False)
    conserves: bool = field(default=False, compare=False)
    unstrained: Callable[..., tuple[Any, ...]] | None = field(default=None, compare=False)
    multipliers: tuple[str, ...] = field(default=(), compare=False)
    contacts: tuple[str, ...] = field(default=(), compare=False)
    frictions: tuple[str, ...] = field(default=(), compare=False)
    impulsive: bool = field(default=False, compare=False)
    held_gaps: tuple[str, ...] = field(default=(), compare=False)
    jumps: tuple[tuple[str, str], ...] = field(default=(), compare=False)

    @classmethod
    def of(
        cls,
        name: str,
        entry: Mapping[str, Any],
        module: ModuleType | None = None,
        declaration: "SceneDeclaration | None" = None,
    ) -> "SceneInfo":
        """From an entry of the index; module and declaration are those of a scene of the user's own."""
        literals, remembered = entry["parameters"], ("memory", "multipliers", "contacts", "frictions")
        changed: dict[str, Any] = {
            "name": name,
            "module": module or f"scenes.{name}",
            "parameters": _by_name(ParameterInfo(*own, default=constant(default)) for *own, default in literals),
            "memory": tuple(one for key in remembered for one in entry.get(key, ())),
            "declaration": declaration,
        }
        return cls(**{**entry, **changed})

    @property
    def laws(self) -> int:
        """How many numbers of the memory are those of laws; they come first."""
        return len(self.memory) - len(self.reactions)

    @property
    def reactions(self) -> tuple[str, ...]:
        """Names of all its reactions, in their order in memory."""
        return (*self.multipliers, *self.contacts, *self.frictions)

    @property
    def turned(self) -> str | None:
        """The name of the first of its momenta that is an angular momentum; None for a scene without one."""
        return next((name for name, unit in self.momenta if unit == "kg m^2/s"), None)

    @property
    def source(self) -> "str | SceneDeclaration":
        """What `substep.scene` makes it from: a name of the catalogue, or the user's declaration."""
        return self.name if self.declaration is None else self.declaration


def constant(default: float | None) -> Callable[..., float] | None:
    """A default that is a number as a function of the parameters before it; None for none."""
    return None if default is None else lambda *_: default


def _by_name(parameters: Any) -> Mapping[str, ParameterInfo]:
    return MappingProxyType({parameter.name: parameter for parameter in parameters})
