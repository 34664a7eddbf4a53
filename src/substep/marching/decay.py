"""What is refused of schemes on constraints and contacts: errors that grow there, and reactions that move nothing."""

import math

import numpy as np

from ..core.facts import facts_at_defaults
from ..core.schemes import Scheme


def require_decay(held: str, scheme: Scheme) -> None:
    """Raises ValueError for a scheme that multiplies what a start has wrong, or rounding, on a constraint or contact.

    That is by its spectral radius at infinity, as a constraint is an infinitely stiff spring; at any of its parameters.
    It is infinite where these make a scheme explicit that is not declared so, as beta = 0 makes Newmark's: its
    reactions act where it then moves nothing. held: what has these.
    """
    if scheme.rho_inf is None:
        return
    radii = np.ravel(scheme.rho_inf)
    if np.isinf(radii).any() and facts_at_defaults(scheme.name).iterated:
        k = int(np.argmax(np.isinf(radii)))
        at = {name: float(np.ravel(x)[k if np.size(x) > 1 else 0]) for name, x in scheme.parameters.items()}
        zero = {name: x for name, x in at.items() if x == 0.0} or at
        raise ValueError(
            f"expected a scheme for {held} that moves the displacement at which it takes the force, got {scheme.name} "
            f"at {', '.join(f'{name} = {x:g}' for name, x in zero.items())}, which makes it explicit, so that no "
            "reaction acts there; take other parameters, or a scheme that is declared as explicit, such as "
            "central_difference"
        )
    if (growing := radii[(radii > 1.0 + 1e-9) & (radii < math.inf)]).size:
        raise ValueError(
            f"expected a scheme for {held} that damps errors along its constraints, got {scheme.name}, which "
            f"multiplies them by {growing.max():.4g} in each step; take one with rho_inf <= 1"
        )
