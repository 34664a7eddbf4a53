"""The one door back to the derivation: closed forms, certificates, and kernels of one's own and of uncommitted pairs.

SymPy is imported here and nowhere else, when a function is called. A user's module is printed to a real
file in the user's cache, so that numba can cache what it compiles, and imported from there.
"""

import hashlib
import importlib.util
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any

import platformdirs

if TYPE_CHECKING:
    from substep_derive import Certificate, Derivation
    from substep_derive import Scene as SceneDeclaration
    from substep_derive import Scheme as Declaration
    from substep_derive.oscillator.overshoot import Overshoot
    from substep_derive.stability.conditions import Conditions
    from substep_derive.study.closed_forms import ClosedForm
    from substep_derive.study.equivalence import Equivalence


def cache_folder() -> Path:
    """Folder of the user's own modules: $SUBSTEP_CACHE, or the platform's cache folder; made if missing.

    Raises PermissionError if others own it or may write to it, for what lies there is run as code.
    """
    folder = Path(os.environ.get("SUBSTEP_CACHE") or platformdirs.user_cache_dir("substep"))
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    found = folder.stat()
    if hasattr(os, "getuid") and (found.st_uid != os.getuid() or found.st_mode & 0o022):
        raise PermissionError(
            f"expected the cache folder {folder} to be yours alone, got owner {found.st_uid} and mode "
            f"{found.st_mode & 0o777:o}; run chmod 700 on it, or set SUBSTEP_CACHE to a folder of your own"
        )
    return folder


@cache
def _generator_version() -> str:
    """Digest of the generator's own source: another generator prints other text."""
    import substep_derive  # noqa: PLC0415

    folder = Path(substep_derive.__file__).parent
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.read_bytes())
    return digest.hexdigest()


def own_entry(declaration: "Declaration") -> tuple[str, Mapping[str, Any]]:
    """(name, index entry) of a declared scheme, whose module is taken from the cache or derived and kept there.

    Raises DeclarationError for a declaration that does not define one step, PermissionError as `cache_folder`.
    """
    from substep_derive.declare.digest import scheme_digest  # noqa: PLC0415
    from substep_derive.emit.scheme_module import own_module  # noqa: PLC0415

    module = _cached(scheme_digest(declaration), lambda: own_module(declaration))
    return declaration.name, {**module.ENTRY, "module": module, "declaration": declaration}


def own_scene_entry(declaration: "SceneDeclaration") -> tuple[str, Mapping[str, Any]]:
    """The same of a declared scene. Raises DeclarationError for energies that do not define a motion."""
    from substep_derive.declare.digest import scene_digest  # noqa: PLC0415
    from substep_derive.package import own_scene  # noqa: PLC0415

    module = _cached(scene_digest(declaration), lambda: own_scene(declaration))
    return declaration.name, {**module.ENTRY, "module": module, "declaration": declaration}


def pair_module(scheme: "str | Declaration", scene: "str | SceneDeclaration") -> ModuleType:
    """Kernels of a scheme on a scene, named or declared, that are not committed: from the cache, or printed now."""
    from substep_derive.declare.catalogue import find, find_scene  # noqa: PLC0415
    from substep_derive.declare.digest import scene_digest, scheme_digest  # noqa: PLC0415
    from substep_derive.motion.equations import Motion  # noqa: PLC0415
    from substep_derive.package import catalogue_pair  # noqa: PLC0415

    mine, theirs = find(scheme), find_scene(scene)
    return _cached(scheme_digest(mine) + scene_digest(theirs), lambda: catalogue_pair(mine, Motion(theirs)))


def march_module(name: str, K: int) -> ModuleType:
    """Kernels of a linear march whose shape, or number of load instants, no scheme of the catalogue has."""
    from substep_derive.emit.march_module import march_module as printed  # noqa: PLC0415
    from substep_derive.kernels.march_shape import shape_of  # noqa: PLC0415

    return _cached(f"{name} {K}", lambda: printed(shape_of(name), (K,)))


def _cached(declared: str, text: Callable[[], str]) -> ModuleType:
    """The module whose declarations have that digest, printed by text if the cache has no whole file of it."""
    module_name = f"substep_own_{hashlib.sha256((_generator_version() + declared).encode()).hexdigest()[:24]}"
    module = sys.modules.get(module_name)
    if module is None:
        path = cache_folder() / f"{module_name}.py"
        if not _intact(path):
            _write(path, text())
        module = _load(module_name, path)
    return module


def _intact(path: Path) -> bool:
    """Whether the file is there and its first line is the sha256 of the rest."""
    try:
        first, rest = path.read_text(encoding="utf-8").split("\n", 1)
    except (FileNotFoundError, ValueError):
        return False
    return first == "# sha256 " + hashlib.sha256(rest.encode()).hexdigest()


def _write(path: Path, text: str) -> None:
    """Other processes see the old file or the whole new one."""
    checked = "# sha256 " + hashlib.sha256(text.encode()).hexdigest() + "\n" + text
    with tempfile.NamedTemporaryFile("w", dir=path.parent, delete=False, encoding="utf-8", newline="\n") as file:
        file.write(checked)
    Path(file.name).replace(path)


def _load(name: str, path: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"expected a Python module at {path}; remove the file and try again")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module  # before it runs: numba's cache looks functions up by their module
    try:
        spec.loader.exec_module(module)
    except BaseException:
        del sys.modules[name]
        raise
    return module


def certificate(name: str, xi: Any = 0, **parameters: Any) -> "Certificate":
    """The exact stability certificate: see `substep_derive.certify`."""
    from substep_derive import certify  # noqa: PLC0415

    return certify(name, xi=xi, **parameters)


def conditions(name: str) -> "Conditions":
    """Stability conditions with the parameters symbolic: see `substep_derive.stability.conditions`."""
    from substep_derive.stability.conditions import conditions as of  # noqa: PLC0415

    return of(name)


def order_conditions(name: str) -> "dict[str, tuple[Any, ...]]":
    """What must vanish for u, v and a to be of second order: see `substep_derive.oscillator.order.order_conditions`."""
    from substep_derive.oscillator.order import order_conditions as of  # noqa: PLC0415

    return of(derived(name).amplification)


def equivalences(names: Sequence[str]) -> "tuple[Equivalence, ...]":
    """Pairs that share matrix or spectrum, among the named schemes or, for none named, all."""
    from substep_derive.study.equivalence import equivalences as found  # noqa: PLC0415

    return found([derived(name).scheme for name in names]) if names else found()


def derived(name: str, **parameters: Any) -> "Derivation":
    """Closed forms and orders at exact parameters: see `substep_derive.derive`."""
    from substep_derive import derive  # noqa: PLC0415

    return derive(name, **parameters)


@dataclass(frozen=True)
class CatalogueRow:
    """A scheme at its default parameters, exact values as text."""

    scheme: str
    order: str
    rho_inf: str
    critical_Omega: str
    critical_curve: str
    A_stable: str
    L_stable: str
    overshoot: str
    bifurcation: str


@cache
def order(name: str) -> tuple[int, int, int]:
    """Of u, v and a, at the scheme's default parameters."""
    from substep_derive import Derivation  # noqa: PLC0415
    from substep_derive.study.derivation import at_defaults  # noqa: PLC0415

    return Derivation(at_defaults(derived(name).scheme)).order


def catalogue_row(name: str) -> CatalogueRow:
    """Derived: see `substep_derive.study.profile.profile`."""
    from substep_derive.study.profile import profile  # noqa: PLC0415

    p = profile(derived(name).scheme)
    critical = "none" if p.critical_Omega is None else str(p.critical_Omega)
    curve = "" if p.critical_curve is None else str(p.critical_curve)
    A, L = ({True: "yes", False: "no", None: "open"}[x] for x in (p.A_stable, p.L_stable))
    order = ", ".join(map(str, p.order))
    ends = (f"{float(x):.6g}" if x.is_finite else "oo" for x in (p.rho_inf, p.bifurcation))
    rho, bifurcation = ends
    return CatalogueRow(name, order, rho, critical, curve, A, L, str(p.overshoot), bifurcation)


def second_order_betas(rho_inf: Fraction, gamma_t: Fraction) -> list[float]:
    """Beta of newmark_bdf2 of second order, stable for every Omega, of that rho_inf: `substep_derive.study.design`."""
    from substep_derive.study.design import region  # noqa: PLC0415

    curves = [(float(r.beta.subs("gamma_t", gamma_t)), r.intervals) for r in region(rho_inf)]
    return [beta for beta, cells in curves if any(float(low) < gamma_t < float(high) for low, high, *_ in cells)]


def overshoot(name: str) -> "Overshoot":
    """Overshoot class of a scheme at almost all parameters."""
    from substep_derive.oscillator.overshoot import overshoot as of  # noqa: PLC0415

    return of(derived(name).amplification)


@dataclass(frozen=True)
class RigidEnergy:
    """Relative energy change a step on the stiff pendulum's rigid limit: power of h v0/L -> coefficient, as text.

    first: of the step from steady rotation; settled: of every later one. sign_changes: where the settled
    coefficient of lowest power changes sign in the one parameter left free, ascending.
    """

    first: Mapping[int, str]
    settled: Mapping[int, str]
    sign_changes: tuple[float, ...]


def rigid_energy(name: str, **parameters: Any) -> RigidEnergy:
    """Closed forms with the given parameters fixed, exact: see `substep_derive.motion.rigid_limit`."""
    from substep_derive.motion import rigid_limit  # noqa: PLC0415

    scheme = derived(name).scheme
    scheme = scheme.fix(parameters) if parameters else scheme
    first, settled = rigid_limit.energy_change(scheme, 4), rigid_limit.settled_energy_change(scheme)
    changes: tuple[float, ...] = ()
    if settled and len(scheme.parameters) == 1:
        found = rigid_limit.sign_changes(settled[min(settled)], scheme.parameters[0])
        changes = tuple(float(root) for root in found)
    texts = ({power: str(e) for power, e in series.items()} for series in (first, settled))
    return RigidEnergy(*texts, changes)


def thesis() -> ModuleType:
    """The thesis's printed formulas and what derivation says of them: `substep_derive.study.thesis`."""
    from substep_derive.study import thesis as printed  # noqa: PLC0415

    return printed


def at_rest(expression: Any) -> Any:
    """A derived expression at xi = 0, factored."""
    from substep_derive.declare.symbols import xi  # noqa: PLC0415

    return expression.subs(xi, 0).factor()


def number(expression: Any, **values: Fraction) -> Fraction:
    """A derived expression at exact parameters."""
    from substep_derive.algebra.exact_number import exact_number  # noqa: PLC0415

    found = expression.subs({name: exact_number(value) for name, value in values.items()})
    return Fraction(int(found.p), int(found.q))


def closed_forms(name: str) -> "list[ClosedForm]":
    """Everything derived about a scheme: see `substep_derive.study.closed_forms`."""
    from substep_derive.study.closed_forms import closed_forms as derived  # noqa: PLC0415

    return derived(name)


@dataclass(frozen=True)
class Properties:
    """Exact properties of one parameter set, undamped: rho_inf, order, leading error terms."""

    rho_inf: Any
    order: int
    damping: tuple[int, Any] | None
    period: tuple[int, Any] | None


def properties(name: str, parameters: Mapping[str, Fraction]) -> Properties:
    """rho_inf, order of the free vibration, and the first term (power of Omega, coefficient) of each error."""
    from substep_derive import derive  # noqa: PLC0415
    from substep_derive.declare.symbols import xi  # noqa: PLC0415

    d = derive(name, **parameters)

    def first(terms: Mapping[int, Any]) -> tuple[int, Any] | None:
        at_rest = ((power, coefficient.subs(xi, 0)) for power, coefficient in sorted(terms.items()))
        return next(((power, value) for power, value in at_rest if value != 0), None)

    return Properties(d.rho_inf, d.series.order, first(d.series.numerical_damping), first(d.series.period_error))
