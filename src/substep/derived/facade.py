"""Results of the derivation by a scheme's name or declaration: closed forms, certificates, orders, rows of tables.

What never changes is read from generated/; SymPy is imported only when something else is asked for.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from runpy import run_path
from typing import TYPE_CHECKING, Any

from substep_kernels.estimators import ESTIMATORS
from substep_kernels.facts import CATALOGUE

if TYPE_CHECKING:
    from substep_derive import Certificate, Derivation, Estimator, ModifiedMotion, StructuresCertificate
    from substep_derive import Scene as SceneDeclaration
    from substep_derive import Scheme as Declaration
    from substep_derive.motion.turning import Turning
    from substep_derive.stability.conditions import Conditions
    from substep_derive.study.closed_forms import ClosedForm
    from substep_derive.study.equivalence import Equivalence


def certificate(name: "str | Declaration", xi: Any = 0, **parameters: Any) -> "Certificate":
    """The exact stability certificate: see `substep_derive.certify`."""
    from substep_derive import certify  # noqa: PLC0415

    return certify(name, xi=xi, **parameters)


def structures_certificate(name: "str | Declaration", **parameters: Any) -> "StructuresCertificate":
    """Whether it is stable on every structure: see `substep_derive.certify`."""
    from substep_derive import certify  # noqa: PLC0415

    return certify(name, structures=True, **parameters)


def conditions(name: "str | Declaration") -> "Conditions":
    """Stability conditions with the parameters symbolic: see `substep_derive.stability.conditions`."""
    from substep_derive.stability.conditions import conditions as of  # noqa: PLC0415

    return of(name)


def order_conditions(name: "str | Declaration") -> "dict[str, tuple[str, ...]]":
    """Expressions that vanish where u, v and a are of second order, as text.

    See `substep_derive.oscillator.order.order_conditions`.
    """
    from substep_derive.oscillator.order import order_conditions as of  # noqa: PLC0415

    scheme = derived(name).scheme
    return {quantity: tuple(in_paper(e, scheme) for e in found) for quantity, found in of(scheme).items()}


def equivalences(names: "Sequence[str | Declaration]") -> "Iterator[Equivalence]":
    """Pairs of schemes that share their amplification matrix or its spectrum, among those named; none named: all.

    Each is given when it is found, since all take minutes.
    """
    from substep_derive.study.equivalence import equivalences as found  # noqa: PLC0415

    return found([derived(name).scheme for name in names]) if names else found()


def derived(name: "str | Declaration", **parameters: Any) -> "Derivation":
    """Closed forms and orders at exact parameters: see `substep_derive.derive`."""
    from substep_derive import derive  # noqa: PLC0415

    return derive(name, **parameters)


def estimator(name: "str | Declaration", **parameters: Any) -> "Estimator":
    """Estimated local errors, with parameters that are not given as symbols: see `substep_derive.estimator`."""
    from substep_derive import estimator as of  # noqa: PLC0415

    return of(name, **parameters)


def estimator_entry(scheme: "str | Declaration") -> Mapping[str, Any]:
    """A scheme's estimators at its default parameters as plain data, derived for one that is not of the catalogue.

    See `substep_kernels.estimators`.
    """
    if isinstance(scheme, str) and scheme in ESTIMATORS:
        return ESTIMATORS[scheme]
    from substep_derive.declare.catalogue import find  # noqa: PLC0415
    from substep_derive.study.estimates import entry  # noqa: PLC0415

    return entry(find(scheme))


def in_paper(expression: Any, scheme: "Declaration") -> str:
    """An expression in a scheme's parameters as a paper writes it: see `substep_derive.stability.paper`."""
    from substep_derive.stability.paper import PRINTER, as_in_paper  # noqa: PLC0415

    return PRINTER.doprint(as_in_paper(expression, scheme))


def estimator_filter(name: "str | Declaration", **parameters: Any) -> str:
    """The filter of an estimate on stiff components as text; empty for an explicit scheme."""
    from substep_derive.estimate.quality import in_paper as filter_in_paper  # noqa: PLC0415
    from substep_derive.stability.paper import PRINTER  # noqa: PLC0415

    found = filter_in_paper(estimator(name, **parameters).scheme)
    return "" if found is None else PRINTER.doprint(found)


@dataclass(frozen=True)
class CatalogueRow:
    """Properties of a scheme at its default parameters, exact values as text."""

    scheme: str
    order: str
    rho_inf: str
    critical_Omega: str
    critical_curve: str
    A_stable: str
    L_stable: str
    overshoot: str
    bifurcation: str
    nonlinear_order: str
    eigenvalue_order: str
    symmetric: str
    symplectic: str
    conjugate_symplectic: str


def order(name: str) -> tuple[int, int, int]:
    """Orders of accuracy of u, v and a at the default parameters of a scheme of the catalogue."""
    return CATALOGUE[name]["order"]


def catalogue_row(name: str) -> CatalogueRow:
    """A scheme's row in the table of the catalogue, from generated/: see `substep_derive.study.facts.row`."""
    row = {key: CATALOGUE[name][key] for key in (f.name for f in fields(CatalogueRow)) if key != "scheme"}
    triples = {key: ", ".join(map(str, row[key])) for key in ("order", "nonlinear_order")}
    return CatalogueRow(name, **{**row, **triples, "eigenvalue_order": str(row["eigenvalue_order"])})


def fact_row(scheme: "str | Declaration", **parameters: Any) -> Mapping[str, Any]:
    """A scheme's properties as in CATALOGUE of `substep_kernels.facts`, from there or, for others than these, derived.

    parameters: exact; see `substep_derive.study.facts.row`. Raises DeclarationError as `derived` does.
    """
    if isinstance(scheme, str) and not parameters:
        return CATALOGUE[scheme]
    from substep_derive.study.facts import row  # noqa: PLC0415

    return row(derived(scheme, **parameters).scheme)


def declaration(file: Path, name: str) -> "Declaration":
    """The scheme of that name in a Python file of the user's own, which is run.

    Raises FileNotFoundError where there is no such file, ValueError where it has no declaration of that name.
    """
    from substep_derive import Scheme  # noqa: PLC0415

    found = run_path(str(file))
    schemes = {key: value for key, value in found.items() if isinstance(value, Scheme)}
    if name not in schemes:
        known = ", ".join(schemes) or "none"
        raise ValueError(f"expected the name of a declaration in {file}, got '{name}'; it declares: {known}")
    return schemes[name]


@dataclass(frozen=True)
class RigidEnergy:
    """Relative energy change a step on the stiff pendulum's rigid limit: power of h v0/L -> coefficient, as text.

    first: the change in the first step, from steady rotation; settled: in every later step. sign_changes: values of
    the one parameter left free at which the settled coefficient of lowest power changes sign, ascending.
    """

    first: Mapping[int, str]
    settled: Mapping[int, str]
    sign_changes: tuple[float, ...]


def rigid_energy(name: str, **parameters: Any) -> RigidEnergy:
    """Energy change of a scheme with the given parameters fixed, exact: see `substep_derive.motion.rigid_limit`."""
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


def modified_motion(
    scheme: "str | Declaration", scene: "str | SceneDeclaration", given: tuple[Any, ...]
) -> "ModifiedMotion":
    """The modified motion of a scene by a scheme; given: pairs of a parameter's name and exact value.

    Raises DeclarationError where there is none: see `substep_derive.ModifiedMotion`.
    """
    from substep_derive import ModifiedMotion  # noqa: PLC0415
    from substep_derive.declare.catalogue import find, find_scene  # noqa: PLC0415

    return ModifiedMotion.to_its_loss(find(scheme), find_scene(scene), **dict(given))


def turning(name: "str | Declaration", **parameters: Any) -> "Turning":
    """What becomes of errors along a very stiff bar that turns: see `substep_derive.turning`."""
    from substep_derive import turning as of  # noqa: PLC0415

    return of(name, **parameters)


def closed_forms(name: "str | Declaration", part: str = "all") -> "Iterator[ClosedForm]":
    """What is derived about a scheme, as named forms: see `substep_derive.study.closed_forms`."""
    from substep_derive.study.closed_forms import closed_forms as derived  # noqa: PLC0415

    return derived(name, part)
