"""What a step remembers of its reactions.

That is all of them, or nothing where an impact is to act in its own step alone: the accelerations that the next step
reads are then without theirs. Of a constraint beside contacts or frictions a step remembers what it is without an
impact, its multiplier by the equations of motion under all forces but theirs, so that schemes keep their order where
nothing touches, as in Chen, Acary, Virlez & Bruels, Int. J. Numer. Meth. Engng 96 (2013) 487-511.
"""

from collections.abc import Mapping

from sympy import Expr, Integer, Matrix, Symbol, zeros

from ..constrained.explicit import explicit
from ..declare.names import label_name
from ..declare.scene import Scene
from ..declare.symbols import N, f, kind_of, knot_of, successor
from ..motion.components import Assignments, Writer, assign
from ..step.step import Step
from ..step.times import impulses, instant_of, instants_of, newest
from .balance_step import Part
from .held_block import accelerated, held_block, held_solution


def at_start(scene: Scene) -> Matrix:
    """The reactions at t_n, of the last balance before."""
    return Matrix([Symbol(f"multiplier_{s}") for s in scene.multipliers])


def of_balance(scene: Scene, k: int) -> Matrix:
    """Those that the k-th balance is solved for."""
    return Matrix([Symbol(f"multiplier{k + 1}_{s}") for s in scene.multipliers])


def remembered(scene: Scene) -> Matrix:
    """The reactions at t_n that a balance holds which takes the force there too."""
    return _lasting(scene, at_start(scene)) if scene.impulsive else at_start(scene)


def _lasting(scene: Scene, multipliers: Matrix) -> Matrix:
    """The reactions with 0 for those of contacts and frictions."""
    c = len(scene.constraints)
    return Matrix([e if j < c else Integer(0) for j, e in enumerate(multipliers)])


def lasting_at(scene: Scene, k: int) -> Matrix:
    """What is remembered of the reactions of the k-th balance, by name."""
    return _lasting(scene, Matrix([Symbol(f"lasting{k + 1}_{s}") for s in scene.multipliers]))


def loads_of(step: Step, scene: Scene) -> list[Expr]:
    """The loads that `lasting` reads, at the instants of the step's forces."""
    if not (scene.impulsive and scene.constraints) or explicit(step):
        return []
    at = instants_of(step)
    atoms = (atom for stage in step.stages for b in stage.balances for atom in b.force.atoms(N))
    return [f(instant_of(atom.args[0], at)) for atom in atoms]


def lasting(w: Writer, k: int, where: tuple[Expr, Expr], u: Matrix, v: Matrix) -> list[Part]:
    """What is remembered of the reactions of the k-th balance: the multipliers of constraints.

    where: the displacement that the balance takes the force at, and when that is, in steps after t_n; u, v: components
    there.
    """
    places, held = range(len(w.motion.scene.constraints)), w.motion.held
    if not places:
        return []
    argument, tau = where
    when = w.instant(tau)
    names = [w.components(Symbol(f"{kind}_*lasting{k}")) for kind in "uv"]
    found = Part([*assign(names[0], w.hoisted(u)), *assign(names[1], w.hoisted(v))])
    at, speed = (list(name) for name in names)
    mass, force = w.motion.equation(at, speed, when)
    force = force.xreplace(w.remembered(argument))
    directions = held.directions_at(at, when)
    block, entries = held_block(w, places, mass, directions, f"lasting{k}")
    rates = held.at(held.drift[1], at, speed, when)[: len(places), :]
    right = Matrix([*(w.vector(f(tau)) - force), *-rates])
    solution, given, solve = held_solution(w, block, right, f"lasting{k}")
    result = assign(lasting_at(w.motion.scene, k)[: len(places), :], solution[w.size :, :])
    return [found, Part([*entries, *given]), Part([*solve, *result], named=False)]


def pushed(w: Writer, k: int, u: Matrix, at: Expr, unknown: Matrix, share: Expr) -> list[Part]:
    """The acceleration, not remembered, that the reactions of the k-th balance have given to its z, by name.

    unknown: the reactions; share: what a force where the balance takes it gives to z, times the mass.
    """
    mass, _ = w.motion.equation(list(u), list(u), at)
    force = w.motion.held.directions_at(list(u), at).T * (unknown - share * lasting_at(w.motion.scene, k))
    push, parts = accelerated(w, mass, force, f"push{k}")
    return [*parts, Part(assign(w.components(_push(k)), w.hoisted(push)))]


def _push(k: int) -> Symbol:
    return Symbol(f"a_*push{k}")


def kept(w: Writer, step: Step) -> tuple[Mapping[Symbol, Symbol], Assignments, Matrix]:
    """What a step keeps of its reactions.

    New accelerations that the next step or the report reads -> names of them without reactions that are not remembered;
    assignments of these and of the reactions at the end of the step, or of their means; and the names of the latter.
    """
    scene, found = w.motion.scene, Assignments()
    if not w.strengths:
        return {}, found, w.latest
    own = {s for e in step.outputs[2:] if e.is_Symbol for s in e.free_symbols}
    wanted = {successor(s) for s in step.state} | own
    names = {
        s: Symbol(f"a_*free{label_name((knot_of(s) or ('', ''))[1])}")
        for s in sorted(wanted, key=str)
        if kind_of(s) == 2 and s in step.unknowns
    }
    for s, name in names.items():
        whole = w.components(s)
        for k, z in enumerate(step.accelerations):
            whole += (Integer(1) if s == z else step.solved.get(s, Integer(0)).diff(z)) * w.components(_push(k))
        found += assign(w.components(name), w.hoisted(whole))
    total = zeros(len(scene.multipliers), 1)
    for k, weight in enumerate(impulses(step).weights):
        total += weight * of_balance(scene, k)
    means = Matrix([Symbol(f"mean_{s}") for s in scene.multipliers])
    last = lasting_at(scene, newest(step, step.stages[-1]))
    total = Matrix([mean if e == 0 else e for e, mean in zip(last, total, strict=True)])
    return names, found + assign(means, w.hoisted(total)), means
