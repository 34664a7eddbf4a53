"""Declarations of reactions: of a constraint, of a contact, which only pushes, and of friction, up to a limit."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from sympy import Expr, Symbol, sympify

from .branches import by_branch
from .errors import DeclarationError
from .expressions import expression
from .potentials import negative_part

LEVELS = ("position", "velocity", "both")


@dataclass(frozen=True)
class Constraint:
    """An expression g that a reaction keeps at 0, at displacements or, by its total derivative d/dt g, at velocities.

    level: which of these, where g holds no rates; one that holds rates is kept at 0 at velocities itself. At the level
    of velocities (index 2: Hairer & Wanner, Solving Ordinary Differential Equations II, VII.1) g drifts by the scheme's
    error. "both" is the stabilisation of Gear, Gupta & Leimkuhler, J. Comput. Appl. Math. 12-13 (1985) 77-90: a second
    multiplier moves displacements alone, so that g and d/dt g are 0 alike. projected: whether each step ends with u and
    v moved to where g and d/dt g are 0, as little as possible, measured by the mass. Raises DeclarationError for
    another level.
    """

    expression: Expr
    level: str = "position"
    projected: bool = False

    def __post_init__(self) -> None:
        given = expression("a constraint", "what is to be 0", self.expression)
        object.__setattr__(self, "expression", by_branch(given))
        if self.level not in LEVELS:
            raise DeclarationError(
                f"expected the level of a constraint among {', '.join(LEVELS)}, got {self.level!r}; give one of these"
            )

    def renamed(self, names: Mapping[Symbol, Expr]) -> "Constraint":
        """The same with other names of parameters."""
        return replace(self, expression=self.expression.subs(names, simultaneous=True))


@dataclass(frozen=True)
class Contact:
    """A gap, positive before it closes, that a pressure keeps from closing beyond 0; the pressure is never negative.

    Without a restitution the gap is what is held: at each knot where a scheme takes the force, of gap and pressure one
    is 0. With restitution e the velocity is: where the motion from t_n on would close the gap, it opens at least with e
    times the velocity with which it closed at t_n, of which and of the pressure one is 0 (Moreau 1988; Jean, Comput.
    Methods Appl. Mech. Engrg. 177 (1999) 235-257). e is a number or an expression of the scene's parameters.

    remembered: whether the acceleration that a scheme keeps for its next step holds that of the pressure. If it does
    not, an impact acts in its own step alone.

    penalty: the stiffness of an elastic stop, a positive number or an expression of the scene's parameters. The gap
    may then close beyond 0, under a pressure of -penalty*gap, which a `Scene` has as a part of its potential and as an
    output by the contact's name. Raises DeclarationError beside what speaks of a rigid stop.
    """

    gap: Expr
    restitution: Expr | None = None
    remembered: bool = False
    penalty: Expr | None = None

    def __post_init__(self) -> None:
        for name in ("gap", "restitution", "penalty"):
            given = getattr(self, name)
            found = None if given is None else by_branch(expression("a contact", f"a {name}", given))
            object.__setattr__(self, name, found)
        if self.penalty is not None and (self.restitution is not None or self.remembered):
            raise DeclarationError(
                "expected a contact with a penalty, an elastic stop, without restitution and remembered=True, got "
                "both; leave one out"
            )
        if self.penalty is not None and self.penalty.is_number and not self.penalty.is_positive:
            raise DeclarationError(
                f"expected a penalty above 0 of a contact, got {self.penalty}; it is the stiffness of the stop"
            )

    @property
    def elastic(self) -> tuple[Expr, Expr]:
        """The potential and the pressure of one with a penalty."""
        inside = negative_part(self.gap)
        return sympify(self.penalty) * inside**2 / 2, -sympify(self.penalty) * inside

    def renamed(self, names: Mapping[Symbol, Expr]) -> "Contact":
        """The same with other names of parameters."""
        given = {"gap": self.gap, "restitution": self.restitution, "penalty": self.penalty}
        return replace(self, **{key: e.subs(names, simultaneous=True) for key, e in given.items() if e is not None})


@dataclass(frozen=True)
class Friction:
    """A force against the rate of `along`, of at most `limit`: less than that where nothing slides (Coulomb's law).

    along: what slides, an expression in coordinates, invariants, parameters and t, as x - v*t of a block at x on a belt
    of velocity v. limit: an expression in these, and in the symbols of contacts, which stand for their pressures.
    """

    along: Expr
    limit: Expr

    def __post_init__(self) -> None:
        for name in ("along", "limit"):
            given = expression("a friction", f"a {name}", getattr(self, name))
            object.__setattr__(self, name, by_branch(given))

    def renamed(self, names: Mapping[Symbol, Expr]) -> "Friction":
        """The same with other names of parameters."""
        return Friction(self.along.subs(names, simultaneous=True), self.limit.subs(names, simultaneous=True))
