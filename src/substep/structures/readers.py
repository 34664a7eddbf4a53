"""Matrices M, C, K of other programs, and whole models of OpenSees.

Every reader gives what `substep.structure` takes: sparse matrices (N, N), or dense ones of OpenSees.
"""

from collections.abc import Iterable
from importlib.util import find_spec
from io import StringIO
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrays import Array
from .matrices import Matrix
from .structure import Structure, structure


def read_matrix(path: str | Path, *, name: str = "") -> Matrix:
    """A matrix from a file: its format by the first lines and the ending.

    Matrix Market (`%%MatrixMarket`, also .gz) and real Harwell-Boeing (.hb, .rua, .rsa, .rb) through SciPy;
    Nastran's OP4 (.op4) through pyyeti, where `name` says which matrix if there are several; text of rows
    "row column value", counted from 1, as Abaqus writes it with FORMAT=COORDINATE.

    Raises ValueError, with the line, for text that is none of these, for OP4 without pyyeti, and for an unknown name.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending == ".op4":
        return _op4(path, name)
    from scipy import io, sparse  # noqa: PLC0415 (slow to import)

    if ending == ".gz" or path.read_bytes()[:14].lower() == b"%%matrixmarket":
        return sparse.csr_array(io.mmread(path))
    if ending in (".hb", ".rb", ".rua", ".rsa", ".pua"):
        text, symmetric = _as_unsymmetric(path.read_text(encoding="ascii", errors="replace"))
        try:
            A = sparse.csr_array(io.hb_read(StringIO(text), spmatrix=False))
        except ValueError as error:
            raise ValueError(
                f"expected a real assembled Harwell-Boeing matrix in {path.name}, which SciPy reads, got: {error}; "
                "export Matrix Market"
            ) from error
        return _mirrored(A) if symmetric else A
    return _coordinates(path)


def _as_unsymmetric(text: str) -> tuple[str, bool]:
    """Harwell-Boeing text of one triangle as SciPy reads it, declared as a whole matrix; whether it was a triangle.

    The second letter of the third line is the structure: S, symmetric, of which the lower triangle is stored; or U.
    """
    lines = text.split("\n", 3)
    if len(lines) < 4 or lines[2][1:2].upper() != "S":
        return text, False
    lines[2] = f"{lines[2][0]}U{lines[2][2:]}"
    return "\n".join(lines), True


def _mirrored(A: Matrix) -> Matrix:
    """The symmetric matrix of which this is one triangle."""
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    return sparse.csr_array(A + A.T - sparse.diags_array(A.diagonal()))


def _coordinates(path: Path) -> Matrix:
    """Rows "row column value". Where all entries lie in one triangle, it is taken for half of a symmetric matrix."""
    from scipy import sparse  # noqa: PLC0415

    entries: list[tuple[int, int, float]] = []
    for number, line in enumerate(path.read_text(encoding="utf-8", errors="replace").splitlines(), 1):
        words = line.replace(",", " ").replace("D", "E").replace("d", "e").split()
        if not words or words[0].startswith(("*", "%", "#")):
            continue
        try:
            row, column, value = int(words[0]), int(words[1]), float(words[2])
        except (ValueError, IndexError):
            row = column = value = 0
        if len(words) != 3 or row < 1 or column < 1:
            raise ValueError(
                f"expected 'row column value', counted from 1, in line {number} of {path.name}, got {line.strip()!r}; "
                "write the matrix with FORMAT=COORDINATE, or as Matrix Market"
            )
        entries.append((row, column, value))
    if not entries:
        raise ValueError(f"expected rows 'row column value' in {path.name}, got none; is it the right file?")
    rows, columns, values = (np.array(x) for x in zip(*entries, strict=True))
    size = int(max(rows.max(), columns.max()))
    A = sparse.csr_array((values.astype(np.float64), (rows - 1, columns - 1)), shape=(size, size))
    if (rows <= columns).all() or (rows >= columns).all():
        return _mirrored(A)
    return A


def _op4(path: Path, name: str) -> Matrix:
    if not find_spec("pyyeti"):
        raise ValueError(f"expected pyyeti, which reads {path.name}, got none; pip install pyyeti")
    from scipy import sparse  # noqa: PLC0415

    with np.printoptions():  # which pyyeti changes when it is imported
        from pyyeti.nastran import op4  # noqa: PLC0415  # pyright: ignore[reportMissingImports]
    found = {key.lower(): value for key, value in op4.read(str(path), into="dct", sparse=True).items()}
    if not name and len(found) == 1:
        name = next(iter(found))
    if name.lower() not in found:
        raise ValueError(f"expected name of one of the matrices {', '.join(found)} in {path.name}, got {name!r}")
    return sparse.csr_array(found[name.lower()])


def from_opensees(ops: Any, *, nodes: Iterable[int] | None = None, **options: Any) -> Structure:
    """The linear model that is defined in OpenSees: its M, C, K at the present state, through its GimmeMCK.

    ops: the module `openseespy.opensees`, after nodes, masses, elements and damping were given. Constraints are plain:
    fixed degrees of freedom are left out, others are named "node dof", both counted as OpenSees does, such as "5 1".
    nodes: tags of those that have degrees of freedom, all by default. options: of `substep.structure`, such as `load`
    by these names; matrices are dense, so that it is for small models. The analysis defined in OpenSees is wiped.

    Raises ValueError for a model without free degrees of freedom, and for what `substep.structure` does.
    """
    M, C, K = (_gimme(ops, one) for one in np.eye(3))
    names = [""] * len(M)
    for tag in nodes if nodes is not None else ops.getNodeTags():
        for dof, equation in enumerate(ops.nodeDOFs(tag), 1):
            if equation >= 0:
                names[equation] = f"{tag} {dof}"
    if not all(names):
        raise ValueError(
            "expected a node for every equation of OpenSees' model, got none for equation "
            f"{names.index('')}; leave out nodes=, so that all are asked"
        )
    return structure(M, K, C=C if C.any() else None, names=names, **options)


def _gimme(ops: Any, weights: Array) -> Array:
    """The sum of weights times M, C, K (N, N)."""
    ops.wipeAnalysis()
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.algorithm("Linear")
    ops.integrator("GimmeMCK", *(float(w) for w in weights), 0.0)
    ops.analysis("Transient")
    ops.analyze(1, 0.0)
    N = ops.systemSize()
    if not N:
        raise ValueError("expected a model with free degrees of freedom in OpenSees, got none; define it first")
    return np.array(ops.printA("-ret"), dtype=np.float64).reshape(N, N)
