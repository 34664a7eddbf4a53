"""Declarations of reactions that are bounded: of a contact, which only pushes, and of friction, up to a limit."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from sympy import Expr, Symbol, sympify


@dataclass(frozen=True)
class Contact:
    """A gap, positive before it closes, that a pressure keeps from closing beyond 0; the pressure is never negative.

    Without a restitution the gap is what is held: at each knot where a scheme takes the force, of gap and pressure one
    is 0. With restitution e the velocity is: where the motion from t_n on would close the gap, it opens at least with e
    times the velocity with which it closed at t_n, of which and of the pressure one is 0 (Moreau 1988; Jean, Comput.
    Methods Appl. Mech. Engrg. 177 (1999) 235-257). e is a number or an expression of the scene's parameters.

    remembered: whether the acceleration that a scheme keeps for its next step holds that of the pressure. If it does
    not, an impact acts in its own step alone.
    """

    gap: Expr
    restitution: Expr | None = None
    remembered: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "gap", sympify(self.gap))
        object.__setattr__(self, "restitution", None if self.restitution is None else sympify(self.restitution))

    def renamed(self, names: Mapping[Symbol, Expr]) -> "Contact":
        """The same with other names of parameters."""
        found = None if self.restitution is None else self.restitution.subs(names, simultaneous=True)
        return replace(self, gap=self.gap.subs(names, simultaneous=True), restitution=found)


@dataclass(frozen=True)
class Friction:
    """A force against the rate of `along`, of at most `limit`: less than that where nothing slides (Coulomb's law).

    along: what slides, an expression in coordinates, invariants, parameters and t, as x - v*t of a block at x on a belt
    of velocity v. limit: an expression in these, and in the symbols of contacts, which stand for their pressures.
    """

    along: Expr
    limit: Expr

    def __post_init__(self) -> None:
        object.__setattr__(self, "along", sympify(self.along))
        object.__setattr__(self, "limit", sympify(self.limit))

    def renamed(self, names: Mapping[Symbol, Expr]) -> "Friction":
        """The same with other names of parameters."""
        return Friction(self.along.subs(names, simultaneous=True), self.limit.subs(names, simultaneous=True))
