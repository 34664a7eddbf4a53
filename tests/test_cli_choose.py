"""The command `choose`, of scenes and of structures read from files."""

import math
from pathlib import Path

import numpy as np
import pytest
from plane_elements import shear_building
from scipy.io import mmwrite
from scipy.sparse import coo_array
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app

runner = CliRunner()


@pytest.mark.thorough
@pytest.mark.usefixtures("uncompiled", "plain_marches")
def test_choose_recommends_and_draws_why(tmp_path: Path) -> None:
    """On plain Python kernels; what compiled ones find is the same, which test_kernels and test_adaptive_sweep hold."""
    wish = ["choose", "linear_oscillator", "--omega", "6.28", "--accuracy", "1e-2", "--t-end", "2"]
    result = runner.invoke(app, [*wish, "--file", str(tmp_path / "why")])
    assert result.exit_code == 0, result.output
    assert "on linear_oscillator, dt =" in result.output
    assert f"marching {len(ss.schemes())} schemes, each in finer and finer steps; --among" in result.stderr
    assert (tmp_path / "why.png").stat().st_size > 10_000
    for bad in (["--quantity", "angle"], ["--accuracy", "0"], ["--omega", "-1"]):
        assert runner.invoke(app, [*wish, *bad]).exit_code == 2
    bar = ["elastic_pendulum", "--EA", "1e8", "--strain", "engineering", "--a0", "-19.6,0", "--quantity", "angle"]
    bar += ["--among", "bathe,newmark", "--chosen", "bathe"]
    rigid = runner.invoke(app, ["choose", *bar, "--accuracy", "1e-1", "--t-end", "0.1"])
    assert rigid.stdout.startswith(("bathe on rigid_pendulum", "newmark on rigid_pendulum"))
    assert runner.invoke(app, [*wish, "--among", "bath"]).exit_code == 2
    parameters = ["--among", "newmark:beta=.3,gamma=3/5,wilson_theta:theta=2", "--chosen", "wilson_theta:theta=2"]
    own = runner.invoke(app, [*wish, *parameters])
    assert "marching 2 schemes, each in finer and finer steps\n" in own.stderr
    assert own.stdout.startswith(("newmark(beta=0.3, gamma=0.6) on", "wilson_theta(theta=2) on")), own.output
    unknown = runner.invoke(app, ["choose", "rigid_pendulum", "--accuracy", "1e-2"])
    assert unknown.exit_code == 2
    assert "--t-end" in unknown.output


@pytest.fixture
def building(tmp_path: Path) -> dict[str, Path]:
    """Files of a shear building of five storeys, of a force and, in sign and scale its like, of a ground motion."""
    M, K = shear_building([2.0, 1.0, 1.0, 1.0, 1.0], [900.0, 800.0, 700.0, 600.0, 500.0])
    files = {name: tmp_path / f"{name}.mtx" for name in ("mass", "stiffness")}
    mmwrite(files["mass"], coo_array(M))
    mmwrite(files["stiffness"], coo_array(K))
    files["load"] = tmp_path / "load.txt"
    files["load"].write_text("\n".join(f"{0.02 * i:.2f} {math.sin(0.14 * i):.9f}" for i in range(101)))
    return files


@pytest.mark.matrix
@pytest.mark.usefixtures("uncompiled")
@pytest.mark.parametrize("ground", [False, True], ids=["force", "ground"])
@pytest.mark.parametrize("ratio", [0.0, 0.05])
def test_choose_reads_a_structure_from_files(building: dict[str, Path], ground: bool, ratio: float) -> None:
    """It prints what the same call in Python answers, whose matrices never went through files."""
    M, K = shear_building([2.0, 1.0, 1.0, 1.0, 1.0], [900.0, 800.0, 700.0, 600.0, 500.0])
    record, at = ss.Record(0.02, [round(math.sin(0.14 * i), 9) for i in range(101)]), [0, 1, 2, 3, 4] if ground else [3]
    C = ss.modal_damping(ratio, 5) if ratio else None
    s = ss.structure(coo_array(M), coo_array(K), C=C, load=() if ground else ({3: 1.0}, record))
    s = s.ground_motion(record, np.ones(5)) if ground else s
    wish = {"among": ["bathe", "newmark"], "model": "direct"}
    expected = ss.choose(s, 1e-2, t_end=2.0, quantity=4, **wish)
    files = [text for name, path in building.items() for text in (f"--{name}", str(path))]
    options = ["--at", ",".join(map(str, at)), "--quantity", "4", "--accuracy", "1e-2", "--model", "direct"]
    options += ["--among", "bathe,newmark", "--damping-ratio", str(ratio), *["--ground"] * ground]
    result = runner.invoke(app, ["choose", *files, *options])
    assert result.exit_code == 0, result.stdout
    assert " ".join(result.stdout.split()) == " ".join(expected.text.split())


def test_choose_refuses_what_is_neither_a_scene_nor_a_structure(building: dict[str, Path]) -> None:
    files = [text for name, path in building.items() for text in (f"--{name}", str(path))]
    whole = ["choose", *files, "--accuracy", "1e-2", "--at", "3", "--quantity", "4"]
    for arguments, what in (
        (["choose", "--accuracy", "1e-2"], "got neither"),
        (["choose", "--accuracy", "1e-2", *files[:2]], "got --mass"),
        (["choose", "duffing", "--accuracy", "1e-2", "--at", "3"], "options of a scene, got --at"),
        ([*whole, "--strain", "engineering"], "options of a structure, got --strain"),
        ([*whole, "--stifness", "K.mtx"], "options of a structure, got --stifness"),
        ([*whole, "--quantity", "u"], "the number of a degree of freedom, from 0, got 'u'"),
        ([*whole, "--quantity", "5"], "a degree of freedom from 0 to 4 or its name, got 5"),
        ([*whole, "--at", "3;4"], "numbers of degrees of freedom as 0,3 for --at, got '3;4'"),
        ([*whole, "--at", "5", "--ground"], "a degree of freedom from 0 to 4 or its name, got 5"),
        ([*whole[:-4], "--quantity", "4"], "expected --at, the degrees of freedom of the load"),
        ([*whole[:5], *whole[7:]], "expected --load, a file of two columns"),
        ([*whole, "--model", "both"], "a model, one of: any, direct, modal; got 'both'"),
        ([*whole, "--mass", str(building["load"])], "expected 'row column value'"),
        ([*whole, "--load", "none.txt"], "expected a file to read, got none.txt, which is not there; correct"),
        ([*whole, "--mass", "."], "expected a file to read, got ., which is a folder; correct the path"),
    ):
        result = runner.invoke(app, arguments)
        assert result.exit_code == 2, arguments
        assert what in " ".join(result.output.replace("│", " ").split()), (arguments, result.output)
