"""Charts of estimators: how much of the true local error they find, over the step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from ..core.schemes import Array, Scheme, scheme
from ..core.schemes import schemes as names
from ..core.style import COLOURS, styled
from ..derived import facade
from ..figures.charts import save, save_csv
from .precision.charts import panels

if TYPE_CHECKING:
    from ..derived.modules import Declaration

SECTION = "The catalogue"
OMEGAS = np.logspace(-1.5, 2, 211)
DAMPED = 0.05
MOST = len(COLOURS) + 1  # schemes of a panel
KNOWN = 1e-14  # a true error below this is rounding


@dataclass(frozen=True)
class Indices:
    """Effectivity indices |estimate|/|true local error| of u and v, and of the filtered estimates; arrays (2, n)."""

    plain: Array
    filtered: Array


def effectivity(s: Scheme, Omega: Array, xi: float = 0.0) -> Indices:
    """Of a scheme at its default parameters, over ascending Omega (n,), on the mode u = 1, h*v = s of the oscillator.

    The state lies in the plane of the scheme's two principal eigenvectors: those whose eigenvalues are followed, from
    the smallest Omega on, from the exact ones; NaN where one of them is lost beside the other by rounding. Raises
    ValueError for a scheme without an estimator, and for an Omega that is not ascending or begins above 1/2, where the
    principal eigenvalues cannot be told apart any more.

    An estimate whose order is below that of the scheme estimates the error of an embedded second value, and is divided
    by that error, since first and second value differ by the estimate. NaN where the true error is below KNOWN.
    """
    declared = s.info.declaration or s.name
    found = facade.estimator_entry(declared)
    if "reason" in found:
        raise ValueError(found["reason"])
    if xi and not s.info.damping:
        raise ValueError(f"{s.name} is a scheme for u'' = g(t, u): expected xi = 0, got {xi}; leave it out")
    if Omega.ndim != 1 or not (np.diff(Omega) > 0).all() or not 0 < Omega[0] <= 0.5:
        raise ValueError(f"expected ascending Omega from a value in (0, 1/2] on, got {Omega}; begin with a small one")
    second = [p < own for p, own in zip(found["order"], _order(declared), strict=False)]
    ratios = np.full((2, Omega.size), np.nan)
    zeta = np.array([-xi + 1j * np.sqrt(1 - xi**2), -xi - 1j * np.sqrt(1 - xi**2)])
    before = np.exp(zeta * Omega[0])
    matrices = s.amplification(Omega, xi)
    live = int((np.abs(np.linalg.eigvals(matrices[0])) > 1e-9).sum())  # the others are 0 at every Omega
    reports = _row(found["reported"], Omega, xi) / _value(found["den"], Omega, xi)[:, None, None]
    estimates = [
        _row(found["estimates"][k : k + 1], Omega, xi)[:, 0] / _value(found["dens"][k], Omega, xi)[:, None]
        for k in range(2)
    ]
    for i, (at, A) in enumerate(zip(Omega, matrices, strict=True)):
        values, vectors = np.linalg.eig(A)
        chosen = _followed(values, before, live)
        before, V = values[chosen], vectors[:, chosen]
        if not before.all():
            continue
        reported = reports[i] @ V
        exact = at * zeta[0]
        weights = np.linalg.solve(reported / before, [1.0, exact])
        error = reported @ weights - np.exp(exact) * np.array([1.0, exact])
        for k in range(2):
            mode = weights / before if found["back"][k] else weights
            estimate = estimates[k][i] @ V @ mode
            true = error[k] + estimate if second[k] else error[k]
            if abs(true) >= KNOWN:
                ratios[k, i] = abs(estimate / true)
    if found["filter"] is None:
        return Indices(ratios, ratios)
    factor = _value(found["filter"][0], Omega, xi) / _value(found["filter"][1], Omega, xi)
    return Indices(ratios, ratios * factor ** np.array(found["filters"])[:, None])


def _order(declared: "str | Declaration") -> tuple[int, int, int]:
    """Orders of accuracy of u, v and a at the default parameters."""
    return facade.order(declared) if isinstance(declared, str) else facade.derived(declared).order


def _followed(values: Array, before: Array, live: int) -> list[int]:
    """The places of the two eigenvalues nearest to the two before, among the `live` largest."""
    largest = np.argsort(-np.abs(values))[:live]
    values = values[largest]
    best = np.abs(values[:, None] - before[None, :])
    pairs = ((best[i, 0] + best[j, 1], i, j) for i in range(values.size) for j in range(values.size) if i != j)
    return [int(largest[k]) for k in min(pairs)[1:]]


def _value(terms: Sequence[tuple[int, int, float]], Omega: Array | float, xi: float) -> Array:
    return sum((c * Omega**p * xi**q for p, q, c in terms), np.zeros(np.shape(Omega)))


def _row(rows: Sequence[Sequence[Any]], Omega: Array | float, xi: float) -> Array:
    """The rows, (rows, m), at Omega; (n, rows, m) at Omega (n,)."""
    found = np.array([[_value(terms, Omega, xi) for terms in row] for row in rows])
    return np.moveaxis(found, -1, 0) if np.ndim(Omega) else found


def effectivity_chart(folder: Path) -> None:
    """Effectivity indices of the default estimators of all schemes, undamped and damped, and filtered."""
    with_one = [name for name in names() if "reason" not in facade.estimator_entry(name)]
    undamped = {name: effectivity(scheme(name), OMEGAS) for name in with_one}
    damped = {name: effectivity(scheme(name), OMEGAS, DAMPED) for name in with_one if scheme(name).info.damping}
    filtered = {name: x for name, x in undamped.items() if facade.estimator_entry(name)["filter"] is not None}
    index = (
        "Effectivity index of the default estimators, the estimate over the true local error of one step, over Ω = ωh"
    )
    second = """Of an embedded pair it is over the error of the second value, which is what the estimate estimates.
        Drawn where the true error is not rounding, at default parameters. Panels: by the kind of the step and the order
        of accuracy."""  # fmt: skip
    _draw(
        folder / "effectivity", {name: x.plain for name, x in undamped.items()}, "undamped",
        f"""{index}, undamped: of u and of v. {second} Each tends to 1 as Ω does to 0, but for the velocity of the
        lagged central differences, to which its estimate is blind without damping.""",
    )  # fmt: skip
    _draw(
        folder / "effectivity_damped", {name: x.plain for name, x in damped.items()}, f"$\\xi$ = {DAMPED}",
        f"{index}, with ξ = {DAMPED}: of u and of v. {second} Each tends to 1 as Ω does to 0.",
    )  # fmt: skip
    _draw(
        folder / "effectivity_filtered", {name: x.filtered for name, x in filtered.items()}, "undamped, filtered",
        f"""{index}, undamped, filtered by the effective stiffness as often as it takes for the estimate to vanish as
        Ω → ∞: of u and of v, of implicit schemes; explicit ones have no filter. {second}""",
    )  # fmt: skip
    columns = {f"{name} {q}": x.plain[k] for name, x in undamped.items() for k, q in enumerate("uv")}
    save_csv(folder / "effectivity.csv", ["Omega", *columns], [OMEGAS, *columns.values()])


@styled
def _draw(path: Path, series: Mapping[str, Array], what: str, caption: str) -> None:
    """Panels of u and v, two groups of schemes in a row, a legend beside each; series: name -> (2, n)."""
    groups = panels(list(series), MOST)
    rows = -(-len(groups) // 2)
    height = 2.3 * rows + 0.9
    figure = Figure(figsize=(16, height), layout="none")  # placed by hand: an engine takes seconds for so many axes
    figure.subplots_adjust(0.045, 0.5 / height, 1.0, 1 - 0.8 / height, 0.08, 0.3)
    grid = figure.subplots(rows, 6, sharex=True, sharey=True, squeeze=False, width_ratios=(1, 1, 1) * 2)
    places = [row[first : first + 3] for row in grid for first in (0, 3)]
    for place, group in zip(places, groups, strict=False):
        *drawn, beside = place
        for axes, quantity, own in zip(drawn, "uv", (0, 1), strict=True):
            axes.axhline(1.0, color="0.5", linewidth=0.8)
            for name in group.names:
                axes.plot(OMEGAS, series[name][own], label=name)
            axes.set(xscale="log", yscale="log", ylim=(1e-2, 1e2))
            axes.minorticks_off()
            axes.set_title(f"${quantity}$: {group.title}", loc="left", fontsize=9)
        handles, labels = drawn[0].get_legend_handles_labels()
        beside.legend(handles, labels, loc="center left", bbox_to_anchor=(-0.1, 0.5), fontsize=7.5)
    for place in places:
        place[-1].axis("off")
    for place in places[len(groups) :]:
        for axes in place:
            axes.axis("off")
    for *drawn, _ in places[len(groups) - 2 : len(groups)]:
        for axes in drawn:
            axes.set_xlabel(r"$\Omega = \omega h$")
            axes.tick_params(labelbottom=True)
    for row in grid:
        row[0].set_ylabel("estimate / error")
    figure.suptitle(f"How much of the true local error the default estimators find: {what}")
    save(figure, path, SECTION, caption)
