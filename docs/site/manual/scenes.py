"""A page for each scene of the catalogue: declaration, equation of motion, invariants, parameters, motion."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

from substep_derive.declare import scenes as declared
from substep_derive.declare.catalogue import find_scene
from substep_derive.declare.scene import Scene
from substep_derive.declare.symbols import acceleration, rate, sampled, t
from substep_derive.motion.equations import EquationsOfMotion
from sympy import Expr, Function, Matrix, Symbol, latex

import substep as ss

from . import charts
from .declarations import declaration
from .markdown import block, formula, plain, table, toctree


def pages() -> dict[str, Callable[[Path], str]]:
    """Name of a page -> its text."""
    own = {f"scenes/{name}": partial(page, name) for name in ss.scenes()}
    return {"scenes/index": lambda _: index(), **own}


def index() -> str:
    """The table of the scenes."""
    rows = []
    for name in ss.scenes():
        scene = find_scene(name)
        coordinates = ", ".join(f"{q} ({unit})" for q, unit in scene.coordinates.items())
        rows.append([f"[{name}]({name}.md)", plain(coordinates), plain(scene.reference)])
    lines = ["# Scenes", "", "Benchmark problems, each declared by its energies.", ""]
    return "\n".join([*lines, *table(["scene", "coordinates", "from"], rows), *toctree(ss.scenes())])


def page(name: str, folder: Path) -> str:
    """The text of one scene's page; its chart is put into the folder."""
    scene = find_scene(name)
    figure, drawn, title = charts.motion(name)
    figure.savefig(folder / f"{name}.svg", metadata={"Date": None})
    path, source = declaration(scene, declared)
    given = ", ".join(f"{key} = {value:.7g}" for key, value in drawn.scene.parameters.items())
    lines = [f"# {name}", "", plain(scene.reference[0].upper() + scene.reference[1:]) + ".", ""]
    lines += [f"![Motion of {name}]({name}.svg)", "", plain(f"{title}: {drawn.source}, with {given}."), ""]
    lines += ["## Declaration", "", f"In `{path}`; what is not defined here is imported there.", ""]
    lines += [*block("python", source), *_parameters(scene), *_motion(scene)]
    return "\n".join(lines) + "\n"


def _parameters(scene: Scene) -> Iterator[str]:
    rows = []
    for p in scene.parameters:
        default = "to be given" if p.default is None else f"{float(p.default):.16g}"
        rows.append([f"`{p.name}`", f"${latex(p.domain)}$", default])
    yield from ["## Parameters", "", *table(["parameter", "lies in", "default"], rows)]


def _motion(scene: Scene) -> Iterator[str]:
    derived = EquationsOfMotion(scene)
    q = derived.coordinates
    a, v = (Matrix([make(x) for x in q]) for make in (acceleration, rate))
    of_rates = " + F(u, v)" if derived.of_rates else ""
    yield from ["## What is derived", "", f"Equation of motion, M a + C v + N(u){of_rates} = f:", ""]
    left = f"{_latex(derived.mass)} {_latex(a)}"
    if not derived.damping.is_zero_matrix:
        left += f" + {_latex(derived.damping)} {_latex(v)}"
    forces = " + ".join(map(_latex, (derived.force(q), *([derived.rate_force] if derived.of_rates else []))))
    yield from _formula(f"{left} + {forces} = {_latex(derived.load)}")
    yield from ["Tangent stiffness:", "", *_formula(_latex(derived.tangent(q)))]
    yield from ["Energy:", "", *_formula(_latex(derived.energy))]
    if derived.angular_momentum is not None:
        yield from ["Angular momentum:", "", *_formula(_latex(derived.angular_momentum))]
    for name, output in derived.outputs.items():
        yield from [f"The output `{name}`:", "", *_formula(_latex(output))]


def _formula(text: str) -> list[str]:
    return formula(text, "it is too long to be read")


def _latex(e: Expr | Matrix) -> str:
    """LaTeX with a dot for each derivative, and a load that the user gives as f(t)."""
    dots = {}
    for symbol in e.free_symbols:
        for suffix, mark in (("_ddot", "ddot"), ("_dot", "dot")):
            if symbol.name.endswith(suffix):
                dots[symbol] = rf"\{mark}{{{latex(Symbol(symbol.name.removesuffix(suffix)))}}}"
                break
    return latex(e.subs(sampled, Function("f")(t)), symbol_names=dots, mat_delim="[")
