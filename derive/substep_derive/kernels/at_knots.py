"""What the balances of a stage take of the equation of motion at knots, in components."""

from dataclasses import replace

from sympy import Expr, Integer, Matrix, Rational, sympify

from ..declare.errors import DeclarationError
from ..declare.scene_checks import singular
from ..declare.scheme import Balance
from ..declare.symbols import N_discrete
from ..motion.components import Writer
from ..motion.discrete import discrete_equation
from ..step.places import Place, places
from ..step.step import Stage, Step
from .balance_step import Part
from .held_block import accelerated
from .remembering import of_balance
from .together import split, unknowns


class AtKnots:
    """Evaluates what the balances of a stage take at a knot."""

    def __init__(self, w: Writer, k: int, stage: Stage) -> None:
        """k: the number of the stage; balances: the places of its balances among all."""
        self.w, self.k, self.stage, self.z = w, k, stage, unknowns(w, stage)
        self.prepared = list[Part]()  # what is computed for accelerations
        accelerations = Step.of(w.scheme).accelerations
        self.balances = [accelerations.index(z) for z in stage.z]

    def press(self, number: int, factor: Expr) -> None:
        """Says which reactions act: those of a balance, by its place in the stage.

        factor: of reactions that are not remembered, so that they accelerate the balance's z by M^-1 G^T times them.
        """
        own = of_balance(self.w.motion.scene, self.balances[number])
        self.w.acting = own * self.w.constant(factor) if self.w.strengths else own

    def by_z(self, whole: Matrix) -> list[Expr]:
        """The derivatives of a vector by the accelerations of the stage, each a number times the unit matrix."""
        return [Integer(0) + whole[0].diff(part[0]) for part in split(self.w, self.z)]

    def at_rest(self, vector: Matrix) -> Matrix:
        """The vector at z = 0."""
        return vector.subs(dict.fromkeys(self.z, Integer(0)))

    def acceleration(self, place: Place, u: Matrix, v: Matrix, load: Matrix) -> Matrix:
        """Minus the acceleration there under the load, times the weight."""
        mass, force = self.equation(place, u, v)
        anywhere = {s: Rational(3, 5 + k) for k, s in enumerate(sorted(mass.free_symbols, key=str))}
        if singular(mass.subs(anywhere).evalf(30)):
            none = ", ".join(str(q) for i, q in enumerate(self.w.motion.coordinates) if mass[i, :].is_zero_matrix)
            found = f"no mass of {none}" if none else mass.tolist()
            raise DeclarationError(
                f"{self.w.scheme.name}: expected a mass matrix of {self.w.motion.scene.name} that is regular, since a "
                f"balance takes accelerations at several instants, got {found}; "
                "take a scheme that takes them at one, such as bathe, or give each coordinate a mass"
            )
        mark = f"known{self.k}_{len(self.prepared)}"
        found, parts = accelerated(self.w, mass, force - load, mark)
        self.prepared += parts
        return place.weight * found

    def in_z(self, e: Expr) -> Matrix:
        """Components of a vector in those of the unknown and of what is known."""
        return self.w.hoisted(self.w.vector(sympify(e).subs(self.stage.in_z, simultaneous=True)))

    def moves(self, place: Place) -> bool:
        """Whether the equation of motion there depends on the unknown."""
        v = self.in_z(place.v) if self.w.motion.damped else Matrix()
        return any(e.has(*self.z) for e in (*self.in_z(place.u), *v))

    def equation(self, place: Place, u: Matrix, v: Matrix) -> tuple[Matrix, Matrix]:
        """Mass and forces there, at these components of displacement and velocity."""
        w = self.w
        instant = w.when(place.u)
        if isinstance(place.force, N_discrete):
            old, new = (list(w.vector(argument)) for argument in place.force.args)
            mass, force = discrete_equation(w.motion, old, new, list(v), instant)
            return mass, force + w.discrete_reaction(old, new)
        mass, force = w.motion.equation(list(u), list(v), instant)
        force += w.reaction(place.force, list(u), instant)
        return mass, force.xreplace(w.remembered(place.u))


def places_of(balance: Balance, at: AtKnots) -> list[Place]:
    """Where the balance takes the equation of motion.

    Forces of rates are taken at each knot of its force, a constant damping, if that is another mixture, at one of them.
    Raises DeclarationError where it takes it at several knots, and what C multiplies is not the same mixture of theirs.
    """
    w = at.w
    found, same = places(balance.force, balance.damping)
    if same or not w.motion.damped:
        return found
    if w.motion.of_rates:
        raise DeclarationError(
            f"{w.scheme.name}: expected a balance whose damping mixes the velocities of the knots of its force, with "
            f"the same weights, got {balance.damping} beside {balance.force}, on {w.motion.scene.name}, whose forces "
            "depend on rates; take another scheme"
        )
    whole = next((place for place in found if at.in_z(place.u).has(*at.z)), found[-1])
    return [place if place is whole else replace(place, v=Integer(0)) for place in found]  # a constant damping, once
