"""Whatever parameters, coordinates and outputs are named, the kernels are right, or the name is refused."""

import ast
import inspect
import keyword
from collections.abc import Iterable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME, OWN, TOGETHER
from plain_kernels import SCENE_BY_NAME, text
from substep_derive import (
    Balance,
    DeclarationError,
    Family,
    Parameter,
    Scene,
    Scheme,
    certify,
    derive,
    estimator,
    impact,
)
from substep_derive.__main__ import GENERATED
from substep_derive.declare.scene import optional
from substep_derive.declare.symbols import h, knot, rate
from substep_derive.emit.first_use import own_plan
from substep_languages.standalone import standalone
from sympy import Interval, Rational, Symbol

import substep as ss
from substep.marching.scene_lanes import march_lanes

Array = np.ndarray
u0, v0, a0 = knot(0)
u1, v1, a1 = knot(1)


def with_a_parameter(name: str) -> Scheme:
    """Newmark's relations with its gamma under another name."""
    c = Symbol(name)
    return Scheme(
        "mine",
        {u1: u0 + h * v0 + h**2 * ((1 - c**2) / 2 * a0 + c**2 / 2 * a1), v1: v0 + h * ((1 - c) * a0 + c * a1)},
        (Balance.at(knot(1), 1),),
        (Parameter(c, Interval(0, 2), Rational(3, 5)),),
    )


def with_names(stiffness: str, coordinate: str, output: str = "stretch") -> Scene:
    """Duffing's oscillator with two coordinates, under these names."""
    k, q, other = map(Symbol, (stiffness, coordinate, "other"))
    return Scene(
        name="mine",
        coordinates={q: "m", other: "m"},
        kinetic=(rate(q) ** 2 + rate(other) ** 2) / 2,
        potential=k * q**2 / 2 + k * q**4 / 4 + k * (other - q) ** 2 / 2,
        parameters=(optional(k, 3),),
        start={q: 1, other: Rational(1, 2), rate(q): 0, rate(other): 0},
        length=1,
        outputs={output: other - q},
    )


SUSPECT = [
    *(
        "lambda",
        "in",
        "None",
        "np",
        "njit",
        "math",
        "velocity",
        "displacement",
        "t",
        "f",
        "value",
        "value_0",
        "x0",
        "h",
        "i",
    ),
    *(
        "j",
        "n",
        "u",
        "v",
        "a",
        "r",
        "z",
        "mu",
        "M",
        "C",
        "K0",
        "K_t",
        "omega",
        "Omega",
        "state",
        "tolerance",
        "c0",
        "near_0",
    ),
    *(
        "abs",
        "range",
        "max",
        "min",
        "float",
        "COMPLETED",
        "WIDTH",
        "march",
        "start",
        "_lane",
        "_",
        "__debug__",
        "a b",
        "x.y",
    ),
    *(
        "*",
        "½",
        "",
        "ﬁ",
        "β",
        "a0",
        "load",
        "name",
        "dt",
        "E_",
        "E",
        "q_dot",
        "q_j",
        "total",
        "kappa",
        "value_",
        "energy",
    ),
    *("D00", "D_1_11", "one", "u_star", "u_0", "r_q", "f_0", "jacobian_00", "K0_00", "change_0", "done", "sqrt"),
]


@cache
def usual() -> tuple[Array, Array, Array]:
    """The motion under names that nobody would take."""
    return plain_motion(with_names("k", "q"), with_a_parameter("kappa"))


def plain_motion(scene: Scene, scheme: Scheme) -> tuple[Array, Array, Array]:
    s, model = ss.scheme(scheme), ss.scene(scene)
    found = march_lanes(model, s, np.array([0.1]), np.array([8]), history=True)
    u, v = found.out[0, :, 0], found.out[0, :, 1]
    (output,) = model.outputs(np.zeros(9), u, v).values()
    return u, model.energy(np.zeros(9), u, v), output


ROLES = ("parameter", "coordinate", "output")


@pytest.mark.matrix
@pytest.mark.usefixtures("plain_pairs")
@pytest.mark.parametrize("name", SUSPECT)
@pytest.mark.parametrize("what", ROLES)
def test_a_scene_is_right_or_refused_by_name(what: str, name: str) -> None:
    given = {"parameter": (name, "q"), "coordinate": ("k", name), "output": ("k", "q", name)}[what]
    try:
        found = plain_motion(with_names(*given), with_a_parameter("kappa"))
    except DeclarationError as error:
        assert f"'{name}'" in str(error)
        assert "rename" in str(error)
        return
    for x, y in zip(found, usual(), strict=True):
        np.testing.assert_allclose(x, y, rtol=0, atol=1e-13)  # names decide the order of sums


@pytest.mark.matrix
@pytest.mark.usefixtures("plain_pairs")
@pytest.mark.parametrize("name", SUSPECT)
def test_a_scheme_is_right_or_refused_by_name(name: str) -> None:
    try:
        scheme = with_a_parameter(name)
    except DeclarationError as error:
        assert f"'{name}'" in str(error)
        return
    for x, y in zip(plain_motion(with_names("k", "q"), scheme), usual(), strict=True):
        np.testing.assert_allclose(x, y, rtol=0, atol=1e-13)
    assert float(certify(scheme, **{name: "3/5"}).critical_Omega) == pytest.approx(
        1 / 0.12**0.5
    )  # 1/sqrt(gamma/2 - beta)


def test_what_a_user_would_call_a_parameter_is_accepted() -> None:
    for name in ("kappa", "β", "alpha_1", "rho_b", "damping_ratio", "lam", "E1_soft", "gamma2"):
        assert with_a_parameter(name).values == (Symbol(name),)
    for name in ("k", "EA", "L", "m", "v0", "u0", "mu", "E", "k1", "kappa"):
        assert with_names(name, "q").parameters[0].name == name


@pytest.mark.parametrize(
    ("declare", "name"),
    [
        (lambda: Scheme("my scheme", {}, ()), "my scheme"),
        (lambda: Scheme("lambda", {}, ()), "lambda"),
    ],
)
def test_other_names_are_refused(declare: Any, name: str) -> None:
    with pytest.raises(DeclarationError, match="rename") as raised:
        declare()
    assert f"'{name}'" in str(raised.value)


def test_a_name_is_given_once() -> None:
    c, rho = Symbol("kappa"), Symbol("rho_inf")
    twice = (Parameter(c, Interval(0, 1), Rational(1)),) * 2
    families = (Family(Parameter(c, Interval(0, 1), Rational(1)), {c: c}),)
    relations = {u1: u0 + h * v0 + c * h**2 * a1, v1: v0 + h * a1}
    for parameters, family in ((twice, ()), (twice[:1], families)):
        with pytest.raises(DeclarationError, match="'kappa' twice"):
            Scheme("mine", relations, (Balance.at(knot(1), 1),), parameters, family)
    with pytest.raises(DeclarationError, match="'q_dot' twice"):
        with_names("q_dot", "q")
    with pytest.raises(DeclarationError, match=r"take it from knot\('1'\)"):
        Scheme("mine", {Symbol("u_1", real=True): u0 + h * v0, v1: v0 + h * rho * a1}, (Balance.at(knot(1), 1),))


# --- no name of a kernel's own is like a parameter's


def ours(source: str, theirs: set[str]) -> set[str]:
    """All names in the text but for those of parameters."""
    found: set[str] = set()
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Name):
            found.add(node.id)
        elif isinstance(node, ast.arg):
            found.add(node.arg)
        elif isinstance(node, ast.FunctionDef):
            found.add(node.name)
    return found - theirs


def assert_apart(source: str, parameters: Iterable[Any], *, all_used: bool = True) -> None:
    """Every parameter is printed with an underscore at its end, and nothing else is but coordinates."""
    theirs = {f"{p.name}_" for p in parameters}
    names = ours(source, set())
    assert not any(name.endswith("_") for name in names - theirs)
    assert theirs <= names or not all_used
    assert not names & {p.name for p in parameters}


@pytest.mark.parametrize("name", OWN)
def test_parameters_are_apart_in_the_module_and_the_plan_of_a_scheme(name: str) -> None:
    module = Path(ss.scheme(name).kernels.__file__ or "").read_text(encoding="utf-8")
    assert_apart(module.partition("\n\nENTRY = ")[0], BY_NAME[name].parameters)
    if name not in TOGETHER:  # which have no plan
        assert_apart(own_plan(BY_NAME[name]), BY_NAME[name].parameters)


@pytest.mark.parametrize("scene", SCENE_BY_NAME)
def test_parameters_are_apart_in_a_scenes_modules(scene: str) -> None:
    declared = SCENE_BY_NAME[scene]
    coordinates = {f"{s}_" for s in (*declared.coordinates, *declared.rates)}
    for function in ast.parse((GENERATED / f"scenes/{scene}.py").read_text(encoding="utf-8")).body:
        if isinstance(function, ast.FunctionDef) and not function.name.startswith("_"):
            names = ours(ast.unparse(function), coordinates)
            assert {name for name in names if name.endswith("_")} == {f"{p.name}_" for p in declared.parameters}
    for scheme in ("newmark_bdf2", "kr_alpha"):
        both = (*BY_NAME[scheme].parameters, *declared.parameters)
        assert_apart(text(scheme, scene), both, all_used=False)


# what the march in chosen steps calls its own numbers, and what the estimate's functions are called with
OF_CHOSEN_STEPS = (
    *(
        "weight_0",
        "weight_4",
        "length",
        "power",
        "atol_u",
        "atol_v",
        "share_v",
        "t_last",
        "factor_0",
        "proposed",
        "held",
    ),
    *("before", "last", "size", "fast", "floor", "part", "accepted", "targets", "times", "low", "made", "known"),
)


@pytest.mark.matrix
@pytest.mark.usefixtures("plain_adaptive")
@pytest.mark.parametrize("name", OF_CHOSEN_STEPS)
def test_a_march_in_chosen_steps_is_right_whatever_parameters_are_called(name: str) -> None:
    def end(scene: Scene, scheme: Scheme) -> Array:
        return ss.march(ss.scene(scene), ss.scheme(scheme), tol=1e-3, t_end=1.0).u[-1]

    expected = end(with_names("k", "q"), with_a_parameter("kappa"))
    for scene, scheme in (
        (with_names(name, "q"), with_a_parameter("kappa")),
        (with_names("k", "q"), with_a_parameter(name)),
    ):
        np.testing.assert_allclose(end(scene, scheme), expected, rtol=0, atol=1e-13)


def test_an_option_of_a_function_that_takes_parameters_is_no_parameter() -> None:
    """Their keyword arguments, by inspection of all public functions."""
    for function in (ss.scheme, ss.scene, ss.sweep, derive, certify, estimator, impact):
        parameters = inspect.signature(function).parameters.values()
        options = [p.name for p in parameters if p.kind in (p.POSITIONAL_OR_KEYWORD, p.KEYWORD_ONLY)]
        assert accepted(with_a_parameter, options) == []
    assert accepted(with_a_parameter, ["language"]) == ["language"]
    assert "language" in standalone(with_a_parameter("language"), "python", language="3/5")


def accepted(declare: Any, names: Iterable[str]) -> list[str]:
    """Those of the names that may be declared after all."""
    found = []
    for name in sorted(names):
        try:
            declare(name)
            found.append(name)
        except DeclarationError:
            pass
    return found


def test_keywords_are_refused() -> None:
    assert accepted(with_a_parameter, keyword.kwlist) == []
    assert accepted(lambda name: with_names(name, "q"), keyword.kwlist) == []
    assert accepted(lambda name: with_names("k", name), keyword.kwlist) == []
