"""Every scheme of the project on the linear oscillator, stepped number by number: an independent oracle.

A step is that of nonlinear_oracle.py, which shares no code and no idea with the symbolic derivation that it checks, for
the oscillator a + 2 xi omega v + omega^2 u = f(t) with h = 1 and omega = Omega, so that a state holds u, h*v and h^2*a.
Amplification matrices come from stepping unit states. The arithmetic is that of Omega: Python floats and mpmath.mpf
both work.
"""

import re
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import tables
from as_declared import parameters_of, state_of
from lines import Row
from nonlinear_oracle import Run, System, written

Number = Any  # float or mpmath.mpf

USUAL = "u h*v h^2*a"
STATES = {  # of schemes that carry something else from step to step
    **dict.fromkeys(("forward_euler", "rk2", "rk4", "backward_euler", "energy_momentum", "theta_method",
                     "discontinuous_galerkin_p1", "ss22"), "u h*v"),
    "first_order_generalized_alpha": f"{USUAL} h*rate",
    "arnold_bruels": f"{USUAL} h^2*weighted",
    "central_difference_lagged": "u h*v[-1/2]",
    "houbolt": "u u[-1] u[-2]",
    **dict.fromkeys(("park", "bdf3"), "u h*v u[-1] h*v[-1] u[-2] h*v[-2]"),
    **dict.fromkeys(("gholampour", "adams_moulton3", "zhai", "beeman"), f"{USUAL} h^2*a[-1]"),
    "adams_moulton4": f"{USUAL} h^2*a[-1] h^2*a[-2]",
    "bdf_alpha": f"{USUAL} u[-1] h*v[-1]",
    "oalts": f"{USUAL} u[-1] h*v[-1] h^2*a[-1]",
    "bdf2": "u h*v u[-1] h*v[-1]",
    "bdf4": "u h*v u[-1] h*v[-1] u[-2] h*v[-2] u[-3] h*v[-3]",
}  # fmt: skip
PARAMETERS = {  # of schemes that take some; others of theirs follow from these
    "noh_bathe": "p", "tchamwa_wielgosz": "phi", "kr_alpha": "rho_inf", "newmark": "beta gamma",
    "wilson_theta": "theta", "hht_alpha": "alpha", "wbz_alpha": "alpha_B", "generalized_alpha": "alpha_m alpha_f",
    "gholampour": "delta alpha_g", "oalts": "rho_inf", "silva_bezerra": "gamma_t",
    "newmark_bdf2": "beta gamma gamma_t", "theta_method": "theta",
    "rho_inf_bathe": "rho_inf gamma_t", "beta1_beta2_bathe": "beta1 beta2 gamma_t", "three_substep": "rho_inf",
    "collocation": "theta beta gamma", "explicit_generalized_alpha": "alpha_m alpha_f beta gamma", "zhai": "psi phi",
    "kim_two_stage": "gamma_t", "three_substep_third_order": "rho_inf", "four_substep": "rho_inf", "chung_lee": "beta",
    "oess": "rho_inf", "ss22": "theta_1 theta_2", "ss32": "theta_1 theta_2 theta_3",
    "gui_lambda": "lambda_g", "lsrt2": "gamma",
    "alpha_os": "alpha", "chang": "beta gamma",
    **dict.fromkeys(("first_order_generalized_alpha", "arnold_bruels"), "rho_inf"),
    "fully_explicit_generalized_alpha": "rho_inf",
    "mkr_alpha": "rho_inf", "trapezoid_trapezoid_backward": "cubic",
    "gsse": "rho_b rho_s", "tarnow_simo": "weight", "bdf_alpha": "alpha",
    **dict.fromkeys(("gssss_u0", "gssss_v0"), "rho_1 rho_2 rho_3"),
    **{name: names for name, (_, names) in tables.TABLES.items()},
    **dict.fromkeys(("suzuki", "forest_ruth"), "weight"),
}  # fmt: skip
OPTIONAL = {"generalized_alpha": "beta gamma"}
UNDAMPED = {*tables.NYSTROM, *tables.EXTRAPOLATIONS, *tables.COMPOSITIONS} - {*tables.DAMPED_COMPOSITIONS}


class Vector(np.ndarray):
    """An array that mpmath leaves to NumPy at once: it prints others, in vain, before it does."""

    def _mpmath_(self, *_: Any) -> None:
        raise TypeError


class Entry(NamedTuple):
    """One scheme: the parameters that it takes, and what it carries from step to step."""

    name: str
    parameters: tuple[str, ...]
    state: tuple[str, ...]

    @property
    def places(self) -> list[tuple[str, int]]:
        """Of each entry of the state: u, v, a or the name of an auxiliary state, and how many steps back."""
        words = (re.fullmatch(r"(?:h\*|h\^2\*)?(\w+)(?:\[-(?:1/2|(\d+))\])?", label) for label in self.state)
        return [(word[1], int(word[2] or 0)) for word in words if word]

    def step(
        self, state: Sequence[Number], Omega: Number, xi: Number, params: dict, f: Callable[[Number], Number]
    ) -> tuple[tuple, tuple]:
        """The new state, and u, h*v and h^2*a reported at t_{n+1}; f: load per unit mass at t_n + tau h."""
        if not {*self.parameters} <= {*params} <= {*self.parameters, *OPTIONAL.get(self.name, "").split()}:
            raise ValueError(f"{self.name} takes the parameters {self.parameters}, got {tuple(params)}")
        one = 0 * Omega + 1
        unit = np.array([[one]]).view(Vector)
        K = Omega * Omega * unit
        damping = 0 * unit if self.name in UNDAMPED else 2 * xi * Omega * unit
        system = System(
            unit, damping, lambda u: K @ u, lambda u: K, lambda t: f(t) * unit[0], lambda u, w: K @ (u + w) / 2
        )
        known = dict(zip(self.places, state, strict=True))
        lags = range(max(lag for _, lag in self.places), -1, -1)
        rows = [Row(*(known.get((kind, lag), 0) * unit[0] for kind in "uva")) for lag in lags]
        run = Run(self.name, {key: one * value for key, value in params.items()}, system, one, rows[-1])
        run.rows, run.auxiliary = rows, {name: value * unit[0] for (name, _), value in known.items()}
        run.step(self.name)
        new = (rows[-1 - lag]["uva".index(name)] if name in "uva" else run.auxiliary[name] for name, lag in self.places)
        return tuple(x[0] for x in new), tuple(x[0] for x in run.reported())


@cache
def entry(name: str) -> Entry:
    """The scheme of that name."""
    if not written(name):
        return Entry(name, tuple(parameters_of(name).split()), tuple(state_of(name).split()))
    state = STATES.get(name, USUAL)
    if name in tables.TABLES and not tables.carries_acceleration(name):
        state = "u h*v"
    return Entry(name, tuple(PARAMETERS.get(name, "").split()), tuple(state.split()))


def amplification(name: str, Omega: Number, xi: Number, params: dict) -> list[list]:
    """The matrix (list of rows) that takes the state at t_n to the state at t_{n+1} without load."""
    zero = 0 * Omega
    size = range(len(entry(name).state))
    units = [[zero + (1 if i == j else 0) for i in size] for j in size]
    columns = [entry(name).step(unit, Omega, xi, params, lambda tau: zero)[0] for unit in units]
    return [list(row) for row in zip(*columns, strict=True)]


def sample_parameters(name: str, rng: Any) -> dict[str, float]:
    """Random admissible parameters; where a scheme has free parameters, unstable sets are among them."""
    if name == "gholampour":  # delta >= 1/3, delta/2 <= alpha_g <= delta - 1/6
        delta = rng.uniform(1 / 3, 1)
        return {"delta": float(delta), "alpha_g": float(rng.uniform(delta / 2, delta - 1 / 6))}
    if name == "chung_lee":
        return {"beta": float(rng.uniform(1, 28 / 27))}
    if name == "theta_method":
        return {"theta": float(rng.uniform(0, 1))}
    if name == "zhai":
        return {key: float(rng.uniform(0, 1)) for key in ("psi", "phi")}
    ranges = {
        "beta": (0.05, 1), "gamma": (0.3, 1.2), "gamma_t": (0.1, 0.9), "theta": (1, 2), "alpha": (-1 / 3, 0),
        "alpha_B": (-1, 0), "alpha_m": (-1, 0.5), "alpha_f": (0, 0.5), "rho_inf": (0, 1), "p": (0.5, 0.9),
        "phi": (1, 2), "beta1": (0.2, 1), "beta2": (0.2, 1), "weight": (0.25, 1.5),
        **dict.fromkeys(("rho_1", "rho_2", "rho_3", "rho_b", "rho_s"), (0, 1)),
        **dict.fromkeys(("theta_1", "theta_2", "theta_3"), (1, 2)),
        "lambda_g": (0.5, 12), "cubic": (0, 0.5),
    }  # fmt: skip
    return {key: float(rng.uniform(*ranges[key])) for key in entry(name).parameters}
