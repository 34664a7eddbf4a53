"""Charts of the catalogue: schemes of equal rho_inf, errors at equal cost, and where Newmark-BDF2 is stable."""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from substep.core.schemes import Array, Scheme, scheme
from substep.core.style import REFERENCE, label_ends, look, styled
from substep.derived import facade
from substep.figures.charts import save, save_csv, stability_figure
from substep.studies.energy_charts import energy_under_changing_steps
from substep.studies.estimator_charts import effectivity_chart
from substep.studies.precision.charts import kinds

SECTION = "The catalogue"
RHO = 0.5  # the common high-frequency spectral radius
RATIOS = np.logspace(-2, 3, 401)
SMALL = np.linspace(0.0, 0.2, 101)


def second_order_betas(rho_inf: Fraction, gamma_t: Fraction) -> list[float]:
    """Values of beta that give newmark_bdf2 second order, stability at every Omega and this rho_inf.

    See `substep_design.second_order.region`.
    """
    from substep_design.second_order import region  # noqa: PLC0415 (SymPy)

    curves = [(float(r.beta.subs("gamma_t", gamma_t)), r.intervals) for r in region(rho_inf)]
    return [beta for beta, cells in curves if any(float(low) < gamma_t < float(high) for low, high, *_ in cells)]


def at_equal_rho_inf() -> dict[str, Scheme]:
    """Schemes by label: those whose rho_inf can be set, at RHO, then those that have no such choice."""
    free = (
        "generalized_alpha",
        "hht_alpha",
        "wbz_alpha",
        "oalts",
        "kr_alpha",
        "rho_inf_bathe",
        "beta1_beta2_bathe",
        "three_substep",
    )
    tuned = {f"{name}, $\\rho_\\infty$ = {RHO:g}": scheme(name, rho_inf=RHO) for name in free}
    beta, *_ = second_order_betas(Fraction(RHO), Fraction(1, 2))
    tuned[rf"newmark_bdf2, $\gamma_t$ = 0.5, $\beta$ = {beta:g}, $\gamma$ = 0.5"] = scheme("newmark_bdf2", beta=beta)
    fixed = (
        "backward_euler",
        "energy_momentum",
        "wilson_theta",
        "houbolt",
        "park",
        "gholampour",
        "bathe",
        "average_acceleration",
    )
    return {**tuned, **{name: scheme(name) for name in fixed}}


def spectra(folder: Path) -> None:
    """Spectral radius, period error and amplitude error of implicit schemes, at equal rho_inf where it can be set."""
    drawn = at_equal_rho_inf()
    radius = {label: s.spectral_radius(2 * np.pi * RATIOS) for label, s in drawn.items()}
    period = {label: s.period_error(2 * np.pi * SMALL) for label, s in drawn.items()}
    amplitude = {label: s.amplitude_error(2 * np.pi * SMALL) for label, s in drawn.items()}
    *others, reference = drawn
    groups = {kind: [label for label in others if drawn[label].name in names] for kind, names in kinds().items()}
    figure = stability_figure(
        r"Schemes without a limit on the step, $\xi$ = 0, one step $h$ each",
        (RATIOS, radius),
        (SMALL, amplitude, period),
        [(title, [*labels, reference]) for title, labels in groups.items() if labels],
    )
    save(
        figure, folder / "catalogue_spectra", SECTION,
        f"""Schemes without a limit on the step, on the undamped oscillator over h/T: (a) spectral radius, (b)
        amplitude error a period, (c) period error, in a row for each kind of scheme; the average acceleration method
        is black in all. Schemes whose spectral radius at infinity can be set have ρ∞ = {RHO:g}; the others are as
        published. Each takes one step h, for which a composite scheme solves two or three times where another solves
        once: the chart of errors at equal cost takes account of that.""",
    )  # fmt: skip
    plain = [label.replace("$", "").replace("\\", "") for label in drawn]
    save_csv(folder / "catalogue_spectral_radius.csv", ["h/T", *plain], [RATIOS, *radius.values()])
    for name, errors in (("period", period), ("amplitude", amplitude)):
        percent = [100 * y for y in errors.values()]
        save_csv(folder / f"catalogue_{name}_error_percent.csv", ["h/T", *plain], [SMALL, *percent])


EQUAL_COST = (
    "generalized_alpha",
    "rho_inf_bathe",
    "three_substep",
    "oalts",
    "houbolt",
    "park",
    "wilson_theta",
    "bathe",
)


def compared() -> dict[str, Scheme]:
    """Schemes by label that are compared at equal cost: Newmark-BDF2 with numbers from Table 4.1, and EQUAL_COST."""
    label = r"newmark_bdf2, $\gamma_t$ = .5, $\beta$ = .3025, $\gamma$ = .6"
    newmark_bdf2 = scheme("newmark_bdf2", gamma_t=0.5, beta=0.3025, gamma=0.6)
    return {label: newmark_bdf2, **{name: scheme(name) for name in EQUAL_COST}}


def at_equal_cost(s: Scheme, solves: Array | float) -> tuple[Array, Array]:
    """Amplitude error a period and period error of the undamped oscillator, in %, at so many solves a period.

    A scheme with k solves a step takes steps k times as long. solves: any shape, which both errors have.
    """
    Omega = 2 * np.pi * s.balances / np.asarray(solves)
    return 100 * np.abs(s.amplitude_error(Omega)), 100 * np.abs(s.period_error(Omega))


@styled
def trade_off(folder: Path) -> None:
    """Amplitude error against period error at equal cost: the same number of solves per period."""
    solves = np.logspace(np.log10(8), np.log10(200), 60)  # per period
    figure = Figure(figsize=(8.5, 6))
    axes = figure.subplots()
    columns: dict[str, Array] = {"solves per period": solves}
    for i, (label, s) in enumerate(compared().items()):
        amplitude, period = at_equal_cost(s, solves)
        colour, style = (REFERENCE, "-") if s.name == "bathe" else look(i)
        axes.loglog(period, amplitude, color=colour, linestyle=style, label=label)
        for count, marker in ((20, "o"), (100, "s")):
            k = int(np.argmin(np.abs(solves - count)))
            axes.plot(period[k], amplitude[k], marker, color=colour, markersize=5)
        columns |= {f"{s.name} period error %": period, f"{s.name} amplitude error %": amplitude}
    axes.set_xlabel("period error (%)")
    axes.set_ylabel("amplitude error per period (%)")
    axes.set_title("Equal cost: circles 20, squares 100 solves per period; $\\xi$ = 0")
    axes.set_xlim(left=axes.get_xlim()[0] / 15)  # room for the labels
    label_ends(axes, left=True)
    save(
        figure, folder / "trade_off_equal_cost", "Speed against accuracy",
        """Amplitude error a period against period error at equal cost: a scheme with k solves a step takes steps k
        times as long. Each curve runs over 8 to 200 solves a period of the undamped oscillator; circles mark 20,
        squares 100. Schemes at their default parameters, Newmark-BDF2 with γ_t = 0.5, β = 0.3025, γ = 0.6; Bathe's is
        black. Farther down and left is better.""",
    )  # fmt: skip
    save_csv(folder / "trade_off_equal_cost.csv", list(columns), list(columns.values()))


@styled
def stability_region(folder: Path) -> None:
    """rho_inf of Newmark-BDF2 with beta = (gamma + 1/2)^2/4 over (gamma_t, gamma), and certified points."""
    splits, gammas = np.linspace(0.01, 0.99, 197), np.linspace(0.3, 1.5, 241)
    t, g = np.meshgrid(splits, gammas)
    b = (g + 0.5) ** 2 / 4
    radius = scheme("newmark_bdf2", gamma_t=t, beta=b, gamma=g).spectral_radius(1e9)
    omegas = 2 * np.pi * np.logspace(-2.5, 3, 150)
    worst = np.max([scheme("newmark_bdf2", gamma_t=t, beta=b, gamma=g).spectral_radius(o) for o in omegas], axis=0)
    figure = Figure(figsize=(8, 6))
    axes = figure.subplots()
    shown = np.ma.masked_where(worst > 1 + 1e-9, radius)
    mesh = axes.pcolormesh(t, g, shown, cmap="cividis", vmin=0, vmax=1, shading="auto", rasterized=True)
    axes.set_facecolor("0.85")
    figure.colorbar(mesh, ax=axes, label=r"$\rho_\infty$ (grey: unstable for some $\Omega$)")
    for marker, stable, label in (("o", True, "certified stable"), ("x", False, "certified unstable")):
        points = [p for p in CERTIFIED if certified(*p) is stable]
        x, y = ([float(p[k]) for p in points] for k in (0, 1))
        face = {"facecolors": "none"} if stable else {}
        axes.scatter(x, y, marker=marker, color="#D55E00", s=36, label=label, **face)
    axes.set_xlabel(r"sub-step ratio $\gamma_t$")
    axes.set_ylabel(r"Newmark's $\gamma$, with $\beta = (\gamma + 1/2)^2/4$")
    axes.set_title(r"Newmark-BDF2, $\xi$ = 0")
    figure.legend(loc="outside lower center", ncols=2)
    save(
        figure, folder / "stability_region", SECTION,
        """Newmark-BDF2 with β = (γ + 1/2)²/4, the choice of Table 4.1, over γ_t and γ, undamped: the colour is the
        spectral radius at infinity, grey is where the radius exceeds 1 at some step. Circles and crosses
        are points that exact algebra certified stable or unstable: they agree with the colours.""",
    )  # fmt: skip
    save_csv(
        folder / "stability_region.csv",
        ["gamma_t", "gamma", "rho_inf", "largest rho"],
        [x.ravel() for x in (t, g, radius, worst)],
    )


CERTIFIED = tuple(
    (Fraction(split), Fraction(gamma))
    for split in ("1/10", "3/10", "1/2", "7/10", "9/10")
    for gamma in ("2/5", "9/20", "1/2", "7/10", "9/10", "6/5", "7/5")
)


def certified(split: Fraction, gamma: Fraction) -> bool:
    """Whether Newmark-BDF2 with the beta of `stability_region` is stable at every step, by certificate."""
    beta = (gamma + Fraction(1, 2)) ** 2 / 4
    return facade.certificate("newmark_bdf2", gamma_t=split, beta=beta, gamma=gamma).stable


EXPLICIT = (
    *("forward_euler", "central_difference_lagged", "rk2", "rk4", "noh_bathe", "tchamwa_wielgosz"),
    "central_difference",
)


def explicit_spectra(folder: Path) -> None:
    """Spectral radius, amplitude error and period error of explicit schemes, to beyond their limits of stability."""
    ratios = np.logspace(-2, np.log10(0.7), 301)
    drawn = {name: scheme(name) for name in EXPLICIT}
    radius = {name: s.spectral_radius(2 * np.pi * ratios) for name, s in drawn.items()}
    amplitude = {name: s.amplitude_error(2 * np.pi * SMALL) for name, s in drawn.items()}
    period = {name: s.period_error(2 * np.pi * SMALL) for name, s in drawn.items()}
    figure = stability_figure(r"Explicit schemes, $\xi$ = 0", (ratios, radius), (SMALL, amplitude, period))
    save(
        figure, folder / "explicit_spectra", SECTION,
        """Explicit schemes on the undamped oscillator, and the central difference method in black: (a) spectral radius
        over h/T, which leaves 1 at the limit of stability, (b) amplitude error a period, (c) period error, one step h
        each. Forward Euler and the two-stage Runge-Kutta method are unstable at every step.""",
    )  # fmt: skip
    save_csv(folder / "explicit_spectral_radius.csv", ["h/T", *drawn], [ratios, *radius.values()])
    save_csv(folder / "explicit_amplitude_error.csv", ["h/T", *drawn], [SMALL, *amplitude.values()])
    save_csv(folder / "explicit_period_error.csv", ["h/T", *drawn], [SMALL, *period.values()])


CHARTS: tuple[Callable[[Path], None], ...] = (
    spectra, explicit_spectra, trade_off, stability_region, effectivity_chart, energy_under_changing_steps,
)  # fmt: skip
