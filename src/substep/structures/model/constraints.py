"""Constraints of a structure: displacements T q of all degrees of freedom by those that are free."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...core.arrays import Array
from ..solvers.factorization import SingularMatrix, factorize
from ..solvers.matrices import Matrix, finite, is_identity, vector


def transformation(N: int, held: Sequence[int], constraints: Any) -> Matrix:
    """T (N, n), sparse."""
    from scipy import sparse  # noqa: PLC0415

    if constraints is None:
        if len(held) == N:
            raise ValueError(f"expected a degree of freedom that is not fixed, got all {N} fixed; leave one free")
        return sparse.eye_array(N, format="csr")[:, np.setdiff1d(np.arange(N), held)]
    given = finite("constraints T", constraints)
    shape: tuple[int, ...] = np.shape(given)
    if len(shape) != 2 or shape[0] != N or not 1 <= shape[1] <= N:
        raise ValueError(f"expected constraints T ({N}, n) with n from 1 to {N}, got shape {shape}")
    T = sparse.csr_array(given)
    if held and abs(T[held]).sum() > 0.0:
        raise ValueError("expected constraints under which fixed degrees of freedom do not move; clear their rows")
    try:
        factorize(sparse.csr_array(T.T @ T))
    except SingularMatrix as error:
        raise ValueError(
            f"expected constraints T with independent columns, got column {error.place} dependent on others; leave it "
            "out"
        ) from error
    return T


def independent(name: str, given: ArrayLike, T: Matrix, names: tuple[str, ...]) -> Array:
    """q with T q = x, of one number for all that are not fixed. Raises ValueError where there is none."""
    x = vector(name, given, T.shape[0])
    if is_identity(T):
        return x
    moving = np.asarray(abs(T).sum(axis=1)).ravel() > 0.0
    if np.ndim(given) == 0:
        x = x * moving
    q = factorize(T.T @ T)(T.T @ x)
    off = np.abs(T @ q - x)
    if off.max() > 1e-10 * max(1e-300, float(np.abs(x).max())):
        worst = int(np.argmax(off))
        kind, of = "constrained" if moving[worst] else "fixed", f"'{names[worst]}'" if names else worst
        raise ValueError(
            f"expected {name} that keeps the constraints, got {x[worst]} at the {kind} degree of freedom {of}, where "
            f"they give {(T @ q)[worst]:.6g} at best; give {name} = T q"
        )
    return q
