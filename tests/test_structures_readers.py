"""Matrices written by SciPy, by hand and by pyyeti are read as they were."""

import subprocess
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy import io, sparse

from substep.structures import readers
from substep.structures.examples import frame
from substep.structures.readers import read_matrix


@pytest.mark.parametrize("ending", [".mtx", ".mtx.gz", ".hb"])
def test_what_scipy_writes_is_read(ending: str, tmp_path: Path) -> None:
    K = frame(1, 1).K
    path = tmp_path / f"stiffness{ending}"
    if ending == ".hb":
        io.hb_write(path, sparse.csc_array(K))
    elif ending.endswith(".gz"):
        import gzip

        io.mmwrite(tmp_path / "plain.mtx", K, precision=17)
        path.write_bytes(gzip.compress((tmp_path / "plain.mtx").read_bytes()))
    else:
        io.mmwrite(path, K, precision=17)
    assert abs(read_matrix(path) - K).max() <= 1e-15 * abs(K).max()


@pytest.mark.parametrize("code", ["RSA", "rsa"])
def test_a_symmetric_harwell_boeing_matrix_is_read(code: str, tmp_path: Path) -> None:
    """Of which the lower triangle is stored; other kinds are refused with SciPy's reason."""
    K, path = frame(1, 1).K, tmp_path / "stiffness.rsa"
    io.hb_write(path, sparse.csc_array(sparse.tril(K)))
    text = path.read_text(encoding="ascii")
    assert text.count("RUA") == 1
    path.write_text(text.replace("RUA", code), encoding="ascii")
    assert abs(read_matrix(path) - K).max() <= 1e-15 * abs(K).max()
    path.write_text(text.replace("RUA", "RZA"), encoding="ascii")
    with pytest.raises(ValueError, match="real assembled Harwell-Boeing matrix in stiffness.rsa.*skew.*Matrix Market"):
        read_matrix(path)


@pytest.mark.parametrize("part", ["whole", "lower", "upper"])
def test_coordinate_text_is_read(part: str, tmp_path: Path) -> None:
    """As Abaqus writes it: whole matrices as they are, triangles as half of a symmetric matrix."""
    K = frame(1, 1).K
    if part == "whole":
        K = sparse.csr_array(K + sparse.csr_array(([1.0], ([0], [1])), shape=K.shape) * K.max())
    half = {"whole": K, "lower": sparse.tril(K), "upper": sparse.triu(K)}[part].tocoo()
    lines = [f"{i + 1} {j + 1}  {x:.16e}" for i, j, x in zip(*half.coords, half.data, strict=True)]
    path = tmp_path / "job_STIF1.mtx"
    path.write_text("\n".join(["** written by hand", *lines, ""]), encoding="utf-8")
    assert abs(read_matrix(path) - K).max() == 0.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("1 1 2.0\n1 2\n", "line 2"),
        ("0 1 2.0\n", "counted from 1"),
        ("1 1 x\n", "line 1"),
        ("** nothing\n", "got none"),
    ],
)
def test_other_text_is_refused_with_its_line(text: str, message: str, tmp_path: Path) -> None:
    path = tmp_path / "matrix.txt"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        read_matrix(path)


def test_op4_needs_pyyeti(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(readers, "find_spec", lambda _: None)
    with pytest.raises(ValueError, match="pip install pyyeti"):
        read_matrix(tmp_path / "model.op4")


@pytest.mark.skipif(not find_spec("pyyeti"), reason="pyyeti, of the extra bench, is not installed")
def test_op4_is_read(tmp_path: Path) -> None:
    printed = np.get_printoptions()
    with np.printoptions():  # which pyyeti changes when it is imported
        from pyyeti.nastran import op4  # pyright: ignore[reportMissingImports]
    model, path = frame(1, 1), tmp_path / "model.op4"
    op4.write(str(path), {"mgg": model.M.toarray(), "kgg": model.K.toarray()})
    assert abs(read_matrix(path, name="KGG") - model.K).max() <= 1e-15 * abs(model.K).max()
    with pytest.raises(ValueError, match="mgg, kgg"):
        read_matrix(path)
    assert np.get_printoptions() == printed


def test_reading_op4_leaves_the_print_options_alone(tmp_path: Path) -> None:
    """In a process of its own, where the reader is the first to import pyyeti."""
    script = """
import numpy as np
from substep.structures.readers import read_matrix
before = np.get_printoptions()
try:
    read_matrix("none.op4")
except OSError:
    pass
assert np.get_printoptions() == before
"""
    subprocess.run([sys.executable, "-c", script], cwd=tmp_path, check=True)
