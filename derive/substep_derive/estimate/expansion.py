"""Expansions in the step of what a step computes: sums of (h*c)^i (h^2*k)^j times a derivative of the exact solution.

The oscillator is u'' + c u' + k u + g = f(t) per unit mass, with c, k and every derivative of the exact solution
independent of each other, so that an identity of such sums holds for every frequency, damping and smooth load. g stands
for the part of a nonlinear internal force that is no linear function of u; it is kept apart from f because a scheme may
take the two at different instants. Everything has a weight, the power of h that it carries.
"""

from collections.abc import Mapping
from typing import Any

from sympy import QQ

Key = tuple[
    int, int, int
]  # powers of h*c and of h^2*k, and the place: l >= 0 for h^l d^l u/dt^l, -1 - m for h^(2+m) g^(m)


def weight(key: Key) -> int:
    """The power of h."""
    i, j, place = key
    return i + 2 * j + (place if place >= 0 else 1 - place)


def of_g(m: int) -> int:
    """The place of h^(2+m) times the m-th derivative of g."""
    return -1 - m


class Expansion:
    """A truncated sum key -> coefficient, with zeros left out."""

    __slots__ = ("terms",)

    def __init__(self, terms: Mapping[Key, Any] | None = None) -> None:
        self.terms: dict[Key, Any] = dict(terms or {})

    def add(self, other: "Expansion", factor: Any, i: int, j: int, top: int) -> None:
        """Add factor*(h*c)^i*(h^2*k)^j*other, up to the weight top."""
        terms = self.terms
        for (p, q, place), value in other.terms.items():
            key = p + i, q + j, place
            if weight(key) > top:
                continue
            _put(terms, key, terms[key] + factor * value if key in terms else factor * value)

    def __sub__(self, other: "Expansion") -> "Expansion":
        found = Expansion(self.terms)
        for key, value in other.terms.items():
            _put(found.terms, key, found.terms[key] - value if key in found.terms else -value)
        return found

    def plus(self, other: "Expansion", factor: Any) -> "Expansion":
        """The sum with factor*other, without a limit of weight."""
        found = Expansion(self.terms)
        found.add(other, factor, 0, 0, max(map(weight, other.terms), default=0))
        return found

    def at_weight(self, w: int) -> dict[Key, Any]:
        """The terms of one weight."""
        return {key: value for key, value in self.terms.items() if weight(key) == w}

    @property
    def valuation(self) -> int | None:
        """The least weight; None for 0."""
        return min(map(weight, self.terms), default=None)

    @property
    def undamped_valuation(self) -> int | None:
        """The least weight of terms without damping; None if there are none."""
        return min((weight(key) for key in self.terms if key[0] == 0), default=None)

    def scaled(self, ratio: Any) -> "Expansion":
        """The same with ratio*h for h."""
        return Expansion({key: value * ratio ** weight(key) for key, value in self.terms.items()})


def _put(terms: dict[Key, Any], key: Key, value: Any) -> None:
    if value:
        terms[key] = value
    else:
        terms.pop(key, None)


def derivative(order: int, one: Any) -> Expansion:
    """h^order times that derivative of the exact solution at t_n."""
    return Expansion({(0, 0, order): one})


def load(m: int, one: Any, damped: bool) -> Expansion:
    """h^(2+m) times the m-th derivative of the load at t_n, from the equation of motion."""
    found = Expansion({(0, 0, m + 2): one, (0, 1, m): one, (0, 0, of_g(m)): one})
    if damped:
        found.terms[1, 0, m + 1] = one
    return found


def taylor(order: int, time: Any, one: Any, top: int) -> Expansion:
    """h^order times that derivative of the exact solution at t_n + time*h."""
    found, power = Expansion(), one
    for m in range(top - order + 1):
        if power:
            found.terms[0, 0, order + m] = power
        power = power * time * QQ(1, m + 1)
    return found
