"""Matrices M, C, K of other programs, and whole models of OpenSees.

Every reader gives what `substep.structure` takes: sparse matrices (N, N), or dense ones of OpenSees.
"""

import re
from collections.abc import Iterable, Sequence
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from ..core.arrays import Array
from .solvers.matrices import Matrix
from .structure import Structure, structure

KIND = re.compile(
    r"[RCPI][SUHZR][AE]\b.*\n *\(", re.IGNORECASE
)  # how the third and fourth lines of Harwell-Boeing begin
SHORT_POWER = re.compile(
    r"(?<=[\d.])([+-]\d+) *$"
)  # of three digits, as in 1.5-101, for which Fortran has no letter left
FORMAT = re.compile(r"\((?:(?:\d*P,?)?(?P<powers>\d*)[ED]|(?P<others>\d*)[IFG])(?P<width>\d+)(?:\.\d+)?(?:E\d+)?\)")


def read_matrix(path: str | Path, *, name: str = "", size: int | None = None) -> Matrix:
    """A matrix from a file: its format by the first lines and the ending.

    Matrix Market (`%%MatrixMarket`, also .gz) through SciPy; Harwell-Boeing of real assembled matrices, such as Ansys
    writes with HBMAT, whose right-hand sides are left out (Duff, Grimes & Lewis, Users' Guide for the Harwell-Boeing
    Sparse Matrix Collection, 1992); Nastran's OP4 (.op4) through pyyeti, where `name` says which matrix if there are
    several; text of rows "row column value", counted from 1, as Abaqus writes it with FORMAT=COORDINATE. size: N, which
    such text does not say where the last degrees of freedom have no entry, as in M without their mass.

    Raises ValueError, with the line, for text that is none of these, for OP4 without pyyeti, for an unknown name, and
    for a matrix of another size.
    """
    path = Path(path)
    ending = path.suffix.lower()
    if ending == ".op4":
        return _of_size(_op4(path, name), size, path)
    from scipy import io, sparse  # noqa: PLC0415 (slow to import)

    if ending == ".gz" or path.read_bytes()[:14].lower() == b"%%matrixmarket":
        return _of_size(sparse.csr_array(io.mmread(path)), size, path)
    lines = path.read_text(encoding="utf-8", errors="replace").splitlines()
    if ending in (".hb", ".rb", ".rua", ".rsa", ".pua") or KIND.match("\n".join(lines[2:4])):
        return _of_size(_harwell_boeing(lines, path.name), size, path)
    return _of_size(_coordinates(lines, path.name, size), size, path)


def _of_size(matrix: Matrix, size: int | None, path: Path) -> Matrix:
    if size is not None and matrix.shape != (size, size):
        raise ValueError(
            f"expected a matrix of {size} x {size} in {path.name}, got shape {matrix.shape}; both M and K are "
            "of all degrees of freedom"
        )
    return matrix


def _harwell_boeing(lines: Sequence[str], name: str) -> Matrix:
    """A real assembled matrix; SciPy's reader takes no right-hand sides, exponents with D, or scales such as 1P."""
    from scipy import sparse  # noqa: PLC0415

    try:
        below = [int(word) for word in lines[1].split()[1:4]]  # lines of columns' starts, rows and values
        kind, (rows, columns, entries) = lines[2][:3].upper(), (int(word) for word in lines[2][3:].split()[:3])
        if kind[0] not in "RI" or kind[2] != "A" or kind[1] not in "SUR" or (kind[1] == "S" and rows != columns):
            raise ValueError(f"a matrix of kind {kind} with {rows} rows and {columns} columns")
        formats = lines[3][:16], lines[3][16:32], lines[3][32:52]
        first = 5 if len(lines[1].split()) > 4 and int(lines[1].split()[4]) else 4
        parts: list[list[str]] = []
        for count, form, wanted in zip(below, formats, (columns + 1, entries, entries), strict=True):
            parts.append(_fields(lines[first : first + count], form, wanted))
            first += count
        starts, places = (np.array([int(x) for x in part]) - 1 for part in parts[:2])
        if starts[0] != 0 or starts[-1] != entries or (np.diff(starts) < 0).any():
            raise ValueError(f"starts of columns that do not ascend from 1 to {entries + 1}")
        if entries and not 0 <= places.min() <= places.max() < rows:
            raise ValueError(f"rows that are not from 1 to {rows}")
        values = np.array([float(SHORT_POWER.sub(r"E\1", x.upper().replace("D", "E"))) for x in parts[2]])
        A = sparse.csr_array(sparse.csc_array((values, places, starts), shape=(rows, columns)))
    except (ValueError, IndexError) as error:
        raise ValueError(
            f"expected a real assembled Harwell-Boeing matrix in {name}, got: {error}; export Matrix Market"
        ) from error
    return _mirrored(A) if kind[1] == "S" else A


def _fields(lines: Sequence[str], form: str, wanted: int) -> list[str]:
    """The first numbers of lines in a format of Fortran's, such as (10I8) or (1P,3D20.12)."""
    if len(words := " ".join(lines).split()) == wanted:
        return words  # also of SciPy's writer, which puts blanks between fields of the full width
    found = FORMAT.match(form.upper().replace(" ", ""))
    if found is None:
        raise ValueError(f"the format {form.strip()}")
    repeat, width = int(found["powers"] or found["others"] or 1), int(found["width"])
    fields = [line[i * width : (i + 1) * width] for line in lines for i in range(repeat)]
    fields = [field for field in fields if field.strip()][:wanted]
    if len(fields) < wanted:
        raise ValueError(f"{len(fields)} numbers in place of {wanted} in the format {form.strip()}")
    return fields


def _mirrored(A: Matrix) -> Matrix:
    """The symmetric matrix of which this is one triangle."""
    from scipy import sparse  # noqa: PLC0415 (slow to import)

    return sparse.csr_array(A + A.T - sparse.diags_array(A.diagonal()))


def _coordinates(lines: Sequence[str], name: str, size: int | None) -> Matrix:
    """Rows "row column value". Where all entries lie in one triangle, it is taken for half of a symmetric matrix."""
    from scipy import sparse  # noqa: PLC0415

    entries: list[tuple[int, int, float]] = []
    for number, line in enumerate(lines, 1):
        words = line.replace(",", " ").replace("D", "E").replace("d", "e").split()
        if not words or words[0].startswith(("*", "%", "#")):
            continue
        try:
            row, column, value = int(words[0]), int(words[1]), float(words[2])
        except (ValueError, IndexError):
            row = column = value = 0
        if len(words) != 3 or row < 1 or column < 1:
            raise ValueError(
                f"expected 'row column value', counted from 1, in line {number} of {name}, got {line.strip()!r}; "
                "write the matrix with FORMAT=COORDINATE, or as Matrix Market"
            )
        entries.append((row, column, value))
    if not entries:
        raise ValueError(f"expected rows 'row column value' in {name}, got none; is it the right file?")
    rows, columns, values = (np.array(x) for x in zip(*entries, strict=True))
    n = max(int(max(rows.max(), columns.max())), size or 0)
    A = sparse.csr_array((values.astype(np.float64), (rows - 1, columns - 1)), shape=(n, n))
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
    if not any(map(partial(_free_dofs, ops), ops.getNodeTags())):  # OpenSees ends the process in such an analysis
        raise ValueError("expected a model with free degrees of freedom in OpenSees, got none; define it first")
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


def _free_dofs(ops: Any, tag: int) -> set[int]:
    """Numbers of a node's degrees of freedom that are neither fixed nor follow others."""
    return set(range(1, ops.getNDF(tag)[0] + 1)) - {*ops.getFixedDOFs(tag), *ops.getConstrainedDOFs(tag)}


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
    return np.array(ops.printA("-ret"), dtype=np.float64).reshape(N, N)
