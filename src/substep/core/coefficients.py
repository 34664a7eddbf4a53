"""What the linear march needs of a scheme: the coefficients of one step, the stencil of the load, and the start.

A step marches x, the `marched` entries of the scheme's state, and reports y, those of u, h*v, h^2*a that are not among
them: x1 = x0 + D x0 + B h^2 f and y1 = O x0 + P h^2 f, with the loads f at the instants of the stencil. If a balance
at t_n gives the acceleration a_n, that balance eliminates a_n from x; the first h^2 f of the first step is then
replaced by h^2 a + 2 xi Omega h v + Omega^2 u at the start, with which the balance gives the acceleration there. D is
the amplification matrix of x less the identity, rounded once.
"""

from collections.abc import Callable, Sequence
from functools import cache
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from .arrays import Array, common_shape, flat
from .formulas import at_points, evaluated
from .scheme_record import SchemeRecord
from .stability import points


def marched(scheme: SchemeRecord) -> tuple[int, ...]:
    """Which entries of the scheme's state the linear march carries."""
    return scheme.kernels.KEPT


def places(scheme: SchemeRecord) -> tuple[str, ...]:
    """The place of each of u, h*v and h^2*a in x, as text; "y" for one that is not in x."""
    return _places(scheme.kernels.MARCH)


@cache
def _places(march: str) -> tuple[str, ...]:
    own = march.split("_")[3:]  # the names are such as linear_march_2_01y or linear_march_12_0_11_y
    return tuple(own if len(own) == 3 else own[0])


def march_name(m: int, places: Sequence[str]) -> str:
    """The name of the march of m numbers with these `places`."""
    return f"linear_march_{m}_{'_'.join(places) if any(len(p) > 1 for p in places) else ''.join(places)}"


def sizes(scheme: SchemeRecord) -> tuple[int, int, int]:
    """m, the size of x; R, the size of y; K, the load instants a step of the march's kernel.

    The scheme's own stencil may have fewer instants; the coefficients of the others are then 0.
    """
    return len(marched(scheme)), places(scheme).count("y"), scheme.kernels.LOADS


def refuse_damping(scheme: SchemeRecord, xi: ArrayLike) -> None:
    """Raises ValueError for xi > 0 and a scheme that takes no damping."""
    if not scheme.info.damping and np.any(xi):
        raise ValueError(
            f"{scheme.info.name} is a scheme for u'' = g(t, u), without damping: expected xi = 0, got {np.max(xi):g}; "
            "take xi = 0 or another scheme"
        )


def coefficients(scheme: SchemeRecord, Omega: ArrayLike, xi: ArrayLike) -> tuple[Array, Array, Array, Array]:
    """D (n, m, m), B (n, m, K), O (n, R, m), P (n, R, K) at the n points of Omega, xi and parameters in C order.

    K is here the number of instants of the scheme's stencil.
    """
    _, (Omegas, xis, *parameters) = points(scheme, Omega, xi)
    refuse_damping(scheme, xi)
    rows = evaluated(scheme.kernels.coefficients, len(Omegas), (Omegas, xis, *parameters))
    (m, R, K), loads = sizes(scheme), scheme.info.loads
    D, b, y_x, y_f = np.split(rows.T, np.cumsum([m * m, m * K, R * m]), axis=1)
    B, O_f = b.reshape(-1, m, K)[..., :loads], y_f.reshape(len(D), R, K)[..., :loads]
    return D.reshape(-1, m, m), B, y_x.reshape(len(D), R, m), O_f


def march_rows(
    scheme: SchemeRecord, lanes: Sequence[Array], within: Array | None, kinds: tuple[int, ...], consistent: bool
) -> Callable[[slice], tuple[Array, Array, Array]]:
    """What gives what kernels take of some of P lanes: coefficients C, what is marched x, and u, v, a at the start.

    The rows of C (rows, p) are D, B, O, P of the `sizes`, row by row, then scales. They are for loads f, not
    h^2 f / mass, and for v, a, not h*v, h^2*a; the scales are 1/h and 1/h^2 for those of v, a that are taken from x.
    x (k, p): those of u, h*v, h^2*a at the start whose kinds, 0 to 2, are given; u, v, a are (3, p).

    lanes: omega, xi, mass, h, and u, v, a at the start, (P,) each. consistent: the last is not a, but the load, with
    which the equation of motion gives a. within: None for loads at the scheme's own instants; else these instants (k,),
    where the loads taken are those at the two ends of a step, within which they are linear.
    """
    refuse_damping(scheme, lanes[1])
    stencil = () if within is None else tuple(within)
    asked = sizes(scheme), places(scheme), len(stencil), kinds, consistent
    formulas = _march_formulas(scheme.kernels.coefficients, *asked)
    at, k = at_points(formulas, [*lanes, *stencil, *scheme.kernel_parameters]), len(kinds)

    def of(some: slice) -> tuple[Array, Array, Array]:
        rows = at(some)
        end = len(rows) - 3 - k
        return rows[:end], rows[end : end + k], rows[end + k :]

    return of


@cache
def _march_formulas(
    coefficients: Callable[..., Sequence[Any]],
    sizes: tuple[int, int, int],
    places: tuple[str, ...],
    instants: int,
    kinds: tuple[int, ...],
    consistent: bool,
) -> Callable[..., list[Any]]:
    """The formulas of `march_rows`; instants: how many there are of loads between the ends of a step, or 0."""
    (m, R, K), outputs = sizes, [kind for kind, place in enumerate(places) if place == "y"]

    def formulas(by: Any, omega: Any, xi: Any, mass: Any, h: Any, u: Any, v: Any, last: Any, *others: Any) -> list[Any]:
        stencil, parameters = others[:instants], others[instants:]
        rows = iter(coefficients(by, omega * h, xi, *parameters))
        sized = (m, m), (m, K), (R, m), (R, K)
        of_x, of_f, y_x, y_f = ([[next(rows) for _ in range(width)] for _ in range(height)] for height, width in sized)
        if stencil:
            of_f, y_f = ([_at_ends(row, stencil) for row in matrix] for matrix in (of_f, y_f))
        squared = h * h
        start = u, v, last / mass - omega * omega * u - 2.0 * xi * omega * v if consistent else last
        marched = [start[kind] * (1.0, h, squared)[kind] for kind in kinds]
        scale, loaded = (1.0, 1.0 / h, 1.0 / squared), (squared / mass, h / mass, 1.0 / mass)
        of_f = [[x * loaded[0] for x in row] for row in of_f]
        y_x = [[x * scale[kind] if kind else x for x in row] for kind, row in zip(outputs, y_x, strict=True)]
        y_f = [[x * loaded[kind] for x in row] for kind, row in zip(outputs, y_f, strict=True)]
        scales = [scale[kind] for kind, place in enumerate(places) if place != "y" and kind]
        return [*(x for matrix in (of_x, of_f, y_x, y_f) for row in matrix for x in row), *scales, *marched, *start]

    return formulas


def _at_ends(row: Sequence[Any], stencil: Sequence[Any]) -> list[Any]:
    """What multiplies loads at the two ends of a step, from what multiplies those at its instants."""
    first, last = 0.0, 0.0
    for x, share in zip(row, stencil, strict=False):  # the row may have more, which are 0
        first, last = first + x * (1.0 - share), last + x * share
    return [first, last]


def transfer_rows(scheme: SchemeRecord, Omega: Array, xi: Array) -> Array:
    """Coefficients (4*order + 1, P) of the digital filter from load to response, for Omega and xi (P,).

    The rows are described at `transfer` in the generated module; order is the module's FILTER, which must not be 0.
    """
    refuse_damping(scheme, xi)
    return evaluated(scheme.kernels.transfer, len(Omega), (Omega, xi, *scheme.kernel_parameters))


def start_coefficients(scheme: SchemeRecord, Omega: ArrayLike, xi: ArrayLike) -> tuple[Array, Array]:
    """S (n, m, 3), T (n, m, K): the state at t = 0 is S (u, h*v, h^2*a) + T h^2 f, f the load at START_STENCIL*h."""
    refuse_damping(scheme, xi)
    _, arguments = points(scheme, Omega, xi)
    n, m = arguments[0].size, len(scheme.info.state)
    S, T = np.split(evaluated(scheme.kernels.start, n, arguments).T, [3 * m], axis=1)
    return S.reshape(n, m, 3), T.reshape(n, m, len(scheme.kernels.START_STENCIL))


def stencil(scheme: SchemeRecord) -> Array:
    """Instants at which a step takes the load, in steps after t_n: (..., K), read-only."""
    values = scheme.kernel_parameters
    shape = common_shape(scheme.kernels.PARAMETERS, values)
    found = evaluated(scheme.kernels.stencil, prod(shape), [flat(value, shape) for value in values])
    found = np.ascontiguousarray(found.T).reshape(*shape, -1)
    found.flags.writeable = False
    return found


def loaded_within(stencil: Array) -> bool:
    """Whether all of the instants lie within the step."""
    return bool(stencil.min() >= 0.0 and stencil.max() <= 1.0)
