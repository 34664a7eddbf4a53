"""How the step of a scheme estimates its local error, with numbers for parameters."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

from ..derived import modules
from .scheme_record import SchemeRecord


@dataclass(frozen=True)
class LocalError:
    """terms: of u, then of v, as `local_error_module` has them; weights: their factors; order: p, errors O(h^(p+1)).

    sources: of each symbol of the terms, where its value is known and what it is called there; lag: the power of h with
    which an acceleration in the state differs from the motion's own, None where it does not. A third sum, where there
    is one, is an error of v by the acceleration at the end; always: whether each step needs it, or only one that has
    none before it.
    """

    terms: Any
    weights: tuple[float, ...]
    order: int
    sources: Mapping[str, tuple[str, str]]
    lag: int | None
    always: bool = True


@lru_cache(maxsize=1024)
def local_error(scheme: SchemeRecord, given: tuple[str, ...], damped: bool) -> LocalError:
    """How a step of the scheme, with numbers for parameters, estimates its error; damped: on a scene with damping.

    given: names of the parameters that were not left to their default, which is taken exactly. Raises ValueError for a
    scheme that is not one-step or does not start from u, v and a, and for an estimate that is not finite or is nothing.
    """
    if scheme.info.start != "given" or any(lag for _, lag in scheme.info.history):
        raise ValueError(
            "expected a one-step or composite scheme that starts from u, v, a where steps change, got "
            f"{scheme.name}, which carries {', '.join(scheme.info.state)}; give dt in place of tol, or take another "
            "scheme"
        )
    module = modules.local_error_module(
        scheme.info.source, {name: float(x) for name, x in scheme.given.items()}, damped
    )
    values = [scheme.parameters[name] for name in module.PARAMETERS]
    weights = tuple(float(x) for x in module.weights(*values))
    if not all(map(math.isfinite, weights)) or not any(weights):
        raise ValueError(
            f"expected an estimate of the local error of {scheme.name}, got the weights {weights} at these "
            "parameters; change them, or give dt in place of tol"
        )
    return LocalError(module.TERMS, weights, module.ORDER, module.SOURCES, module.LAG, module.ALWAYS)
