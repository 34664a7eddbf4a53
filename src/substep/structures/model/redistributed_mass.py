"""Mass that is taken from degrees of freedom in contact and given to the others (Khenous, Laborde & Renard 2008)."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...core.errors import real_array
from ..solvers.matrices import Matrix, diagonal_of, finite


def redistributed_mass(M: Any, without: Sequence[int], fields: Any) -> Matrix:
    """The diagonal matrix next to a diagonal M (N, N) that has no mass at the degrees of freedom `without`.

    fields (N,) or (N, k): displacements of which it keeps all products R^T M R. Ones and the places of nodes on a line
    keep the mass, its centre and its moment of inertia; in a plane these are the two translations and the turn about
    the origin. Of all such masses it changes those of M least, relative to them and weighted by them: m_i becomes
    m_i (1 + R_i L R_i^T), L symmetric. A contact of a node without mass loses and gains no energy: see
    docs/constraints_and_contact.md. Source: Khenous, Laborde & Renard, Eur. J. Mech. A/Solids 27 (2008) 918.

    Raises ValueError for an M that is not diagonal, for numbers of other degrees of freedom, fields of another shape,
    and where no such masses are positive.

    >>> x = np.linspace(0.0, 1.0, 5)
    >>> line = np.column_stack([np.ones(5), x])
    >>> ss.redistributed_mass(np.diag([1.0, 2.0, 2.0, 2.0, 1.0]), [0], line).diagonal().round(3)
    array([0.   , 4.286, 1.143, 0.857, 1.714])
    """
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    mass = finite("M", M)
    m = diagonal_of(mass) if mass.ndim == 2 and mass.shape[0] == mass.shape[1] else None
    if m is None:
        raise ValueError(
            f"expected M as a diagonal matrix (N, N), got one of shape {mass.shape} with other entries; lump it, as by "
            "the sums of its rows"
        )
    N, R = len(m), real_array("fields", fields)
    R = R[:, None] if R.ndim == 1 else R
    if R.ndim != 2 or len(R) != N:
        raise ValueError(f"expected fields of shape ({N},) or ({N}, k), got {np.shape(fields)}; give one number a row")
    bare = np.zeros(N, bool)
    for place in without:
        if not isinstance(place, int | np.integer) or not -N <= place < N:
            raise ValueError(f"expected degrees of freedom from 0 to {N - 1}, got {place!r}; give their numbers")
        bare[place] = True
    rows, columns = np.triu_indices(R.shape[1])
    products = R[:, rows] * R[:, columns]  # of a node: what its mass counts in each entry of R^T M R
    rest = np.where(bare, 0.0, m)
    L, *_ = np.linalg.lstsq(products.T @ (rest[:, None] * products), products[bare].T @ m[bare], rcond=None)
    found = rest * (1.0 + products @ L)
    kept, wanted = products.T @ found, products.T @ m
    if np.abs(kept - wanted).max() > 1e-9 * np.abs(products.T @ np.abs(m)).max() or (found[rest > 0.0] <= 0.0).any():
        raise ValueError(
            f"expected positive masses that keep R^T M R without those of {int(bare.sum())} degrees of freedom, found "
            "none; give fewer fields, or leave more degrees of freedom their mass"
        )
    return sparse.diags_array(found).tocsr()
