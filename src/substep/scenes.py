"""Scenes: what is marched. For now the linear oscillator; scenes from an energy are to follow."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from .errors import real_number, unknown_name
from .loads import Load


@dataclass(frozen=True)
class LinearOscillator:
    """a + 2*xi*omega*v + omega^2*u = load(t), per unit mass (thesis chapter 4).

    omega in rad/s, u0, v0, a0 in m, m/s, m/s^2; a0 = "consistent" takes it from the equation of motion.
    """

    omega: float
    xi: float = 0.0
    u0: float = 1.0
    v0: float = 0.0
    a0: float | Literal["consistent"] = "consistent"
    load: Load | None = None

    def __post_init__(self) -> None:
        real_number("omega", self.omega, positive=True)
        for name in ("xi", "u0", "v0"):
            real_number(name, getattr(self, name))
        if self.xi < 0:
            raise ValueError(f"expected xi >= 0, got {self.xi}; give the damping ratio of a passive oscillator")
        if isinstance(self.a0, str):
            if self.a0 != "consistent":
                raise ValueError(f"expected a0 to be a number or 'consistent', got '{self.a0}'")
        else:
            real_number("a0", self.a0)
        if self.load is not None and not callable(self.load):
            raise ValueError(
                f"expected load to be None or a function of time such as ss.Harmonic, got {type(self.load).__name__}; "
                "wrap samples as ss.Record(dt, values)"
            )

    @property
    def start(self) -> tuple[float, float, float]:
        """(u, v, a) at t = 0."""
        if not isinstance(self.a0, str):
            return self.u0, self.v0, float(self.a0)
        force = 0.0 if self.load is None else float(self.load(np.zeros(1))[0])
        return self.u0, self.v0, force - 2 * self.xi * self.omega * self.v0 - self.omega**2 * self.u0

    def energy(self, u: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Kinetic and strain energy per unit mass; inf for finite states beyond about 1e154."""
        with np.errstate(over="ignore"):
            return 0.5 * v**2 + 0.5 * self.omega**2 * u**2


_SCENES: dict[str, Callable[..., LinearOscillator]] = {"linear_oscillator": LinearOscillator}


def scenes() -> tuple[str, ...]:
    """Names of all scenes."""
    return tuple(_SCENES)


def scene(name: str, **parameters: Any) -> LinearOscillator:
    """The scene of that name. Raises ValueError for unknown names and bad values."""
    if name not in _SCENES:
        raise unknown_name("a scene", name, _SCENES)
    known = LinearOscillator.__dataclass_fields__
    for key in parameters:
        if key not in known:
            raise unknown_name(f"a parameter of {name}", key, known)
    if "omega" not in parameters:
        raise ValueError(f"expected {name} with omega, its circular frequency in rad/s; got none; add omega=...")
    return _SCENES[name](**parameters)
