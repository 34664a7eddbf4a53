"""SceneStep -> AdaptiveStep: a step whose length the march chooses, with its estimated local error."""

from dataclasses import dataclass

from sympy import Expr, Matrix, Symbol

from ..declare.errors import DeclarationError
from ..declare.scheme import Scheme
from ..declare.symbols import h, knot, sampled, t
from ..motion.components import Assignments, assign, component_names
from ..motion.equations import EquationsOfMotion
from .interpolant import Interpolant
from .local_error import Terms, combined, weight_names
from .scene_step import SceneStep


@dataclass(frozen=True)
class AdaptiveStep:
    """step: as of a constant step, with h a variable and the time t_n = t.

    once: constants that do not depend on h; changing: those that do, and are computed again where h changes. error_u,
    error_v: names and expressions of the estimated errors' components. acceleration: from the equation of motion, in
    components of u, v named without a knot, t and the load. between: the interpolant, for one coordinate of a step.
    """

    step: SceneStep
    terms: Terms
    once: Assignments
    changing: Assignments
    error_u: Assignments
    error_v: Assignments
    acceleration: Matrix
    between: Interpolant

    @classmethod
    def of(cls, scheme: Scheme, motion: EquationsOfMotion, terms: Terms, order: int) -> "AdaptiveStep":
        """terms, order: of the local error's estimate (see `LocalError`).

        Raises DeclarationError as `SceneStep.of`, and for a scheme whose state holds values before t_n or does not
        begin with u_0, v_0, a_0: its step cannot change.
        """
        if earlier := [s for s in scheme.state if s not in knot(0)]:
            raise DeclarationError(
                f"{scheme.name}: expected a state at t_n alone where steps change, got {earlier[0]}, which stands at "
                "another time; give dt, or take a one-step or composite scheme"
            )
        if scheme.start_scheme is not None or scheme.start:
            raise DeclarationError(
                f"{scheme.name}: expected a state that begins with u_0, v_0, a_0 where steps change, got a start of "
                "its own, which depends on the step; give dt, or take another scheme"
            )
        step = SceneStep.of(scheme, motion, now=t, errors=combined(terms), weights=weight_names(terms))
        once: Assignments = []
        changing: Assignments = []
        moving = {h}
        for name, e in step.constants:
            moves = bool(e.free_symbols & moving)
            (changing if moves else once).append((name, e))
            moving |= {name} if moves else set()
        errors = [
            assign(Matrix([Symbol(name) for name in component_names(Symbol(f"{kind}_*error"), motion)]), e)
            for kind, e in zip("uv", step.errors, strict=True)
        ]
        u, v = ([Symbol(name) for name in component_names(Symbol(f"{k}_*now"), motion)] for k in "uv")
        place = dict(zip((*motion.coordinates, *motion.scene.rates), (*u, *v), strict=True))
        acceleration = motion.consistent_acceleration.subs({**place, sampled: Symbol("load")}, simultaneous=True)
        return cls(
            step, terms, once, [*changing, *step.near], errors[0], [both for both in errors[1] if both[1] != 0],
            acceleration, Interpolant.of(knot(0), knot(1), order),
        )  # fmt: skip

    @property
    def own_acceleration(self) -> bool:
        """Whether the scheme reports an acceleration of its own."""
        return len(self.step.report) > 2

    @property
    def newton_balances(self) -> list[int]:
        """Places of the balances that iterate."""
        return [k for k, step in enumerate(self.step.steps) if step.first is not None]

    @property
    def expressions(self) -> list[Expr]:
        """Every expression that a run computes."""
        return [*self.step.expressions, *self.acceleration]

    def step_components(self, kind: str) -> Matrix:
        """Symbols of the components of u_0, v_0 or a_0."""
        return Matrix([Symbol(name) for name in component_names(Symbol(f"{kind}_0"), self.step.motion)])
