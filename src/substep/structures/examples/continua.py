"""A plate and a solid, assembled by scikit-fem (extra `fem`)."""

from importlib.util import find_spec
from typing import Any

import numpy as np

from ...core.loads import Load
from ..solvers.factorization import Solver
from ..structure import Structure, structure
from .checks import counts, positive
from .naming import placed


def _skfem() -> Any:
    """The package. Raises ValueError where it is not installed."""
    if not find_spec("skfem"):
        raise ValueError("expected scikit-fem, which assembles this model, got none; pip install 'substep[fem]'")
    import skfem  # noqa: PLC0415

    return skfem


def plate(
    cells: int = 8,
    *,
    side: float = 10.0,
    thickness: float = 0.05,
    E: float = 200e9,
    nu: float = 0.3,
    rho: float = 8000.0,
    load: Load | None = None,
    C: Any = None,
    solver: Solver = "auto",
) -> Structure:
    """A square Kirchhoff plate, simply supported on all sides, of cells x cells Bogner-Fox-Schmit elements.

    Each node has w, its two slopes and its twist; names "w at 5 5", "w_x at 5 5", ... load: pressure over time. By
    default that of NAFEMS, Selected Benchmarks for Forced Vibration (1989), test 13T, in N, m, kg.

    Raises ValueError without scikit-fem, and for dimensions that are not positive.
    """
    skfem = _skfem()
    counts(cells=cells)
    positive(side=side, thickness=thickness, E=E, rho=rho)
    line = np.linspace(0.0, side, cells + 1)
    mesh = skfem.MeshQuad.init_tensor(line, line)
    basis = skfem.Basis(mesh, skfem.ElementQuadBFS(), intorder=6)  # exact for products of bicubics
    D, mass = E * thickness**3 / (12.0 * (1.0 - nu**2)), rho * thickness

    @skfem.BilinearForm
    def bending(u: Any, v: Any, _: Any) -> Any:
        ((a, b), (_, c)), ((d, e), (_, f)) = u.hess, v.hess
        return D * (a * d + c * f + nu * (a * f + c * d) + 2.0 * (1.0 - nu) * b * e)

    @skfem.BilinearForm
    def inertia(u: Any, v: Any, _: Any) -> Any:
        return mass * u * v

    @skfem.LinearForm
    def pressure(v: Any, _: Any) -> Any:
        return v

    x, y = mesh.p
    w, w_x, w_y, _ = basis.nodal_dofs
    at_x, at_y = ((p == 0.0) | (p == side) for p in (x, y))
    fixed = np.unique(np.r_[w[at_x | at_y], w_y[at_x], w_x[at_y]])
    P = pressure.assemble(basis)
    P[fixed] = 0.0
    names = np.empty(basis.N, dtype=object)
    names[basis.nodal_dofs.T.ravel()] = placed(("w", "w_x", "w_y", "w_xy"), mesh.p.T)
    return structure(
        inertia.assemble(basis), bending.assemble(basis), C=C, load=[] if load is None else [(P, load)],
        fixed=fixed.tolist(), names=names.tolist(), solver=solver,
    )  # fmt: skip


def solid(
    cells: tuple[int, int, int] = (10, 10, 10),
    *,
    size: tuple[float, float, float] = (1.0, 1.0, 1.0),
    E: float = 200e9,
    nu: float = 0.3,
    rho: float = 8000.0,
    lumped: bool = False,
    load: Load | None = None,
    C: Any = None,
    solver: Solver = "auto",
) -> Structure:
    """A box of linear elasticity in cells of eight nodes, clamped at x = 0; names "uz at 1 1 1".

    load: force over time in z on the corner where x, y and z are largest. lumped: the mass of each row on its diagonal.
    Free degrees of freedom are 3 nx (ny + 1) (nz + 1): 3630 of (10, 10, 10), 26460 of (20, 20, 20), 95232 of
    (31, 31, 31). By default in N, m, kg.

    Raises ValueError without scikit-fem, and for dimensions that are not positive.
    """
    skfem = _skfem()
    from skfem.models import elasticity  # noqa: PLC0415

    counts(**dict(zip(("cells in x", "cells in y", "cells in z"), cells, strict=True)))
    positive(**dict(zip(("size in x", "size in y", "size in z"), size, strict=True)), E=E, rho=rho)
    lines = [np.linspace(0.0, length, n + 1) for length, n in zip(size, cells, strict=True)]
    mesh = skfem.MeshHex.init_tensor(*lines)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementHex1()), intorder=2)
    K = elasticity.linear_elasticity(*elasticity.lame_parameters(E, nu)).assemble(basis)

    @skfem.BilinearForm
    def inertia(u: Any, v: Any, _: Any) -> Any:
        return rho * sum(a * b for a, b in zip(u, v, strict=True))

    M = inertia.assemble(basis)
    if lumped:
        from scipy import sparse  # noqa: PLC0415

        M = sparse.diags_array(np.asarray(M.sum(axis=1)).ravel())
    corner = int(np.argmax(mesh.p.sum(axis=0)))
    names = np.empty(basis.N, dtype=object)
    names[basis.nodal_dofs.T.ravel()] = placed(("ux", "uy", "uz"), mesh.p.T)
    return structure(
        M, K, C=C, load=[] if load is None else [({int(basis.nodal_dofs[2, corner]): 1.0}, load)],
        fixed=basis.nodal_dofs[:, mesh.p[0] == 0.0].ravel().tolist(), names=names.tolist(), solver=solver,
    )  # fmt: skip
