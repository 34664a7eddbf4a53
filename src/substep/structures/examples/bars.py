"""A straight bar of linear elements, for waves."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ...core.arrays import Array
from ...core.loads import Load
from ..solvers.factorization import Solver
from ..structure import Structure, structure
from .checks import counts, positive
from .naming import placed


def bar(
    elements: int = 200,
    *,
    length: float = 1.0,
    E: float = 1.0,
    area: float = 1.0,
    rho: float = 1.0,
    lumped: bool = False,
    fixed_ends: tuple[bool, bool] = (False, True),
    load: Load | None = None,
    start: Callable[[Array], Array] | None = None,
    C: Any = None,
    solver: Solver = "auto",
) -> Structure:
    """A bar along x from 0 to length, in which waves run at sqrt(E/rho); names "u at x".

    load: force on the end x = 0 over time. start: displacement at t = 0 as a function of x; it has to vanish at fixed
    ends. lumped: half the mass of an element on each of its ends, in place of the consistent mass matrix.

    Raises ValueError for dimensions that are not positive, and for what `substep.structure` does.
    """
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    counts(elements=elements)
    positive(length=length, E=E, area=area, rho=rho)
    x = np.linspace(0.0, length, elements + 1)
    dx = length / elements
    ends = np.r_[1.0, np.full(elements - 1, 2.0), 1.0]
    beside = np.ones(elements)
    K = sparse.diags_array([-beside, ends, -beside], offsets=[-1, 0, 1]) * (E * area / dx)
    mass = rho * area * dx
    if lumped:
        M = sparse.diags_array(0.5 * mass * ends)
    else:
        M = sparse.diags_array([beside, 2.0 * ends, beside], offsets=[-1, 0, 1]) * (mass / 6.0)
    return structure(
        M,
        K,
        C=C,
        load=[] if load is None else [({0: 1.0}, load)],
        u0=0.0 if start is None else start(x),
        fixed=[end for end, held in zip((0, elements), fixed_ends, strict=True) if held],
        names=placed(["u"], x[:, None]),
        solver=solver,
    )
