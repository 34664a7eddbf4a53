"""Files that `substep emit` prints: compiled or interpreted, and compared with kernels and steps written by hand."""

import json
import math
import re
import shutil
import subprocess
import sys
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import tree_sitter_julia
from by_hand import single
from declared import ONE_BY_ONE, UNDAMPED
from nonlinear_oracle import System, history
from substep_derive import Parameter, Scheme, h, knot
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.scheme import Balance
from substep_languages.languages import LANGUAGES
from substep_languages.standalone import standalone
from sympy import Interval, Rational, Symbol
from test_pairs import PARAMETERS
from tree_sitter import Language, Parser
from typer.testing import CliRunner

import substep as ss
from substep.cli.commands import app

# between them every shape of a file: another scheme that starts, an own start, the stiffness at the start, a discrete
# gradient, no damping, no parameters, an irrational default, six eigenvalues, a parameter named as one of C's functions
SHAPES = ("park", "gholampour", "kr_alpha", "energy_momentum", "rkn43", "average_acceleration", "oalts", "sdirk2")
OMEGA, XI = (1e-3, 0.1, 0.5, 1.3, 3.0, 10.0), (0.0, 0.05)
STEP, STEPS, START = 0.1, 12, (1.0, -0.5)
EPS = np.finfo(np.float64).eps
ROUNDING = 1e-12  # of the largest value, as in test_pairs

C_DRIVER = """
#define SUBSTEP_NO_MAIN
#include "{file}"
static double force(double u, const Problem *q) {{ return 4.0*u + 9.0*u*u*u; }}
static double slope(double u, const Problem *q) {{ return 4.0 + 27.0*u*u; }}
static double load(double t, const Problem *q) {{ return cos(2.0*t); }}
static double gradient(double u, double w, const Problem *q)
{{ return 2.0*(u + w) + 2.25*(u + w)*(u*u + w*w); }}
static double gradient_slope(double u, double w, const Problem *q)
{{ return 2.0 + 2.25*(u*u + w*w + 2.0*w*(u + w)); }}
static void number(double x) {{ if (isfinite(x)) printf("%.17g", x); else printf("null"); }}
int main(void)
{{
    const double Omega[] = {{ {Omega} }}, xi[] = {{ {xi} }};
    double rows[{steps} + 1][3], found[3];
    Parameters values = DEFAULTS;
    {set}
    Problem problem = oscillator(1.0, {damping}, slope({u0}, 0), load);
    problem.force = force, problem.slope = slope;
    {gradient}
    const int done = march(&problem, &values, {h}, {steps}, {u0}, {v0}, rows);
    printf("{{\\"done\\": %d, \\"rows\\": [", done);
    for (int i = 0; i <= done; i++)
        for (int j = 0; j < 3; j++)
            printf("%s%.17g", i + j ? ", " : "", rows[i][j]);
    printf("], \\"stability\\": [");
    for (unsigned i = 0; i < sizeof Omega / sizeof *Omega; i++)
        for (unsigned j = 0; j < sizeof xi / sizeof *xi; j++) {{
            stability(Omega[i], xi[j], &values, &found[0], &found[1], &found[2]);
            for (int k = 0; k < 3; k++) {{ if (i + j + k) printf(", "); number(found[k]); }}
        }}
    printf("]}}\\n");
    return self_test();
}}
"""
JS_DRIVER = """
const scheme = require("{file}");
const problem = {{
    mass: 1, damping: {damping}, stiffness: 4 + 27*{u0}**2, length: 1, load: (t) => Math.cos(2*t),
    force: (u) => 4*u + 9*u**3, slope: (u) => 4 + 27*u*u,
    gradient: (u, w) => 2*(u + w) + 2.25*(u + w)*(u*u + w*w),
    gradient_slope: (u, w) => 2 + 2.25*(u*u + w*w + 2*w*(u + w)),
}};
const values = {{ ...scheme.DEFAULTS }};
{set}
const rows = scheme.march(problem, {h}, {steps}, {u0}, {v0}, values);
const points = [{Omega}].flatMap((Omega) => [{xi}].map((xi) => scheme.stability(Omega, xi, values)));
console.log(JSON.stringify({{
    done: rows.length - 1, rows: rows.flat(), stability: points.flatMap((p) => [p.radius, p.damping, p.period]),
}}));
process.exitCode = scheme.self_test() ? 0 : 1;
"""


@cache
def text_of(scheme: str, language: str) -> str:
    """The file of a scheme."""
    return standalone(scheme, language)


def compiler(name: str) -> str:
    """The path of a compiler or interpreter; the test is skipped where there is none."""
    path = shutil.which(name)
    if path is None:
        pytest.skip(f"needs {name}, which is not installed here")
    return path


def run(*command: object, folder: Path) -> subprocess.CompletedProcess[str]:
    words = [str(x) for x in command]
    return subprocess.run(words, cwd=folder, capture_output=True, text=True, timeout=100, check=False)


def driver(template: str, file: str, scheme: str, values: Mapping[str, float], text: str) -> str:
    """A program that marches a driven Duffing oscillator and prints this and the stability functions."""
    taken = {name: x for name, x in values.items() if f" {name}" in text}
    return template.format(
        file=file, Omega=", ".join(map(repr, OMEGA)), xi=", ".join(map(repr, XI)), h=STEP, steps=STEPS, u0=START[0],
        v0=START[1], damping=0.0 if scheme in UNDAMPED else 0.3,
        set=" ".join(f"values.{name} = {x!r};" for name, x in taken.items()),
        gradient="problem.gradient = gradient, problem.gradient_slope = gradient_slope;"
        if "linear_gradient" in text else "",
    )  # fmt: skip


def check(scheme: str, result: subprocess.CompletedProcess[str]) -> None:
    """What the program printed, against the oracle's steps and the kernels' stability functions."""
    assert result.returncode == 0, result.stdout + result.stderr
    first, last = result.stdout.splitlines()
    assert f"{scheme}: passed" in last
    found: dict[str, Any] = json.loads(first)
    assert found["done"] == STEPS
    s = ss.scheme(scheme, **PARAMETERS.get(scheme, {}))
    expected = np.array(steps(scheme, s))[:, :, 0].T
    rows = np.array(found["rows"]).reshape(-1, 3)
    assert (np.abs(rows - expected) <= ROUNDING * np.abs(expected).max(axis=0)).all()
    numbers = np.array(found["stability"], dtype=float).reshape(len(OMEGA), len(XI), 3)
    for i, Omega in enumerate(OMEGA):
        for j, xi in enumerate(XI):
            check_stability(s, Omega, xi, numbers[i, j])


def steps(scheme: str, s: ss.Scheme) -> tuple[np.ndarray, ...]:
    """u, v and a of the driven Duffing oscillator, stepped by hand."""
    system: System = single(
        lambda u: 4.0 * u + 9.0 * u**3,
        lambda u: 4.0 + 27.0 * u**2,
        lambda u, w: 2.0 * (u + w) + 2.25 * (u + w) * (u * u + w * w),
        damping=0.0 if scheme in UNDAMPED else 0.3,
        load=lambda t: np.cos(2.0 * t),
    )
    u0, v0 = (np.array([x]) for x in START)
    values = {key: float(value) for key, value in s.parameters.items()}
    return history(scheme, values, system, STEP, STEPS, u0, v0, system.acceleration(u0, v0, 0.0))


def check_stability(s: ss.Scheme, Omega: float, xi: float, found: np.ndarray) -> None:
    """Within 100 times the rounding, times the condition of the root; rho far from double roots to 1e-12 of itself."""
    with np.errstate(all="ignore"):  # kernels as plain Python functions warn where compiled ones do not
        expected = np.array(s.stability(Omega, xi))
    if s.name in UNDAMPED and xi > 0.0:
        assert np.isnan(found).all()
        return
    mu = np.linalg.eigvals(s.amplification(Omega, xi)) - 1.0
    for kind, own in enumerate(expected):
        rooted = mu if kind == 0 else mu[mu.imag > 1e-7 * np.abs(mu)]
        if not rooted.size or np.isnan(own):
            continue
        at = rooted[np.argmax(np.abs(1.0 + rooted))]
        others = mu[np.abs(mu - at) > 0.0]
        condition = 2.0 * abs(at) * np.prod((abs(at) + np.abs(others)) / np.abs(at - others))
        size, angle = abs(1.0 + at), abs(np.angle(1.0 + at))
        scale = 1.0 if kind == 0 else (1.0, Omega / angle)[kind - 1] / (size * angle)
        allowed = 100 * EPS * (1.0 + abs(own) + condition * scale)
        if kind == 0 and 100 * EPS * condition < 1e-12:
            allowed = min(allowed, 1e-12 * own)
        assert abs(found[kind] - own) <= max(allowed, math.sqrt(EPS) * (condition > 1e6)), (Omega, xi, kind)


@pytest.mark.usefixtures("plain_functions")
@pytest.mark.parametrize("scheme", [s.name for s in ONE_BY_ONE])
def test_c_javascript_and_the_syntax_of_julia(scheme: str, tmp_path: Path) -> None:
    """All in one test, so that a scheme is derived once."""
    assert faults_in_julia(text_of(scheme, "julia")) == []
    given = PARAMETERS.get(scheme, {})
    if shutil.which("gcc"):
        text = text_of(scheme, "c")
        (tmp_path / "scheme.c").write_text(text, encoding="utf-8")
        (tmp_path / "main.c").write_text(driver(C_DRIVER, "scheme.c", scheme, given, text), encoding="utf-8")
        strict = ("-std=c99", "-Wall", "-Werror", "-Wno-unused-function")
        done = run("gcc", *strict, "main.c", "-o", "main", "-lm", folder=tmp_path)
        assert done.returncode == 0, done.stderr
        check(scheme, run("./main", folder=tmp_path))
    if shutil.which("node"):
        text = text_of(scheme, "javascript")
        (tmp_path / "scheme.js").write_text(text, encoding="utf-8")
        main = driver(JS_DRIVER, "./scheme.js", scheme, given, text)
        check(scheme, run("node", "-e", main, folder=tmp_path))
    compiler("gcc")
    compiler("node")


def faults_in_julia(text: str) -> list[str]:
    """The lines that are no Julia, or lack something; of its syntax alone, since no interpreter need be there."""
    found, open_nodes = [], [Parser(Language(tree_sitter_julia.language())).parse(text.encode()).root_node]
    while open_nodes:
        node = open_nodes.pop()
        open_nodes += node.children
        if node.is_error or node.is_missing:
            found.append(text.splitlines()[node.start_point.row])
    return found


def test_a_fault_in_julia_is_found() -> None:
    text = text_of("average_acceleration", "julia")
    assert faults_in_julia(text.replace("\nend\n", "\n", 1))  # a function without an end
    assert faults_in_julia(text.replace("mass * ", "mass ", 1).replace("a_1 .* mass", "a_1 mass", 1))


def self_tests(language: str, files: Mapping[str, str], folder: Path) -> list[str]:
    """What the files print about themselves, each name with its text, run as a user would."""
    suffix = LANGUAGES[language].suffix
    for name, text in files.items():
        (folder / f"{name}.{suffix}").write_text(text, encoding="utf-8")
    printed: list[str] = []
    if language == "matlab":  # one interpreter for all of them, since it takes long to begin
        code = " ".join(f"s = {name}(); s.self_test();" for name in files)
        return run(compiler("octave"), "--no-gui", "--quiet", "--eval", code, folder=folder).stdout.splitlines()
    for name in files:
        file = f"{name}.{suffix}"
        if language in ("c", "fortran"):
            program = compiler("gcc" if language == "c" else "gfortran")
            made = run(program, "-O0", file, "-o", name, "-lm", folder=folder)
            assert made.returncode == 0, made.stderr
            command = (f"./{name}",)
        else:
            interpreter = {"javascript": "node", "julia": "julia", "python": sys.executable}[language]
            command = (compiler(interpreter), file)
        result = run(*command, folder=folder)
        assert result.returncode == ("FAILED" in result.stdout), result.stderr
        printed += result.stdout.splitlines()
    return printed


@pytest.mark.matrix
@pytest.mark.parametrize("language", LANGUAGES)
def test_every_shape_of_a_file_passes_its_own_test(language: str, tmp_path: Path) -> None:
    lines = self_tests(language, {name: text_of(name, language) for name in SHAPES}, tmp_path)
    assert [line.split(";")[0] for line in lines] == [f"{name}: passed" for name in SHAPES]


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_wrong_number_fails_the_test_of_the_file(language: str, tmp_path: Path) -> None:
    text = text_of("average_acceleration", language)
    begin, end = text.index("balance_1("), text.index("self_test", text.index("stability("))
    wrong = text[:begin] + re.sub(r"(a_1 ?\.?\* ?mass)", r"1.001*\1", text[begin:end]) + text[end:]
    assert wrong != text
    lines = self_tests(language, {"average_acceleration": wrong}, tmp_path)
    assert lines[0].startswith("average_acceleration: FAILED")


def colliding() -> Scheme:
    """The average acceleration, its parameters and a knot named as what programs have themselves."""
    problem, function, rows = (Symbol(name) for name in ("problem", "function", "Rows"))
    quarter = {problem: 4, function: 2, rows: 1}
    old, new, middle = knot(0), knot(1), knot("G")
    parameters = tuple(Parameter(s, Interval(1, 5), Rational(value)) for s, value in quarter.items())
    return Scheme(
        "colliding",
        relations={
            new.u: old.u + h * old.v + h**2 * (old.a + new.a) / problem,
            new.v: old.v + h * rows * (old.a + new.a) / function,
            middle.u: (old.u + new.u) / 2, middle.v: (old.v + new.v) / 2, middle.a: (old.a + new.a) / 2,
        },
        balances=(Balance.at(new, 1),),
        parameters=parameters,
    )  # fmt: skip


@pytest.mark.parametrize("language", LANGUAGES)
def test_names_that_a_program_has_itself_are_changed(language: str, tmp_path: Path) -> None:
    lines = self_tests(language, {"colliding": standalone(colliding(), language)}, tmp_path)
    assert lines[0].startswith("colliding: passed")


def test_given_parameters_are_the_defaults_of_the_file(tmp_path: Path) -> None:
    text = standalone("newmark", "python", beta="3/10", gamma="0.6")
    space: dict[str, Any] = {"__name__": "newmark"}
    exec(compile(text, "newmark.py", "exec"), space)
    values = space["Parameters"]()
    assert (values.beta, values.gamma) == (0.3, 0.6)
    assert space["self_test"]()
    expected = ss.scheme("newmark", beta=0.3, gamma=0.6).spectral_radius(2.0, 0.05)
    assert space["stability"](2.0, 0.05)[0] == pytest.approx(float(expected), rel=1e-14)
    assert math.isnan(space["stability"](2.0, 0.05, space["Parameters"](beta=-1.0))[0])
    with pytest.raises(ValueError, match="outside its interval"):
        space["march"](space["oscillator"](1.0, 0.0, 1.0), 0.1, 1, 1.0, 0.0, space["Parameters"](beta=-1.0))


def test_a_family_gives_the_parameters_that_belong_to_its_argument() -> None:
    space: dict[str, Any] = {"__name__": "generalized_alpha"}
    exec(compile(text_of("generalized_alpha", "python"), "file", "exec"), space)
    values = space["Parameters"].of_rho_inf(0.5)
    expected = ss.scheme("generalized_alpha", rho_inf=0.5).parameters
    assert {name: getattr(values, name) for name in expected} == pytest.approx(
        {k: float(x) for k, x in expected.items()}
    )


def test_wrong_requests_say_what_is_right() -> None:
    with pytest.raises(ValueError, match="expected a language out of c, fortran, .* got 'cobol'"):
        standalone("newmark", "cobol")
    with pytest.raises(DeclarationError, match="no parameter 'alpha'"):
        standalone("newmark", "c", alpha=1)
    with pytest.raises(DeclarationError, match="lies outside"):
        standalone("newmark", "c", beta=-1)


def test_the_command_prints_a_declaration_of_ones_own(tmp_path: Path) -> None:
    file = tmp_path / "mine.py"
    file.write_text(
        "from substep_derive import Balance, Scheme, h, knot\n"
        "old, new = knot(0), knot(1)\n"
        "relations = {new.v: old.v + h*new.a, new.u: old.u + h*new.v}\n"
        'implicit = Scheme("implicit", relations=relations, balances=(Balance.at(new, 1),))\n'
    )
    runner = CliRunner()
    arguments = ["emit", f"{file}:implicit", "--language", "python", "-o", str(tmp_path / "implicit.py")]
    result = runner.invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert result.stdout.replace("\n", "") == str(tmp_path / "implicit.py")
    assert run(sys.executable, "implicit.py", folder=tmp_path).stdout.startswith("implicit: passed")
    for wrong, message in (
        ([f"{file}:explicit", "--language", "c"], "it declares: implicit"),
        ([f"{tmp_path}/none.py:implicit", "--language", "c"], "which is not there"),
        (["newmark", "--language", "c", "--out", str(tmp_path / "none" / "newmark.c")], "make it first"),
        (["newmark", "--language", "fortran", "--out", str(tmp_path / "newmark.f90")], "newmark.F90"),
        (["newmark", "--language", "cobol", "--out", str(tmp_path / "newmark.cob")], "got 'cobol'"),
    ):
        result = runner.invoke(app, ["emit", *wrong], env={"COLUMNS": "400"})
        assert result.exit_code == 2
        assert message in result.output
