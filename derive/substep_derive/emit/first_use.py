"""Texts of the modules that are printed on first use: pairs, estimates of local errors, a user's schemes and scenes.

Nothing here waits for the catalogue, which takes longer to declare than a pair takes to print.
"""

import hashlib
from collections.abc import Mapping
from typing import Any

from ..declare.digest import scene_digest, scheme_digest
from ..declare.names import check_pair
from ..declare.scene import Scene
from ..declare.scheme import Scheme
from ..kernels.body import Body
from ..kernels.estimated_body import EstimatedBody
from ..kernels.local_error import LocalError, Terms
from ..motion.effective import effective_systems
from ..motion.equations import EquationsOfMotion
from ..motion.turning import TurningStep
from .adaptive_module import adaptive_module, adaptive_threads
from .gpu_thread import pair_threads
from .local_error_module import local_error_module
from .pair_module import pair_module
from .plan_module import plan_module
from .printing import fill, with_banner
from .scene_module import scene_entry, scene_module
from .templates.elementary import CALL, CALL_IMPORTS
from .templates.scheme import BANNER
from .templates.several_numbers import SEVERAL_NUMBERS
from .templates.small_matrices import SMALL_MATRICES
from .templates.spring_march import SPRING_MARCH
from .templates.spring_newton import SPRING_NEWTON
from .turning_module import turning_module


def catalogue_pair(scheme: Scheme, motion: EquationsOfMotion) -> str:
    """Text of the module that marches the scheme on the scene."""
    body = Body.of(*_in_kernels(scheme, motion))
    return pair_module(body, effective_systems(scheme), _banner_of_pair(scheme, motion))


def pair_in_threads(scheme: Scheme, motion: EquationsOfMotion) -> str:
    """Text of the module that marches the scheme on the scene in the threads of a GPU."""
    return pair_threads(Body.of(*_in_kernels(scheme, motion)), _banner_of_pair(scheme, motion))


def adaptive_pair(
    scheme: Scheme, motion: EquationsOfMotion, terms: Terms, order: int, always: bool = True, threads: bool = False
) -> str:
    """Text of the module that marches the scheme on the scene in steps that it chooses.

    terms, order, always: of `LocalError`. threads: whether in those of a GPU.

    Raises DeclarationError for a scheme whose step cannot change.
    """
    body = EstimatedBody.of(*_in_kernels(scheme, motion), terms, order, always)
    return (adaptive_threads if threads else adaptive_module)(body, _banner_of_pair(scheme, motion))


def local_error(scheme: Scheme, exact: Mapping[str, Any], *, damped: bool) -> str:
    """Text of the module that says how a scheme's local error is estimated, with these parameters fixed.

    damped: whether the estimate has to hold with damping.

    Raises NoEstimator for a scheme without an estimate from what a step holds.
    """
    return local_error_module(LocalError.of(scheme, exact, damped=damped))


def turning(scheme: Scheme) -> str:
    """Text of the module with the equations of a step on a stiff bar that turns.

    Raises DeclarationError as `TurningStep.of`.
    """
    return turning_module(TurningStep.of(scheme.in_doubles))


def spring_march(lanes: int) -> str:
    """Text of the module that marches small structures with springs of laws, so many side by side."""
    products = SEVERAL_NUMBERS + SMALL_MATRICES
    given = {"imports": CALL_IMPORTS, "call": fill(CALL), "products": products, "newton": SPRING_NEWTON}
    text = fill(SPRING_MARCH, lanes=lanes, **given)
    return with_banner("substep_derive", text)


def own_plan(scheme: Scheme) -> str:
    """Text of the plan of a scheme of the user's own, on a structure."""
    return plan_module(scheme, f"the declaration of {scheme.name}")


def own_scene(scene: Scene) -> str:
    """Text of a module for a scene of the user's own: as a committed one, with its index entry as ENTRY."""
    motion = EquationsOfMotion(scene)
    return f"{scene_module(motion)}\n\nENTRY = {scene_entry(motion)}\n"


def _in_kernels(scheme: Scheme, motion: EquationsOfMotion) -> tuple[Scheme, EquationsOfMotion]:
    check_pair(scheme.name, motion.scene.name, scheme.values, [p.symbol for p in motion.scene.parameters])
    return scheme.in_kernels, motion.in_kernels


def _banner_of_pair(scheme: Scheme, motion: EquationsOfMotion) -> str:
    """Banner with the sha256 of the digests of both declarations."""
    both = hashlib.sha256((scheme_digest(scheme) + scene_digest(motion.scene)).encode()).hexdigest()
    return fill(BANNER, source=f"the declarations of {scheme.name} and {motion.scene.name}", digest=both)
