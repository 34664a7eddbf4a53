"""Structures: a linear march beside the solves that it cannot do without, many right sides at once, and solvers."""

import ctypes
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from importlib.util import find_spec
from multiprocessing import get_context
from typing import Any

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

import substep as ss
from substep.structures.examples import cantilever, plate, solid
from substep.structures.model.given import loads_of
from substep.structures.solvers import factorization
from substep.structures.solvers.combine import add_product, combined
from substep.structures.solvers.matrices import combination

from .job import Job, Table
from .peers_structures import opensees_solid
from .timing import Alternative, Kind, Measured, cores, measure

NAME = "structures"
RAYLEIGH = ss.Rayleigh(1.0, 1e-6)
FORCE = ss.Harmonic(1.0, 1e3)
STEP = 1e-4
SIDES = 16
MARCHED = 20  # steps of a run that is timed beside OpenSees
LEAST = "the least of a step"  # besides the solve a product with M, and new u, v, a from the old ones and the solution


class Kept:
    """A solver that factorizes each matrix once, however many marches ask for it, and notes which of them solve."""

    def __init__(self) -> None:
        self.known: dict[tuple[float, ...], Callable[[Any], Any]] = {}
        self.asked: list[tuple[float, ...]] = []

    def __call__(self, matrix: Any) -> Callable[[Any], Any]:
        """The factorization."""
        key = (matrix.nnz, float(matrix.data.sum()), float(matrix.data[::7].sum()))
        if key not in self.known:
            self.known[key] = factorization.pardiso(matrix)

        def solve(b: Any) -> Any:
            self.asked.append(key)
            return self.known[key](b)

        return solve

    def of_a_step(self, solves: int) -> list[Callable[[Any], Any]]:
        """What the last `solves` solutions were computed with."""
        return [self.known[key] for key in self.asked[-solves:]]


def job(quick: bool) -> Job:
    """One core; 3-D elasticity of 3630 and 26460 degrees of freedom, in full 95232, a plate and a beam."""
    found = Job(NAME, "Structures: a march beside bare solves, and solvers, one core")
    if not (find_spec("skfem") and find_spec("pypardiso")):
        found.skipped["all"] = "scikit-fem or pypardiso is not installed; pip install 'substep[structures,fem]'"
        return found
    with cores(1):
        _one_thread()
        rounds = 5 if quick else 11
        _march(found, "solid", lambda kept: _solid(10, kept), 60 if quick else 200, rounds, 1.15)
        _march(found, "solid", lambda kept: _solid(20, kept), 4 if quick else 20, rounds, 1.05)
        _march(found, "solid, lumped", lambda kept: _solid(20, kept, lumped=True), 4 if quick else 20, rounds, 1.05)
        if not quick:
            _march(found, "solid", lambda kept: _solid(31, kept), 15, 3, 1.05)
            _march(found, "plate", lambda kept: plate(157, load=FORCE, C=RAYLEIGH, solver=kept), 20, 7, 1.05)
            _march(found, "beam", _beam, 20, 7, 1.05)
        _beside_opensees(found, 10, 10, 5, 60.0)
        if not quick:
            _beside_opensees(found, 20, 4, 5, 25.0)
        _many_sides(found, 20, rounds)
        _load_cases(found, 20, 20, 3)
        _solvers(found, 10, rounds)
        if not quick:
            _solvers(found, 20, 5)
    found.notes.append(
        "A march is timed as the difference of two of different lengths, with factors kept, so that factorizing and "
        "making the structure are left out. Bare solves take turns among the factors of a step, as the march does."
    )
    return found


def _solid(cells: int, kept: Any, *, lumped: bool = False) -> ss.Structure:
    return solid((cells,) * 3, load=FORCE, C=RAYLEIGH, solver=kept, lumped=lumped)


def _beam(kept: Any) -> ss.Structure:
    """With elements of 0.1 m; with as many on 3 m, solutions with an effective matrix have two digits left."""
    return cantilever(32000, length=3200.0, load=FORCE, C=RAYLEIGH, solver=kept)


def _one_thread() -> None:
    """MKL's threads would wait for each other on one core."""
    from pypardiso import PyPardisoSolver  # noqa: PLC0415 (it may not be installed)

    library: Any = PyPardisoSolver().libmkl
    library.MKL_Set_Num_Threads(ctypes.c_int(1))


def _march(found: Job, what: str, make: Callable[[Kept], ss.Structure], n: int, rounds: int, bound: float) -> None:
    """A step of the march, per solve, beside the solve."""
    for name in ("average_acceleration", "bathe"):
        kept, scheme = Kept(), ss.scheme(name)
        model = make(kept)
        dof = next(x for x, loaded in zip(model.names, model.T @ model.force(np.pi / 2e3), strict=True) if loaded)

        def march(
            steps: int, account: bool, model: ss.Structure = model, scheme: ss.Scheme = scheme, dof: str = dof
        ) -> Any:
            return ss.march(model, scheme, dt=STEP, t_end=steps * STEP, dofs=[dof], account=account).u[:, 0]

        u = march(n, False)
        solves = kept.of_a_step(scheme.balances)
        sides = np.random.default_rng(0).normal(size=(8, model.size))

        def bare(steps: int, solves: Any = solves, sides: Any = sides) -> None:
            for i in range(steps):
                for j, solve in enumerate(solves):
                    solve(sides[(i + j) % 8])

        ways: dict[str, tuple[Kind, Callable[[int], Any], dict[str, float]]] = {
            "bare solves": ("limit", bare, {}),
            LEAST: ("limit", _least(model, solves), {}),
            "march": ("substep", lambda steps, march=march: march(steps, False), {}),
            "march with account": ("substep", lambda steps, march=march: march(steps, True), {}),
        }
        if name == "average_acceleration":
            textbook = _textbook(model, solves[0], dof)
            error = float(np.abs(textbook(n) - u).max() / np.abs(u).max())
            ways["textbook step, same factors"] = ("peer", textbook, {})
            ways["march"] = (*ways["march"][:2], {"textbook": error})
        rows = _per_step(ways, n, rounds, scheme.balances)
        table = Table(f"{what}, {model.size} degrees of freedom, {name}", "solve", rows, {
            "textbook": "largest difference from the textbook step of the loaded displacement"})  # fmt: skip
        found.tables.append(table)
        text = f"{what} of {model.size}, {name}: march / bare solves"
        found.compare(table, text, "march", "bare solves", "<=", bound)
        found.compare(table, f"{what} of {model.size}, {name}: march / {LEAST}", "march", LEAST, "<=", bound)


def _least(model: ss.Structure, solves: Sequence[Callable[[Any], Any]]) -> Callable[[int], Any]:
    """What no step can do without, with the kernels that the march has; numbers are such that nothing grows."""
    M, n, random = model.M, model.size, np.random.default_rng(1)
    rows, X, new = 1e-3 * random.normal(size=(3, 4)), random.normal(size=(4, n)), np.empty((4, n))

    def run(steps: int) -> None:
        old, then = X, new
        for _ in range(steps):
            for solve in solves:
                product = np.zeros(n)
                add_product(M, old[2], product)
                old[3] = solve(product)
                combined(rows, old, then[:3])
                old, then = then, old

    return run


def _beside_opensees(found: Job, cells: int, n: int, rounds: int, wanted: float) -> None:
    """A step of the march of a solid, beside one of OpenSees on the same model."""
    if not find_spec("openseespy"):
        found.skipped["OpenSees"] = "openseespy is not installed; pip install 'substep[bench]'"
        return
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        other, seconds = pool.submit(opensees_solid, cells, STEP, RAYLEIGH, FORCE, n, rounds).result()
    model = _solid(cells, Kept())
    dof = next(x for x, loaded in zip(model.names, model.T @ model.force(np.pi / 2e3), strict=True) if loaded)

    def march(steps: int) -> Any:
        return ss.march(model, "average_acceleration", dt=STEP, t_end=steps * STEP, dofs=[dof], account=False).u[:, 0]

    own = march(n)
    error = float(np.abs(other - own).max() / np.abs(own).max())
    name = "openseespy, SparseSYM, RCM, Linear -factorOnce"
    rows = _per_step({"march": ("substep", march, {})}, MARCHED, rounds, 1)
    rows.append(Measured(name, "peer", seconds, {"march": error}))
    columns = {"march": "largest difference from substep's of the loaded displacement"}
    table = Table(f"solid of {model.size}, Newmark beside OpenSees", "step", rows, columns)
    found.tables.append(table)
    found.compare(table, f"solid of {model.size}: OpenSees / march, a step", name, "march", ">=", wanted)


def _per_step(
    ways: dict[str, tuple[Kind, Callable[[int], Any], dict[str, float]]], n: int, rounds: int, solves: int
) -> list[Measured]:
    """Seconds a solve, from runs of n and 2n steps; the ways take turns."""
    samples = np.full((len(ways), rounds), np.nan)
    for turn in range(rounds):
        for k, (_, run, _) in enumerate(ways.values()):
            began = time.process_time()
            run(n)
            middle = time.process_time()
            run(2 * n)
            samples[k, turn] = (time.process_time() - middle - (middle - began)) / (n * solves)
    return [Measured(name, kind, samples[k], errors) for k, (name, (kind, _, errors)) in enumerate(ways.items())]


def _textbook(model: ss.Structure, solve: Callable[[Any], Any], dof: str) -> Callable[[int], Any]:
    """Newmark's average acceleration as Bathe's Finite Element Procedures has it, Table 9.4, with products M and C."""
    M, C, h, shape = model.M, model.damping, STEP, model.loads[0][0]
    row = model.T[[model.place(dof)]]
    scale = 1.0 / (1.0 + RAYLEIGH.beta * 2.0 / h)  # factors are those of the matrix over what K has in it

    def run(n: int) -> Any:
        u, v, a = model.u0.copy(), model.v0.copy(), model.a0.copy()
        kept = [(row @ u)[0]]
        for i in range(1, n + 1):
            right = shape * float(FORCE(np.array(i * h))) + M @ (4 / h**2 * u + 4 / h * v + a) + C @ (2 / h * u + v)
            new = scale * solve(right)
            rate = 2 / h * (new - u) - v
            a = 4 / h**2 * (new - u) - 4 / h * v - a
            u, v = new, rate
            kept.append((row @ u)[0])
        return np.array(kept)

    return run


def _effective(cells: int) -> Any:
    """K + 4/h^2 M of the solid."""
    model = solid((cells,) * 3)
    return combination([(1.0, model.K), (4.0 / STEP**2, model.M)])


def _many_sides(found: Job, cells: int, rounds: int) -> None:
    """A block of right sides beside one after the other."""
    A = _effective(cells)
    solve = factorization.pardiso(A)
    B = np.asfortranarray(np.random.default_rng(0).normal(size=(A.shape[0], SIDES)))

    def residual(X: Any) -> dict[str, float]:
        return {"residual": float(np.linalg.norm(A @ X - B) / np.linalg.norm(B))}

    rows = [
        Alternative("one after the other", "limit", lambda: np.column_stack([solve(b) for b in B.T]), SIDES, residual),
        Alternative("as a block", "substep", lambda: solve(B), SIDES, residual),
    ]
    table = Table(f"{SIDES} right sides, {A.shape[0]} unknowns, PARDISO", "side", measure(rows, rounds), {
        "residual": "norm of A x - b over that of b"})  # fmt: skip
    found.tables.append(table)
    text = f"{SIDES} right sides at once / one after the other"
    found.compare(table, text, "as a block", "one after the other", "<=", 0.35)


def _load_cases(found: Job, cells: int, n: int, rounds: int) -> None:
    """A sweep over load cases beside a march of each, whole calls that factorize what they need."""
    model = solid((cells,) * 3, C=RAYLEIGH)
    corner, dof = model.T @ np.eye(model.size)[-1], model.names[-1]
    loads = [(corner, ss.Harmonic(1.0, 1e3 * (1.0 + i / SIDES))) for i in range(SIDES)]
    run = {"scheme": "average_acceleration", "dt": STEP, "t_end": n * STEP, "dofs": [dof]}

    def sweep() -> Any:
        return ss.sweep(model, load=loads, keep="history", **run).u.values

    def marches() -> Any:
        return np.stack([ss.march(m, account=False, **run).u for m in alone])

    alone = [replace(model, loads=loads_of(model.T, model.names, load)) for load in loads]
    reference = marches()

    def error(u: Any) -> dict[str, float]:
        return {"march": float(np.abs(u - reference).max() / np.abs(reference).max())}

    rows = [
        Alternative("a march of each", "limit", marches, SIDES * n),
        Alternative("a sweep", "substep", sweep, SIDES * n, error),
    ]
    table = Table(f"{SIDES} load cases, {model.size} degrees of freedom", "case and step", measure(rows, rounds), {
        "march": "largest difference from the marches"})  # fmt: skip
    found.tables.append(table)
    found.compare(table, f"{SIDES} load cases: a sweep / a march of each", "a sweep", "a march of each", "<=", 0.35)


def _solvers(found: Job, cells: int, rounds: int) -> None:
    """Factorizing and solving by each solver that is installed."""
    A = _effective(cells)
    b = np.random.default_rng(0).normal(size=A.shape[0])

    def residual(solve: Callable[[Any], Any]) -> dict[str, float]:
        return {"residual": float(np.linalg.norm(A @ solve(b) - b) / np.linalg.norm(b))}

    ways: dict[str, Callable[[Any], Any]] = {"PARDISO": factorization.pardiso, "SuperLU": _plain_superlu}
    if find_spec("pymetis"):
        ways["SuperLU in METIS's order"] = factorization.superlu
    else:
        found.skipped["SuperLU in METIS's order"] = "pymetis is not installed"
    if find_spec("cvxopt"):
        ways["CHOLMOD"] = factorization.cholmod
    else:
        found.skipped["CHOLMOD"] = "cvxopt is not installed"
    errors = {"residual": "norm of A x - b over that of b"}
    made = {name: way(A) for name, way in ways.items()}
    for title, rows in (
        ("factorization", [Alternative(x, "peer", lambda way=way: way(A), 1, residual) for x, way in ways.items()]),
        ("solve", [Alternative(x, "peer", lambda solve=solve: solve(b), 1) for x, solve in made.items()]),
    ):
        found.tables.append(Table(f"{title}, {A.shape[0]} unknowns", title, measure(rows, rounds), errors))


def _plain_superlu(matrix: Any) -> Callable[[Any], Any]:
    """SciPy's splu with its default order."""
    return splu(sparse.csc_array(matrix)).solve
