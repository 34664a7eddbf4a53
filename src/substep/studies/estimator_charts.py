"""Charts of estimators: how much of the true local error they find, over the step."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ..core.schemes import Array, Scheme, scheme
from ..core.schemes import schemes as names
from ..derived import facade
from ..figures.charts import curves, save, save_csv

SECTION = "The catalogue"
OMEGAS = np.logspace(-1.5, 2, 211)
DAMPED = 0.05


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
    """
    found = facade.estimator_entry(s.info.declaration or s.name)
    if "reason" in found:
        raise ValueError(found["reason"])
    if xi and not s.info.damping:
        raise ValueError(f"{s.name} is a scheme for u'' = g(t, u): expected xi = 0, got {xi}; leave it out")
    if Omega.ndim != 1 or not (np.diff(Omega) > 0).all() or not 0 < Omega[0] <= 0.5:
        raise ValueError(f"expected ascending Omega from a value in (0, 1/2] on, got {Omega}; begin with a small one")
    ratios = np.full((2, Omega.size), np.nan)
    zeta = np.array([-xi + 1j * np.sqrt(1 - xi**2), -xi - 1j * np.sqrt(1 - xi**2)])
    before = np.exp(zeta * Omega[0])
    matrices = s.amplification(Omega, xi)
    live = int((np.abs(np.linalg.eigvals(matrices[0])) > 1e-9).sum())  # the others are 0 at every Omega
    for i, (at, A) in enumerate(zip(Omega, matrices, strict=True)):
        values, vectors = np.linalg.eig(A)
        chosen = _followed(values, before, live)
        before, V = values[chosen], vectors[:, chosen]
        if not before.all():
            continue
        reported = _row(found["reported"], at, xi) / _value(found["den"], at, xi) @ V
        exact = at * zeta[0]
        weights = np.linalg.solve(reported / before, [1.0, exact])
        error = reported @ weights - np.exp(exact) * np.array([1.0, exact])
        for k in range(2):
            row = _row(found["estimates"][k : k + 1], at, xi)[0] / _value(found["dens"][k], at, xi)
            mode = weights / before if found["back"][k] else weights
            ratios[k, i] = abs(row @ V @ mode / error[k])
    if found["filter"] is None:
        return Indices(ratios, ratios)
    factor = np.array([_value(found["filter"][0], x, xi) / _value(found["filter"][1], x, xi) for x in Omega])
    return Indices(ratios, ratios * factor ** np.array(found["filters"])[:, None])


def _followed(values: Array, before: Array, live: int) -> list[int]:
    """The places of the two eigenvalues nearest to the two before, among the `live` largest."""
    largest = np.argsort(-np.abs(values))[:live]
    values = values[largest]
    best = np.abs(values[:, None] - before[None, :])
    pairs = ((best[i, 0] + best[j, 1], i, j) for i in range(values.size) for j in range(values.size) if i != j)
    return [int(largest[k]) for k in min(pairs)[1:]]


def _value(terms: Sequence[tuple[int, int, float]], Omega: float, xi: float) -> float:
    return sum(c * Omega**p * xi**q for p, q, c in terms)


def _row(rows: Sequence[Sequence[Any]], Omega: float, xi: float) -> Array:
    return np.array([[_value(terms, Omega, xi) for terms in row] for row in rows])


def effectivity_chart(folder: Path) -> None:
    """Effectivity indices of the default estimators of all schemes, undamped and damped, and filtered."""
    with_one = [name for name in names() if "reason" not in facade.estimator_entry(name)]
    undamped = {name: effectivity(scheme(name), OMEGAS) for name in with_one}
    damped = {name: effectivity(scheme(name), OMEGAS, DAMPED) for name in with_one if scheme(name).info.damping}
    figure = Figure(figsize=(14, 9.5), layout="constrained")
    panels: Mapping[str, Any] = {
        "(a) u, undamped": {name: x.plain[0] for name, x in undamped.items()},
        "(b) v, undamped": {name: x.plain[1] for name, x in undamped.items()},
        f"(c) u, $\\xi$ = {DAMPED}": {name: x.plain[0] for name, x in damped.items()},
        f"(d) v, $\\xi$ = {DAMPED}": {name: x.plain[1] for name, x in damped.items()},
        "(e) u, filtered": {name: x.filtered[0] for name, x in undamped.items()},
        "(f) v, filtered": {name: x.filtered[1] for name, x in undamped.items()},
    }
    grid = figure.subplots(2, 3).T.ravel()
    for axes, (title, series) in zip(grid, panels.items(), strict=True):
        curves(axes, OMEGAS, series, x_label=r"$\Omega = \omega h$", y_label="estimate / true local error")
        axes.set(xscale="log", yscale="log", ylim=(1e-3, 1e3))
        axes.set_title(title, loc="left", fontsize=10)
    figure.suptitle("How much of the true local error the default estimators find", fontsize=11)
    handles, labels = grid[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=6, fontsize=7, frameon=False)
    save(
        figure, folder / "effectivity", SECTION,
        f"""Effectivity index of the default estimators, the estimate over the true local error of one step, over Ω = ωh
        at default parameters: (a), (b) of u and v, undamped; (c), (d) with ξ = {DAMPED}; (e), (f) undamped, filtered by
        the effective stiffness as often as it takes for the estimate to vanish as Ω → ∞. Each tends to 1 as Ω does to
        0, but for the velocity of the lagged central differences without damping, to which its estimate is blind.
        Explicit schemes have no filter.""",
    )  # fmt: skip
    columns = {f"{name} {q}": x.plain[k] for name, x in undamped.items() for k, q in enumerate("uv")}
    save_csv(folder / "effectivity.csv", ["Omega", *columns], [OMEGAS, *columns.values()])
