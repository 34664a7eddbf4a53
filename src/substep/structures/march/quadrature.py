"""A finer rule for the work of forces and of damping in a step than the trapezoidal one of the account of energy.

Within a step of length h, u is the cubic through u and v at both ends (Hermite), and the force f the parabola through
its values at both ends and the middle. With the fraction x of the step, the integral of f . du/dx over x is then that
of the trapezoidal rule, (f_0 + f_1) . (u_1 - u_0) / 2, and what `of_work` returns. The velocity departs from its mean
(u_1 - u_0)/h by a part that is odd about the middle of the step and one that is even, which are orthogonal: of the
damped energy, the integral of v . C v over time, they are what `of_damped` returns.
"""

from collections.abc import Callable, Sequence
from typing import Any

from ...core.arrays import Array

Product = Callable[[Any, Any], Any]  # of a force and a displacement


def of_work(forces: Sequence[Any], change: Any, v: Sequence[Any], h: float, product: Product) -> Any:
    """What the finer rule adds to the work of forces at the start, the middle and the end of a step.

    change: of the displacement; v: at both ends.
    """
    start, half, end = forces
    bulge = half - 0.5 * (start + end)
    return product(end - start, v[1] - v[0]) * (h / 12) + product(bulge, 0.8 * change - h / 15 * (v[0] + v[1]))


def of_damped(change: Sequence[Any], v: Sequence[Any], resisted: Sequence[Any], h: float, product: Product) -> Any:
    """What it adds to the damped energy. change: of the displacement, and C times that; resisted: C v at both ends."""
    odd = product(v[1] - v[0], resisted[1] - resisted[0]) * (h / 12)
    even = [h * (x[0] + x[1]) - 2.0 * y for x, y in zip((v, resisted), change, strict=True)]
    return odd + product(*even) / (20 * h)


def middle(u_0: Array, u_1: Array, v_0: Array, v_1: Array, h: float) -> tuple[Array, Array]:
    """u and v at the middle of a step."""
    return 0.5 * (u_0 + u_1) + h / 8 * (v_0 - v_1), 1.5 / h * (u_1 - u_0) - 0.25 * (v_0 + v_1)
