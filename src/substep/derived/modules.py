"""Modules that are not committed: own schemes and scenes, pairs of scheme and scene, shapes of the linear march.

For what the catalogue names, SymPy and its declarations are imported only where a module has to be printed.
"""

from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

from .module_cache import cached_module
from .simple_fraction import simple_fraction

if TYPE_CHECKING:
    import substep_derive
    from substep_derive.motion.equations import EquationsOfMotion

    Declaration = substep_derive.Scheme
    SceneDeclaration = substep_derive.Scene
    LawDeclaration = substep_derive.Law


def own_plan_module(declaration: "Declaration") -> ModuleType:
    """The plan of a declared scheme on a structure: from the cache, or derived and kept there.

    Raises DeclarationError for coefficients that a plan has no systems for.
    """
    from substep_derive.declare.digest import scheme_digest  # noqa: PLC0415
    from substep_derive.emit.first_use import own_plan  # noqa: PLC0415

    return cached_module(f"plan {scheme_digest(declaration)}", lambda: own_plan(declaration))


def scheme_module(scheme: "str | Declaration") -> ModuleType:
    """The module, with its index entry as ENTRY, of a scheme that is not committed: from the cache, or derived now.

    Raises DeclarationError for a declaration that does not define one step, PermissionError where `cache_folder` does.
    """

    def text() -> str:
        from substep_derive.declare.catalogue import find  # noqa: PLC0415
        from substep_derive.emit.scheme_module import own_module  # noqa: PLC0415

        return own_module(find(scheme))

    return cached_module(f"scheme {_scheme(scheme)}", text)


def plan_module(name: str) -> ModuleType:
    """The plan of a scheme of the catalogue that is not committed: from the cache, or derived now.

    Raises DeclarationError where `own_plan_module` does.
    """

    def text() -> str:
        from substep_derive.declare.catalogue import find  # noqa: PLC0415
        from substep_derive.emit.first_use import own_plan  # noqa: PLC0415

        return own_plan(find(name))

    return cached_module(f"plan {name}", text)


def scene_module(scene: "str | SceneDeclaration") -> ModuleType:
    """The module, with its index entry as ENTRY, of a scene that is not committed: from the cache, or derived now.

    Raises DeclarationError for energies that do not define a motion.
    """

    def text() -> str:
        from substep_derive.declare.catalogue import find_scene  # noqa: PLC0415
        from substep_derive.emit.first_use import own_scene  # noqa: PLC0415

        return own_scene(find_scene(scene))

    return cached_module(f"scene {_scene(scene)}", text)


def own_law_module(declaration: "LawDeclaration") -> ModuleType:
    """The module of a declared law: from the cache, or derived and kept there."""
    from substep_derive.declare.digest import law_digest  # noqa: PLC0415
    from substep_derive.emit.law_module import law_module  # noqa: PLC0415

    return cached_module(f"law {law_digest(declaration)}", lambda: law_module(declaration))


def spring_march_module(lanes: int) -> ModuleType:
    """Kernels of the march of small structures with springs of laws, so many side by side."""

    def text() -> str:
        from substep_derive.emit.first_use import spring_march  # noqa: PLC0415

        return spring_march(lanes)

    return cached_module(f"spring march {lanes}", text)


@cache
def oscillator_with(law: "str | LawDeclaration") -> "SceneDeclaration":
    """The declaration of the oscillator of unit mass with a law. Raises DeclarationError for an unknown one."""
    from substep_derive.declare.catalogue import find_law  # noqa: PLC0415
    from substep_derive.declare.scenes.hysteretic import hysteretic_oscillator  # noqa: PLC0415

    return hysteretic_oscillator(find_law(law))


def uncommitted_pair(scheme: "str | Declaration", scene: "str | SceneDeclaration") -> ModuleType:
    """Kernels of a scheme on a scene, named or declared, that are not committed: from the cache, or printed now."""

    def text() -> str:
        from substep_derive.emit.first_use import catalogue_pair  # noqa: PLC0415

        return catalogue_pair(*_declared(scheme, scene))

    return cached_module(f"pair {_scheme(scheme)} {_scene(scene)}", text)


def pair_in_threads(scheme: "str | Declaration", scene: "str | SceneDeclaration") -> ModuleType:
    """The kernel of a scheme on a scene in the threads of a GPU: from the cache, or printed now."""

    def text() -> str:
        from substep_derive.emit.first_use import pair_in_threads as printed  # noqa: PLC0415

        return printed(*_declared(scheme, scene))

    return cached_module(f"threads {_scheme(scheme)} {_scene(scene)}", text)


def march_in_threads(name: str, K: int) -> ModuleType:
    """The kernel of a shape of the linear march in the threads of a GPU: from the cache, or printed now."""

    def text() -> str:
        from substep_derive.emit.march_module import march_threads  # noqa: PLC0415
        from substep_derive.kernels.march_shape import shape_of  # noqa: PLC0415

        return march_threads(shape_of(name), K)

    return cached_module(f"threads {name} {K}", text)


def filter_in_threads(order: int, followed: int) -> ModuleType:
    """The kernel of digital filters in the threads of a GPU: from the cache, or printed now."""

    def text() -> str:
        from substep_derive.emit.filter_module import filter_threads  # noqa: PLC0415

        return filter_threads(order, followed)

    return cached_module(f"threads filter {order} {followed}", text)


def in_single_precision(module: ModuleType) -> ModuleType:
    """A module of kernels in single precision: from the cache, or printed now from the text of that module."""

    def text() -> str:
        from substep_derive.emit.single import in_single  # noqa: PLC0415

        return in_single(Path(module.__file__ or "").read_text(encoding="utf-8"))

    return cached_module(f"single {module.__name__}", text)


def march_module(name: str, K: int, single: bool = False) -> ModuleType:
    """Kernels of a linear march whose shape, or number of load instants, no scheme of the catalogue has.

    single: those in single precision, of any.
    """
    from substep_derive.emit.march_module import march_in_single  # noqa: PLC0415
    from substep_derive.emit.march_module import march_module as printed  # noqa: PLC0415
    from substep_derive.kernels.march_shape import shape_of  # noqa: PLC0415

    if single:
        return cached_module(f"single {name} {K}", lambda: march_in_single(shape_of(name), K))
    return cached_module(f"{name} {K}", lambda: printed(shape_of(name), (K,)))


def eigenvalues_module(name: str) -> ModuleType:
    """Kernels that find more eigenvalues than any scheme of the catalogue has."""
    from substep_derive.emit.stability_module import eigenvalues_module as printed  # noqa: PLC0415
    from substep_derive.kernels.eigenvalue_kind import EigenvalueKind  # noqa: PLC0415

    return cached_module(name, lambda: printed(EigenvalueKind.named(name)))


def local_error_module(scheme: "str | Declaration", given: Mapping[str, float], damped: bool) -> ModuleType:
    """How a scheme's local error is estimated at the parameters given, others at their default, with damping or not.

    Parameters are taken as the simplest fractions that their floats stand for, since an order of accuracy may hold at
    exact values alone. Raises NoEstimator, a ValueError, for a scheme without an estimate from what a step holds.
    """

    def text() -> str:
        from substep_derive.declare.catalogue import find  # noqa: PLC0415
        from substep_derive.emit.first_use import local_error  # noqa: PLC0415

        mine, exact = find(scheme), dict[str, Any]()
        for p in mine.parameters:
            if p.name in given:
                simple = simple_fraction(given[p.name])
                exact[p.name] = Fraction(repr(given[p.name])) if simple is None else simple
            elif getattr(default := p.default.subs(exact), "is_Rational", False):  # what is irrational stays a symbol
                exact[p.name] = default
        return local_error(mine, exact, damped=damped)

    return cached_module(f"local error {_scheme(scheme)} {sorted(given.items())} {damped}", text)


def turning_step(scheme: "str | Declaration") -> ModuleType:
    """The equations of a step on a stiff bar that turns: from the cache, or derived now.

    Raises DeclarationError as `substep_derive.motion.turning.TurningStep.of`.
    """

    def text() -> str:
        from substep_derive.declare.catalogue import find  # noqa: PLC0415
        from substep_derive.emit.first_use import turning  # noqa: PLC0415

        return turning(find(scheme))

    return cached_module(f"turning {_scheme(scheme)}", text)


def adaptive_pair(
    scheme: "str | Declaration", scene: "str | SceneDeclaration", terms: Any, order: int, always: bool,
    threads: bool = False,
) -> ModuleType:  # fmt: skip
    """Kernels of a scheme on a scene in steps of chosen length: from the cache, or printed now.

    terms, order, always: of the local error's estimate, as `local_error_module` has them. threads: whether for the
    threads of a GPU. Raises DeclarationError for a scheme whose step cannot change.
    """

    def text() -> str:
        from substep_derive.emit.first_use import adaptive_pair as printed  # noqa: PLC0415

        return printed(*_declared(scheme, scene), terms, order, always, threads)

    layout = "adaptive threads" if threads else "adaptive"
    return cached_module(f"{layout} {_scheme(scheme)} {_scene(scene)} {terms} {order} {always}", text)


def _declared(scheme: "str | Declaration", scene: "str | SceneDeclaration") -> "tuple[Declaration, EquationsOfMotion]":
    from substep_derive.declare.catalogue import find  # noqa: PLC0415

    return find(scheme), _motion(scene)


@cache
def _motion(scene: "str | SceneDeclaration") -> "EquationsOfMotion":
    """The equations of a scene, which the pairs of all schemes with it share: deriving them takes a while."""
    from substep_derive.declare.catalogue import find_scene  # noqa: PLC0415
    from substep_derive.motion.equations import EquationsOfMotion  # noqa: PLC0415

    return EquationsOfMotion(find_scene(scene))


def _scheme(scheme: "str | Declaration") -> str:
    """What tells a scheme from others: its digest or, in the catalogue, its name, since the generator's version that is
    part of every key depends on the catalogue's declarations.
    """
    if isinstance(scheme, str):
        return scheme
    from substep_derive.declare.digest import scheme_digest  # noqa: PLC0415

    return scheme_digest(scheme)


def _scene(scene: "str | SceneDeclaration") -> str:
    """What tells a scene from others, as for a scheme."""
    if isinstance(scene, str):
        return scene
    from substep_derive.declare.digest import scene_digest  # noqa: PLC0415

    return scene_digest(scene)
