"""Programs behind a pipe, the committed reports and the page that is made of them, and dialects."""

import ast
import json
import re
import shutil
import sys
from pathlib import Path

import numpy as np
import pytest
from substep_audit import program as programs_module
from substep_audit.dialects import TABLE, Dialect, dialects, find_dialect, to_plain
from substep_audit.instrument import audit_program
from substep_audit.linear_step import Candidate, Oscillators, with_parameters
from substep_audit.program import ADAPTERS, Program, programs

import substep as ss

ROOT = Path(__file__).parents[1]
sys.path.append(str(ROOT))
from audits import evidence  # noqa: E402
from audits.__main__ import CONVENTIONS, PAGE  # noqa: E402
from audits.page import conventions, page  # noqa: E402

pytestmark = pytest.mark.usefixtures("few_members")

ADAPTER = '''
"""Newmark's method with its arguments in the wrong order, printing while it runs."""
from adapter import Integrator, serve
import sys
import time

CLAIMS = {"scheme": ("newmark", "Newmark's method", "page 1"), "beta": (0.3, "beta", "page 1"),
          "gamma": (0.55, "gamma", "page 1"), "order": (1, "first order", "page 2")}
INTEGRATORS = {
    "newmark": Integrator(arguments={"beta": 0.3, "gamma": 0.55}, claims=CLAIMS),
    "dies": Integrator(arguments={"beta": 0.25, "gamma": 0.5}),
    "hangs": Integrator(),
    "squared": Integrator(arguments={"gamma": 0.6}),
    "cubic": Integrator(arguments={"a": 0.2, "b": 0.3}),
    "limited": Integrator(arguments={"gamma": 0.6}),
    "fixed": Integrator(),
}


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    if integrator == "dies":
        sys.exit(3)
    if integrator == "hangs":
        time.sleep(600)
    gamma = arguments.get("gamma", 0.5)
    beta = arguments.get("beta", (gamma + 0.5) ** 2 / 4)
    if integrator == "cubic":
        beta, gamma = (1 + arguments["a"]) ** 2 * arguments["b"], 0.5 + arguments["a"]
    if integrator == "limited" and gamma > 0.6:
        raise ValueError("gamma is at most 0.6")
    if integrator == "newmark":
        beta, gamma = gamma, beta
    print("words of the program")
    rows = [(u0, v0, load(0.0) - 2 * xi * omega * v0 - omega**2 * u0)]
    for i in range(n):
        u, v, a = rows[-1]
        p, q = u + dt * v + dt**2 * (0.5 - beta) * a, v + dt * (1 - gamma) * a
        z = load((i + 1) * dt) - 2 * xi * omega * q - omega**2 * p
        z /= 1 + 2 * xi * omega * gamma * dt + omega**2 * beta * dt**2
        rows.append((p + beta * dt**2 * z, q + gamma * dt * z, z))
    return zip(*rows)


serve("Planted", "1.0", "none", INTEGRATORS, run)
'''


@pytest.fixture
def planted(tmp_path, monkeypatch):
    """A program whose adapter is the text above."""
    shutil.copy(ADAPTERS / "adapter.py", tmp_path)
    (tmp_path / "planted_adapter.py").write_text(ADAPTER)
    monkeypatch.setattr(programs_module, "ADAPTERS", tmp_path)
    with Program("planted") as program:
        yield program


def test_a_program_is_audited_through_its_pipe(planted):
    (report,) = audit_program(planted, ["newmark"])
    assert report.stepper.name == "Planted newmark" and report.stepper.version == "1.0"
    assert report.matches[0].text == "newmark(beta = 11/20, gamma = 3/10)"
    assert report.loads.called == (0.0,)
    (cause,) = report.deviations
    assert cause.kind == "parameter" and "beta and gamma are exchanged" in cause.text
    assert '"first order" (page 2)' in report.text
    assert report.seconds is not None and 0.0 < report.seconds[1] <= planted.seconds
    here, there = report.to_dict()["seconds"]
    assert f"took       {here} s of CPU here and {there} s in the program" in report.text


BURNS = """
from adapter import Integrator, serve
import subprocess, sys, time

BURN = "import time\\nend = time.process_time() + 0.2\\nwhile time.process_time() < end: pass"


def run(integrator, arguments, omega, xi, dt, n, u0, v0, a0, load):
    exec(BURN, {})
    subprocess.run([sys.executable, "-c", BURN])
    return [u0] * (n + 1), None, None


serve("Burns", "1.0", "none", {"burns": Integrator(outputs="u", one_run=True)}, run)
"""


def test_the_time_of_each_process_of_a_program_is_counted_with_what_it_runs(tmp_path):
    (tmp_path / "burns.py").write_text(BURNS)
    with Program(str(tmp_path / "burns.py")) as program:
        run, before = program.stepper("burns").run, program.seconds
        for times in (1, 2):
            run(1.0, 0.0, 0.1, 2, 1.0, 0.0, load=programs_module.Load())
            assert 0.38 * times < program.seconds - before < 2.0 * times


@pytest.mark.thorough
def test_parameters_follow_from_arguments_by_identification(planted):
    assert find_dialect(planted, "newmark") == Dialect(
        "newmark", ("beta", "gamma"), {"beta": ((("gamma",), "1"),), "gamma": ((("beta",), "1"),)}
    )
    squared = find_dialect(planted, "squared")
    assert squared is not None
    assert squared.text == "newmark: beta = 1/4 gamma^2 + 1/4 gamma + 1/16, gamma = gamma"
    assert Dialect.from_plain(json.loads(json.dumps(to_plain({"x": squared})["x"]))) == squared
    assert float(squared.of(gamma=0.7).parameters["beta"]) == pytest.approx(0.36, abs=1e-15)
    others = {name: find_dialect(planted, name) for name in ("cubic", "limited", "fixed")}
    assert {name: found and found.text for name, found in others.items()} == {
        "cubic": "newmark: beta = a^2 b + 2 a b + b, gamma = a + 1/2",
        "limited": squared.text,
        "fixed": "newmark: beta = 1/4, gamma = 1/2",
    }


def test_what_goes_wrong_in_a_program_is_reported(planted):
    with pytest.raises(ValueError, match=r"the end of its process \(exit code 3\)"):
        planted.stepper("dies").run(1.0, 0.0, 0.1, 2, 1.0, 0.0, load=programs_module.Load())
    run = 1.0, 0.0, 0.1, 2, 1.0, 0.0
    assert planted.stepper("newmark").run(*run, load=programs_module.Load())[0][0] == 1.0  # by a new process
    planted.longest = 2.0
    with pytest.raises(ValueError, match=r"within 2 s, got the end of its process"):
        planted.stepper("hangs").run(*run, load=programs_module.Load())
    with pytest.raises(ValueError, match="expected the command of an interpreter, got 'no_python'"):
        Program("planted", "no_python")
    with pytest.raises(ValueError, match="expected an integrator of planted"):
        planted.stepper("newmrk")
    with pytest.raises(ValueError, match="expected an argument of newmark"):
        planted.stepper("newmark", {"alpha": 1.0})


@pytest.mark.thorough
def test_a_real_program_pyyeti():
    """Its Newmark starts from a zero acceleration; its other solvers are exact for a load that is linear in a step."""
    with Program("pyyeti") as program:
        newmark, unc = audit_program(program, ["SolveNewmark", "SolveUnc"])
    assert newmark.matches[0].text == "newmark(beta = 1/3, gamma = 1/2)"
    assert newmark.deviations[0].kind == "start"
    assert unc.identified == "exact, for a load linear over a step" and not unc.deviations


def test_a_real_program_scipy():
    """Its pair goes on with the value of order 5 and estimates the error of that of order 4, under any force."""
    with Program("scipy") as program:
        (report,) = audit_program(program, ["RK45"])
    assert report.matches[0].scheme.name == "dormand_prince" and not report.deviations
    assert report.found.nonlinear is not None and report.found.nonlinear < 1e-12
    control = report.control
    assert control is not None and control.power == pytest.approx(1.0, abs=0.1)
    assert control.orders == pytest.approx((5.0, 5.0), abs=0.5)
    assert control.estimated_orders == pytest.approx((4.0, 4.0), abs=0.5)


def test_every_program_with_an_adapter_has_a_committed_report():
    assert evidence.audited() == sorted(programs())


def test_the_page_and_the_table_are_those_of_the_reports():
    assert PAGE.read_text(encoding="utf-8") == page(ROOT / "audits")
    _, _, table = PAGE.read_text(encoding="utf-8").partition("## Every integrator")
    found, rows = {}, [line for line in table.splitlines() if line.startswith("| ")]
    for read in map(evidence.read, evidence.audited()):
        found |= read["dialects"]
        titled = [row for row in rows if row.startswith(f"| {read['program']} {read['version']} | ")]
        assert len(titled) == len(read["reports"]), "the page has one table, with a row for each integrator"
    assert json.loads(TABLE.read_text(encoding="utf-8")) == found
    text = CONVENTIONS.read_text(encoding="utf-8")
    assert conventions(text, dialects()) == text
    with pytest.raises(ValueError, match="expected the marks"):
        conventions("# Conventions\n", dialects())


# these cite a function: its lines are not those of the packaged version
UNNUMBERED = ("explicit_central_differences", "load_of_multi_stage")


@pytest.mark.parametrize(
    "script", sorted((ROOT / "audits").glob("*/*.py")), ids=lambda path: f"{path.parent.name}/{path.stem}"
)
def test_a_script_that_shows_a_deviation_needs_no_substep(script):
    """It says what it shows, cites where the source or manual was read, and its output is beside it."""
    tree = ast.parse(script.read_text(encoding="utf-8"))
    modules = {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    modules |= {str(node.module) for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert not any(name.startswith("substep") for name in modules)
    text = ast.get_docstring(tree) or ""
    assert "Source" in text or "Manual" in text
    assert re.search(r":\d+|\blines? \d+", text) or script.stem in UNNUMBERED
    output = script.with_suffix(".txt").read_text(encoding="utf-8")
    assert output.strip() and not re.search(r"(?:^|[ :])/\w+/", output)  # no path of the machine that ran it


CONCERNED = re.compile(r"Integrators, by their names in the report: (.+)\.\s*\Z", re.DOTALL)


def concerned(program: str) -> set[str]:
    """The integrators of a program that its scripts name in the last paragraph of their texts."""
    texts = [ast.get_docstring(ast.parse(path.read_text())) or "" for path in (ROOT / "audits" / program).glob("*.py")]
    found = [match[1] for text in texts if (match := CONCERNED.search(text))]
    return {name for names in found for name in names.replace("\n", " ").split(", ")}


@pytest.mark.parametrize("program", programs())
def test_every_deviation_of_a_report_is_shown_by_a_script(program):
    """What is held against a program can be seen without this package, but for digits, which its report counts."""
    reports = evidence.read(program)["reports"]
    kinds = {r["integrator"]: {deviation["kind"] for deviation in r["deviations"]} - {"precision"} for r in reports}
    named = concerned(program)
    assert named <= set(kinds), "scripts name integrators that the report does not have"
    assert {name for name, found in kinds.items() if found} <= named, "deviations that no script shows"


REFUSED = {"akantu.newmark_beta", "easyfea.hht_beyond_half"}  # with values that the declaration does not allow


@pytest.mark.parametrize("program", programs())
def test_dialects_step_as_the_reports_say(program):
    """With the arguments of a report, the converter's scheme moves as the identified one does."""
    at = Oscillators(np.array([0.3, 1.0, 1.7]), np.array([0.0, 0.05, 0.5]), 0.5)
    for report in evidence.read(program)["reports"]:
        name, found = f"{program}.{report['integrator']}", next(iter(report["matches"]), {})
        if name not in dialects() or "parameters" not in found:  # which older reports do not have
            continue
        given = {key: report["arguments"][key] for key in dialects()[name].arguments}
        if name in REFUSED:
            with pytest.raises(ValueError, match="expected parameter"):
                ss.dialect(name, **given)
            continue
        schemes = ss.dialect(name, **given), with_parameters(ss.scheme(found["scheme"]), found["parameters"])
        u = [Candidate(scheme, at).histories(np.array([1.0, 0.4]), None, 8)[..., 0] for scheme in schemes]
        np.testing.assert_allclose(*u, rtol=1e-9, atol=1e-12, err_msg=name)


def test_dialects_are_handles_of_declared_schemes():
    scheme = ss.dialect("opensees.HHT", alpha=0.9)
    assert scheme.name == "hht_alpha" and float(scheme.parameters["alpha"]) == pytest.approx(-0.1)
    for name, known in dialects().items():
        assert known.scheme in ss.schemes(), name
    with pytest.raises(ValueError, match=r"did you mean 'opensees.HHT'"):
        ss.dialect("opensees.HT", alpha=0.9)
    with pytest.raises(ValueError, match="expected the arguments alpha, got none for alpha"):
        ss.dialect("opensees.HHT")
    with pytest.raises(ValueError, match="expected an argument of the integrator"):
        ss.dialect("opensees.HHT", beta=0.9)
