"""Whatever parameters, coordinates and outputs are named, the kernels are right, or the name is refused."""

import ast
import keyword
import os
from collections.abc import Iterable
from functools import cache
from typing import Any

import numpy as np
import pytest
from declared import BY_NAME
from plain_kernels import SCENE_BY_NAME, text
from substep_derive import Balance, DeclarationError, Family, Parameter, Scene, Scheme, certify
from substep_derive.__main__ import GENERATED
from substep_derive.declare.scene import optional
from substep_derive.declare.symbols import h, knot, rate
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
VERIFY = bool(os.environ.get("SUBSTEP_VERIFY"))


@pytest.mark.usefixtures("plain_pairs")
@pytest.mark.parametrize(("what", "name"), [(what, name) for i, name in enumerate(SUSPECT)
                                            for k, what in enumerate(ROLES) if VERIFY or i % 3 == k])  # fmt: skip
def test_a_scene_is_right_or_refused_by_name(what: str, name: str) -> None:
    """The gate gives each name one of the three roles in turn; `make verify` gives it all of them."""
    given = {"parameter": (name, "q"), "coordinate": ("k", name), "output": ("k", "q", name)}[what]
    try:
        found = plain_motion(with_names(*given), with_a_parameter("kappa"))
    except DeclarationError as error:
        assert f"'{name}'" in str(error)
        assert "rename" in str(error)
        return
    for x, y in zip(found, usual(), strict=True):
        np.testing.assert_allclose(x, y, rtol=0, atol=1e-13)  # names decide the order of sums


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


# --- the check knows every name that kernels use


def in_scope(source: str, mine: set[str]) -> set[str]:
    """Names in the functions that take or unpack all of these."""
    found: set[str] = set()
    for function in ast.parse(source).body:
        if not isinstance(function, ast.FunctionDef):
            continue
        names = {node.id for node in ast.walk(function) if isinstance(node, ast.Name)}
        stored = {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
        arguments = {node.arg for node in ast.walk(function) if isinstance(node, ast.arg)}
        if mine <= stored | arguments or function.name == "stencil":
            found |= {function.name} | names | arguments
    return found


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


@pytest.mark.parametrize("name", [s.name for s in BY_NAME.values() if s.parent is None and s.parameters])
def test_names_of_a_schemes_module_are_refused(name: str) -> None:
    mine = {p.name for p in BY_NAME[name].parameters}
    used = in_scope((GENERATED / f"{name}.py").read_text(encoding="utf-8"), {"Omega", *mine})
    assert {"coefficients", "by", "den"} <= used
    assert accepted(with_a_parameter, used - mine) == []


@pytest.mark.parametrize("scene", SCENE_BY_NAME)
def test_names_of_a_scenes_modules_are_refused(scene: str) -> None:
    declared = SCENE_BY_NAME[scene]
    theirs = {p.name for p in declared.parameters}
    own = {str(s) for s in (*declared.coordinates, *declared.rates, *declared.invariants)} | set(declared.outputs)
    used = in_scope((GENERATED / f"scene_{scene}.py").read_text(encoding="utf-8"), theirs) - own
    for scheme in ("newmark", "newmark_bdf2", "energy_momentum", "kr_alpha", "generalized_alpha_mixed_displacement"):
        mine = {p.name for p in BY_NAME[scheme].parameters}
        found = in_scope(text(scheme, scene), theirs) | in_scope(text(scheme, scene), {"h"})
        assert {"h", "state", "energy"} <= found
        assert accepted(with_a_parameter, found - mine - theirs) == []
        used |= found - mine
    assert accepted(lambda name: with_names(name, "q"), used - theirs) == []


def test_keywords_are_refused() -> None:
    assert accepted(with_a_parameter, keyword.kwlist) == []
    assert accepted(lambda name: with_names(name, "q"), keyword.kwlist) == []
    assert accepted(lambda name: with_names("k", name), keyword.kwlist) == []
