"""Handles of schemes: parameters checked once, stability functions that broadcast.

Metadata come from the emitted index; a scheme's compiled module (and with it numba) is imported on
first use.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from importlib import import_module
from importlib.util import find_spec
from math import prod
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from substep_kernels.index import SCHEMES

from .errors import float_array, inside, non_negative, unknown_name
from .threads import spread

if TYPE_CHECKING:
    from ..derived.modules import Declaration

Array = NDArray[np.float64]
PART = 1 << 13  # points at a time: numbers spread over so few cost no fresh pages, and what is written stays cached
NANOSECONDS = {"spectral_radius": 0.6, "stability": 4.0}  # of a point at the fastest schemes


def schemes() -> tuple[str, ...]:
    """Names of all schemes, members of families included."""
    return tuple(SCHEMES)


def scheme(name: "str | Declaration", **parameters: ArrayLike) -> "Scheme":
    """A handle of the scheme; parameters not given take the default of the declaration.

    name: of the catalogue, or a declaration of your own (`substep_derive.Scheme`), which is derived and
    compiled on first use and kept in the user's cache. A family's argument (`rho_inf` of
    generalized-alpha, ...) stands for the parameters it sets. Parameters may be arrays, and then
    broadcast with Omega and xi. Raises ValueError for an unknown scheme or parameter, for one that a
    family also sets, and for a value that is not finite or lies outside the declared interval.
    """
    name, entry = scheme_entry(name)
    declared = {parameter: rest for parameter, *rest in entry["parameters"]}
    families = entry["families"]
    given: dict[str, Array] = {}
    for key, value in parameters.items():
        if key in declared:
            mine = {key: _within(name, key, value, declared[key])}
        elif key in families:
            domain, values = families[key][:4], families[key][4]
            argument = _within(name, key, value, domain)
            mine = {set_by_it: np.asarray(function(argument)) for set_by_it, function in values.items()}
        else:
            raise unknown_name(f"a parameter of {name}", key, [*declared, *families])
        if twice := sorted(mine.keys() & given.keys()):
            raise ValueError(f"expected {twice[0]} of {name} once, got it by itself and through a family; drop one")
        given |= mine
    complete: dict[str, Array] = {}
    for key, (*domain, default) in declared.items():
        value = given[key] if key in given else default(*complete.values())
        complete[key] = _within(name, key, value, domain)
    return Scheme(name, MappingProxyType(complete), entry, MappingProxyType(given))


def scheme_entry(name: "str | Declaration") -> tuple[str, Mapping[str, Any]]:
    """A scheme's name and entry of the index. Raises ValueError for an unknown one."""
    if isinstance(name, str):
        if name not in SCHEMES:
            raise unknown_name("a scheme", name, SCHEMES)
        return name, SCHEMES[name]
    if not hasattr(name, "balances"):
        raise ValueError(f"expected the name of a scheme or a declaration of one, got {name!r}")
    from ..derived.modules import own_entry  # noqa: PLC0415 (the one door to SymPy)

    return own_entry(name)


def _within(scheme: str, key: str, value: ArrayLike, domain: Sequence[Any]) -> Array:
    array = inside(f"parameter {key} of {scheme}", value, *domain[:4]).copy()
    array.flags.writeable = False
    return array


@cache
def committed(name: str) -> ModuleType | None:
    """The generated module of that name; None for one that is printed on first use."""
    full = f"substep_kernels.{name}"
    return import_module(full) if find_spec(full) else None


@dataclass(frozen=True)
class Scheme:
    """A time integration scheme with its parameters; make one with `substep.scheme`.

    All stability functions take Omega = omega*h >= 0 and the damping ratio xi >= 0, which broadcast
    with each other and with the parameters.
    """

    name: str
    parameters: Mapping[str, Array]
    entry: Mapping[str, Any] = field(repr=False, compare=False)  # of the index, see substep_kernels.index
    given: Mapping[str, Array] = field(default_factory=dict, repr=False, compare=False)  # the others took their default

    @property
    def state(self) -> tuple[str, ...]:
        """What the scheme carries from step to step, in the order of the amplification matrix."""
        return self.entry["state"]

    @property
    def reference(self) -> str:
        """Where the scheme was published."""
        return self.entry["reference"]

    @property
    def balances(self) -> int:
        """How many balances (implicit solves or force evaluations) a step has."""
        return self.entry["balances"]

    @property
    def kernels(self) -> ModuleType:
        """The generated module, imported (and compiled or read from numba's cache) on first use."""
        module = self.entry["module"]
        found = module if isinstance(module, ModuleType) else committed(module)
        assert found is not None  # the index names what is committed
        return found

    def amplification(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """Amplification matrix, (..., m, m), of the undriven oscillator, in the order of `state`."""
        m = len(self.state)
        shape, arguments = self._points(Omega, xi)
        out = np.empty((arguments[0].size, m, m))
        self.kernels.amplification(*arguments, out)
        return out.reshape(*shape, m, m)

    def spectral_radius(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """Largest modulus of the eigenvalues of the amplification matrix (thesis (4.17))."""
        return self._evaluate("spectral_radius", 1, Omega, xi)[0]

    def stability(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> tuple[Array, Array, Array]:
        """Spectral radius, numerical damping and period error, as the functions of these names, in one pass."""
        radius, damping, period = self._evaluate("stability", 3, Omega, xi)
        return radius, damping, period

    def numerical_damping(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """-ln|lambda_1|/phi - xi/sqrt(1 - xi^2), the damping ratio the scheme adds (thesis (4.3)).

        lambda_1 is the complex pair of largest modulus, phi its argument. NaN where all eigenvalues
        are real or xi >= 1; 0, its limit, at Omega = 0.
        """
        return self.stability(Omega, xi)[1]

    def amplitude_error(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """1 - exp(-2 pi numerical_damping) (thesis (4.4)); NaN where that is."""
        with np.errstate(over="ignore"):  # -inf of a response that grows beyond all numbers
            return 0.0 - np.expm1(-2.0 * np.pi * self.numerical_damping(Omega, xi))

    def period_error(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> Array:
        """Omega*sqrt(1 - xi^2)/phi - 1 (thesis (4.6)); NaN where numerical_damping is, 0 at Omega = 0."""
        return self.stability(Omega, xi)[2]

    def power_norm(self, Omega: ArrayLike, xi: ArrayLike = 0.0, n: int = 1000) -> Array:
        """The largest of ||A||, ||A^2||, ..., ||A^n|| in the energy norm of (omega*u, v, a/omega), n >= 1.

        Bounded in n for a stable scheme; it grows with n where an eigenvalue on the circle is multiple.
        Raises ValueError for Omega = 0, where the energy does not see u.
        """
        if n < 1:
            raise ValueError(f"expected n >= 1 powers, got {n}")
        omega = non_negative("Omega", Omega)
        if (omega == 0).any():
            raise ValueError("expected Omega > 0, got 0, where the energy does not see u; give a positive Omega")
        A = self.amplification(omega, xi)
        scale = np.broadcast_to(omega[..., None], A.shape[:-1]) ** (1.0 - np.array([kind for kind, _ in self.history]))
        A = scale[..., :, None] * A / scale[..., None, :]
        power, largest = A, np.linalg.norm(A, 2, axis=(-2, -1))
        with np.errstate(over="ignore", invalid="ignore"):
            for _ in range(n - 1):
                power = power @ A
                if not np.isfinite(power).all():
                    return np.where(np.isfinite(power).all(axis=(-2, -1)), largest, np.inf)[()]
                largest = np.maximum(largest, np.linalg.norm(power, 2, axis=(-2, -1)))
        return largest[()]

    def stencil(self) -> Array:
        """Instants at which a step takes the load, in steps after t_n: (..., K), read-only."""
        return self._stencil

    @cached_property
    def _stencil(self) -> Array:
        shape, values = self._broadcast(*self._module_parameters)
        out = np.empty((prod(shape), self.entry["loads"]))
        self.kernels.stencil(*values, out)
        out.flags.writeable = False
        return out.reshape(*shape, -1)

    @cached_property
    def loaded_within(self) -> bool:
        """Whether a step takes the load between its ends alone; a parameter may move an instant beyond."""
        return bool(self._stencil.min() >= 0.0 and self._stencil.max() <= 1.0)

    def coefficients(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> tuple[Array, Array, Array, Array]:
        """D (n, m, m), B (n, m, K), O (n, R, m), P (n, R, K) of x1 = x0 + D x0 + B h^2 f and y1 = O x0 + P h^2 f.

        x are the `marched` entries of the state, f the loads at the stencil's instants. y are those of u, h*v, h^2*a
        that are not in x. If not all of the state is marched, a_n was eliminated by the balance at t_n, and at the
        start the load there stands for h^2 a + 2 xi Omega h v + Omega^2 u. D is rounded once.
        """
        _, (Omegas, xis, *values) = self._points(Omega, xi)
        rows, (m, R, K), loads = self._coefficients(Omegas, xis, values), self.sizes, self.entry["loads"]
        D, B, y_x, y_f = np.split(rows.T, np.cumsum([m * m, m * K, R * m]), axis=1)
        B, y_f = B.reshape(-1, m, K)[..., :loads], y_f.reshape(len(D), R, K)[..., :loads]
        return D.reshape(-1, m, m), B, y_x.reshape(len(D), R, m), y_f

    @property
    def marched(self) -> tuple[int, ...]:
        """Which entries of the state the linear march carries."""
        return self.kernels.KEPT

    @property
    def places(self) -> tuple[str, ...]:
        """Where u, h*v and h^2*a stand in what is marched, a number each; y for an output of its own."""
        places = self.kernels.MARCH.split("_")[3:]  # as of linear_march_2_01y or linear_march_12_0_11_y
        return tuple(places if len(places) == 3 else places[0])

    @cached_property
    def sizes(self) -> tuple[int, int, int]:
        """m numbers marched, R outputs of their own, K load instants of the kernels, zeros beyond the stencil."""
        return len(self.marched), self.places.count("y"), self.kernels.LOADS

    def coefficient_rows(self, Omega: Array, xi: Array) -> Array:
        """The `coefficients` as rows (m*m + m*K + R*m + R*K, P) of the `sizes`; inputs (P,)."""
        return self._coefficients(Omega, xi, self._module_parameters)

    def _coefficients(self, Omega: Array, xi: Array, parameters: Sequence[Array]) -> Array:
        m, R, K = self.sizes
        return self._rows(self.kernels.coefficients, m * m + m * K + R * (m + K), Omega, xi, parameters)

    def transfer_rows(self, Omega: Array, xi: Array) -> Array:
        """The filter from load to response, (4*order + 1, P): see `transfer` of the generated module; inputs (P,)."""
        return self._rows(self.kernels.transfer, 4 * self.kernels.FILTER + 1, Omega, xi, self._module_parameters)

    def _rows(
        self, function: Callable[..., None], rows: int, Omega: Array, xi: Array, parameters: Sequence[Array]
    ) -> Array:
        inputs, out = np.empty((2 + len(parameters), len(Omega))), np.empty((rows, len(Omega)))
        for row, values in zip(inputs, (Omega, xi, *parameters), strict=True):
            row[:] = values
        inputs.flags.writeable = False  # as kernels read it
        function(*inputs, out)
        return out

    def lane(self, j: int) -> "Scheme":
        """The scheme with the parameters of lane j, where they are arrays (P,)."""
        mine, given = ({k: x[j] if x.ndim else x for k, x in d.items()} for d in (self.parameters, self.given))
        return replace(self, parameters=mine, given=given)

    @property
    def history(self) -> tuple[tuple[int, int], ...]:
        """Of each entry of the state: 0 for u, 1 for h*v, 2 for h^2*a, and how many steps before t_n."""
        return self.entry["history"]

    @property
    def start(self) -> str:
        """ "given", "start" or the scheme that marches the first steps: see the index of the kernels."""
        return self.entry["start"]

    def start_coefficients(self, Omega: ArrayLike, xi: ArrayLike = 0.0) -> tuple[Array, Array]:
        """State at t = 0 = given (n, m, 3) @ (u, h*v, h^2*a) + load (n, m, K) @ h^2 f at START_STENCIL*h."""
        _, arguments = self._points(Omega, xi)
        n, m = arguments[0].size, len(self.state)
        out = np.empty((n, m, 3)), np.empty((n, m, len(self.kernels.START_STENCIL)))
        self.kernels.start(*arguments, *out)
        return out

    @cached_property
    def _module_parameters(self) -> tuple[Array, ...]:
        """Parameters in the order of the module, which a member shares with its parent."""
        fixed = {name: np.float64(value) for name, value in self.entry["fixed"].items()}
        values = {**self.parameters, **fixed}
        return tuple(np.asarray(values[name]) for name in self.kernels.PARAMETERS)

    def _arguments(self, Omega: ArrayLike, xi: ArrayLike) -> list[Array]:
        return [non_negative("Omega", Omega), non_negative("xi", xi), *self._module_parameters]

    def _points(self, Omega: ArrayLike, xi: ArrayLike) -> tuple[tuple[int, ...], list[Array]]:
        return self._broadcast(*self._arguments(Omega, xi))

    def _shape(self, *arrays: Array) -> tuple[int, ...]:
        try:
            return np.broadcast(*arrays).shape
        except ValueError as error:
            names = ["Omega", "xi", *self.kernels.PARAMETERS][-len(arrays) :] if len(arrays) > 1 else ["Omega"]
            shapes = ", ".join(f"{name} {np.shape(a)}" for name, a in zip(names, arrays, strict=False))
            raise ValueError(
                f"expected shapes that broadcast, got {shapes}; add axes, for example Omega[:, None]"
            ) from error

    def _broadcast(self, *arrays: Array) -> tuple[tuple[int, ...], list[Array]]:
        """The common shape, and each array at that shape as contiguous 1-D (what kernels read)."""
        shape = self._shape(*arrays)
        return shape, [_flat(a, shape) for a in arrays]

    def _evaluate(self, function: str, outputs: int, Omega: ArrayLike, xi: ArrayLike) -> list[Array]:
        """What a kernel with so many outputs gives at all points; many points are spread over threads."""
        arrays = [float_array("Omega", Omega), float_array("xi", xi), *self._module_parameters]
        shape = self._shape(*arrays)
        n, kernel, numbers = prod(shape), getattr(self.kernels, function), [a.size == 1 for a in arrays]
        inputs = [_flat(a, (min(n, PART),) if one else shape) for a, one in zip(arrays, numbers, strict=True)]
        out, refused = np.empty((outputs, n)), []
        most = PART if any(numbers) else max(n, 1)

        def part(begin: int, end: int) -> None:
            for first in range(begin, end, most):
                last = min(first + most, end)
                own = (a[: last - first] if one else a[first:last] for a, one in zip(inputs, numbers, strict=True))
                refused.append(kernel(*own, *out[:, first:last]))

        spread(part, n, PART, nanoseconds=n * NANOSECONDS[function])
        if n == 0 or any(refused):  # kernels look at what they read anyway
            for name, value in (("Omega", Omega), ("xi", xi)):
                non_negative(name, value)
        return [row[()] for row in out.reshape(outputs, *shape)]


def _flat(array: Array, shape: tuple[int, ...]) -> Array:
    """The array at that shape as kernels read it."""
    if array.shape != shape:
        array = np.full(prod(shape), array.reshape(())[()]) if array.size == 1 else np.broadcast_to(array, shape)
    return read_only(array)


def read_only(array: Array) -> Array:
    """The array as contiguous 1-D, a view where it can be one; read-only: it may be the caller's, and kernels are
    compiled for such alone.
    """
    if array.ndim == 1 and array.flags.c_contiguous and not array.flags.writeable:
        return array
    flat = array.ravel()
    flat.setflags(write=False)
    return flat
