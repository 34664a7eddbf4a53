"""The command line `substep`."""

import math
from collections import Counter
from collections.abc import Sequence
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Column, Table

from ..core.schemes import scheme
from ..core.schemes import schemes as scheme_names
from .arguments import StartOption, StrainOption, exact_options, number, numbers, require_folders, scene_of
from .audits import audit
from .choice import choose
from .design import design
from .emission import emit
from .estimators import estimator
from .explorer import explorer

if TYPE_CHECKING:
    from ..studies.failures import Row
    from ..thesis.claims.judgement import Judgement

app = typer.Typer(no_args_is_help=True, add_completion=False, pretty_exceptions_enable=False)
console = Console()


@app.callback()
def main() -> None:
    """Direct time integration schemes for structural dynamics: declared once, derived, compiled."""


@app.command()
def schemes() -> None:
    """List all schemes with their parameters (default value) and reference."""
    table = Table(Column("scheme", no_wrap=True), "parameters", "state", "reference")
    for name in scheme_names():
        s = scheme(name)
        parameters = ", ".join(f"{key} ({float(value):.4g})" for key, value in s.parameters.items())
        table.add_row(name, parameters, ", ".join(s.state), s.reference)
    console.print(table)


@app.command()
def show(
    name: Annotated[str, typer.Argument(help="a name listed by `substep schemes`")],
    latex: Annotated[bool, typer.Option("--latex", help="LaTeX in place of text")] = False,
) -> None:
    """Print the closed forms of a scheme: relations, effective stiffness, amplification matrix, limits."""
    from ..derived.facade import closed_forms  # noqa: PLC0415 (SymPy only when asked for)

    try:
        scheme(name)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    for section, forms in groupby(closed_forms(name), key=lambda form: form.section):
        print(f"% {section}" if latex else f"\n{section}")
        for form in forms:
            print(rf"\[ {form.latex} \]" if latex else f"    {form.name} = {form.text}")


@app.command()
def reproduce(
    folder: Annotated[Path, typer.Option(help="where the results go")] = Path("results"),
    full: Annotated[
        bool, typer.Option("--full", help="the 1000 s runs, every scheme on every scene, fine maps")
    ] = False,
) -> None:
    """Draw the thesis's figures and the charts, map where methods fail, write the numbers, judge the claims."""
    from ..thesis import reproduce as job  # noqa: PLC0415 (Matplotlib only when asked for)

    stages = job.stages(full)
    work = sum(stage.jobs * stage.seconds for stage in stages)
    console.print(f"about {work / 60:.0f} min of work, the first time; compiled kernels are kept")
    with Progress(console=console) as progress:
        bars = {stage.name: progress.add_task(stage.name, total=stage.jobs) for stage in stages if stage.jobs}
        seconds = {stage.name: stage.seconds for stage in stages}
        all_of_it = progress.add_task("in all", total=work)

        def step(stage: str) -> None:
            progress.advance(bars[stage])
            progress.advance(all_of_it, seconds[stage])
            done = progress.tasks[bars[stage]]
            if done.finished:
                progress.console.print(f"{stage}: done after {done.elapsed:.0f} s")

        results = job.reproduce(folder, step, full=full)
    table = Table(
        Column("scheme", no_wrap=True),
        *(Column(name, overflow="fold") for name in ("order u, v, a", "ρ∞", "Ω_cr", "A", "L", "overshoot")),
        title="Every scheme at its default parameters (all columns: catalogue.csv)",
    )
    for row in results.catalogue:
        table.add_row(row.scheme, row.order, row.rho_inf, row.critical_Omega, row.A_stable, row.L_stable, row.overshoot)
    console.print(table)
    table = Table(
        Column("scheme", no_wrap=True),
        *(Column(name, overflow="fold") for name in ("γ_t", "β", "γ", "ρ∞", "order", "damping", "period error")),
        title="Chapter 4 at ξ = 0: exact leading terms in Ω (as CSV: chapter_4_properties.csv)",
    )
    for name, split, beta, gamma, rho, order, k, damping, n, period in results.properties:
        table.add_row(name, split, beta, gamma, rho, order, f"{damping} Ω^{k}", f"{period} Ω^{n}")
    console.print(table)
    outcomes = Counter(row.word for row in results.failures)
    counts = ", ".join(f"{number} {outcome}" for outcome, number in outcomes.most_common())
    console.print(f"Where methods fail, {outcomes.total()} runs: {counts} (failures.csv, or `substep failures`)")
    _print_claims(results.claims)
    console.print(f"figures, tables and the ledger (claims.md), all on one page: {folder.resolve() / 'index.html'}")


@app.command()
def failures(
    folder: Annotated[Path, typer.Option(help="where tables and maps go")] = Path("results"),
    full: Annotated[bool, typer.Option("--full", help="every scheme on every scene, maps of 500 x 500 runs")] = False,
) -> None:
    """Run schemes where they fail and report each run as survived, gains energy, blew up or Newton failed."""
    from ..studies import failures as battery  # noqa: PLC0415

    with Progress(console=console) as progress:
        task = progress.add_task("battery", total=battery.count())
        rows = battery.battery(folder, lambda: progress.advance(task), full)
    _print_failures(rows)
    console.print(f"tables and maps are in {folder.resolve()}")


def _print_failures(rows: "Sequence[Row]") -> None:
    table = Table(
        Column("scheme", no_wrap=True), "scene", "h (s)", "", "at t (s)", "max E/E0", title="Where methods fail"
    )
    for row in rows:
        at = "" if row.t is None else f"{row.t:.4g}"
        table.add_row(row.scheme, row.scene, f"{row.h:.4g}", row.word, at, f"{row.max_ratio:.4g}")
    console.print(table)


@app.command()
def claims() -> None:
    """Judge what the thesis claims and print, line by line, verdict and evidence."""
    from ..thesis import claims as ledger  # noqa: PLC0415

    with Progress(console=console) as progress:
        task = progress.add_task("claims", total=len(ledger.CLAIMS))
        found = ledger.judge(lambda: progress.advance(task))
    _print_claims(found)


def _print_claims(found: "list[Judgement]") -> None:
    table = Table("", "verdict", "claim", "found", title="The thesis's claims")
    for j in found:
        table.add_row(j.id, j.verdict, j.claim, j.evidence)
    console.print(table)


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def certify(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="a name listed by `substep schemes`")],
    xi: Annotated[str, typer.Option(help="damping ratio, exact: 0, 1/20 or 0.05")] = "0",
) -> None:
    """Prove for which Ω a scheme is stable. Parameters follow as exact numbers: --gamma-t 1/5 --beta 0.3025."""
    from ..derived.facade import certificate  # noqa: PLC0415

    try:
        found = certificate(name, xi=xi, **exact_options(context.args))
    except (ValueError, TypeError) as error:
        raise typer.BadParameter(str(error)) from error
    print(found.text)
    parameters = {key: float(value) for key, value in found.parameters.items()}
    for low, high, *_ in found.multiple:  # powers of the matrix grow there, though no eigenvalue is outside the circle
        if low == high:
            norms = (scheme(name, **parameters).power_norm(float(low), float(found.xi), n) for n in (10, 100, 1000))
            print(f"\nLargest ||A^k|| in the energy norm at Omega = {low}: " + ", ".join(f"{x:.4g}" for x in norms))
            print("for k up to 10, 100, 1000.")


app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(estimator)


@app.command()
def conditions(name: Annotated[str, typer.Argument(help="a name listed by `substep schemes`")]) -> None:
    """Print for which parameters a scheme is stable for every Ω, undamped, and of second order: derived."""
    from ..derived.facade import conditions as derived  # noqa: PLC0415
    from ..derived.facade import order_conditions  # noqa: PLC0415

    try:
        print(derived(name).text)
        for quantity, polynomials in order_conditions(name).items():
            wanted = " and ".join(f"{p} = 0" for p in polynomials) or "always"
            print(f"{quantity} is of second order, free and forced, damped and undamped: {wanted}")
    except (ValueError, NotImplementedError) as error:
        raise typer.BadParameter(str(error)) from error


app.command()(design)
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(emit)
app.command()(explorer)
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(audit)
app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})(choose)


@app.command()
def equivalences(
    names: Annotated[list[str] | None, typer.Argument(help="at least two schemes; all if none is given")] = None,
) -> None:
    """Find schemes that share their amplification matrix or only their spectrum, with the parameter maps."""
    from ..derived.facade import equivalences as find  # noqa: PLC0415

    try:
        for found in find(names or []):
            print(found.text)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def run(
    context: typer.Context,
    scene_name: Annotated[str, typer.Argument(metavar="SCENE", help="a name listed by `substep scenes`")],
    scheme_name: Annotated[str, typer.Argument(metavar="SCHEME", help="a name listed by `substep schemes`")],
    dt: Annotated[float, typer.Option(help="time step in s")],
    t_end: Annotated[float, typer.Option(help="end of the run in s, a multiple of dt")],
    a0: StartOption = "",
    strain: StrainOption = "",
    csv: Annotated[Path | None, typer.Option(help="write the history here")] = None,
) -> None:
    """March a scene. Parameters of both follow as numbers: --EA 1e4 --gamma-t 0.2."""
    from ..core.scenes import scene_info  # noqa: PLC0415
    from ..figures.charts import save_csv  # noqa: PLC0415
    from ..marching.run import march  # noqa: PLC0415

    try:
        require_folders(csv)
        given = numbers(context.args)
        known = scene_info(scene_name, {}).parameters
        s = scheme(scheme_name, **{key: value for key, value in given.items() if key not in known})
        here = scene_of(scene_name, a0, strain, {key: value for key, value in given.items() if key in known})
        r = march(here, s, dt, t_end)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    names = [name for name, _ in here.coordinates]
    columns = {"t (s)": r.t}
    for symbol, values in (("", r.u), ("velocity ", r.v), ("acceleration ", r.a)):
        columns |= {f"{symbol}{name}": values[:, i] for i, name in enumerate(names)}
    columns["energy"] = r.energy
    if r.angular_momentum is not None:
        columns["angular momentum"] = r.angular_momentum
    columns |= dict(r.outputs)
    table = Table("", "start", "end", title=f"{scheme_name} on {scene_name}: {r.status}, {len(r.t) - 1} steps")
    for name, values in columns.items():
        table.add_row(name, f"{values[0]:.12g}", f"{values[-1]:.12g}")
    console.print(table)
    if r.t_failed is not None:
        console.print(f"stopped in the step that ends at t = {r.t_failed:.12g} s; the end is the last good state")
    if r.newton_iterations.any():
        console.print(f"Newton iterations a step and balance: {r.newton_iterations.mean():.3g} in the mean")
    if csv is not None:
        save_csv(csv, list(columns), list(columns.values()))


@app.command()
def scenes() -> None:
    """List all scenes with their parameters (default value) and reference."""
    from ..core.scenes import scene_info  # noqa: PLC0415
    from ..core.scenes import scenes as scene_names  # noqa: PLC0415

    table = Table(Column("scene", no_wrap=True), "coordinates", "parameters", "reference")
    for name in scene_names():
        info = scene_info(name, {})
        coordinates = ", ".join(f"{q} ({unit})" for q, unit in info.coordinates)
        parameters = ", ".join(
            p.name if p.default is None else f"{p.name} ({p.default():.7g})" for p in info.parameters.values()
        )
        table.add_row(name, coordinates, parameters, info.reference)
    console.print(table)


@app.command()
def chart(
    names: Annotated[list[str], typer.Argument(help="schemes, at their default parameters; or work-precision")],
    file: Annotated[Path, typer.Option(help="where the chart goes, without suffix")] = Path("chart"),
    full: Annotated[bool, typer.Option("--full", help="work-precision: every step, medians of 20")] = False,
) -> None:
    """Draw spectral radius, amplitude error and period error of schemes over h/T, as PNG and SVG.

    work-precision: draw error against cost of all schemes on four scenes (--full: on nine), and where general solvers
    overtake, into the folder of the file.
    """
    if names == ["work-precision"]:
        _work_precision(file.parent, full)
        return
    from ..figures import charts  # noqa: PLC0415
    from ..thesis.reproduce import ERROR_RATIOS, RADIUS_RATIOS  # noqa: PLC0415

    try:
        require_folders(file)
        drawn = {name: scheme(name) for name in names}
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    wide, narrow = 2 * math.pi * RADIUS_RATIOS, 2 * math.pi * ERROR_RATIOS
    figure = charts.stability_figure(
        "Spectral radius, amplitude and period error at $\\xi$ = 0",
        (RADIUS_RATIOS, {name: s.spectral_radius(wide) for name, s in drawn.items()}),
        (
            ERROR_RATIOS,
            {name: s.amplitude_error(narrow) for name, s in drawn.items()},
            {name: s.period_error(narrow) for name, s in drawn.items()},
        ),
    )
    charts.save(
        figure, file, "Charts",
        f"""{", ".join(names)}, at their default parameters, on the undamped oscillator over h/T: (a) spectral radius,
        (b) amplitude error a period, (c) period error; the last is black.""",
    )  # fmt: skip
    console.print(f"{file}.png and {file}.svg")


@app.command(context_settings={"allow_extra_args": True, "ignore_unknown_options": True})
def spectrum(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(help="two columns, time (s) and acceleration (m/s^2), or a PEER .AT2")],
    xi: Annotated[float, typer.Option(help="damping ratio")] = 0.05,
    scheme_name: Annotated[
        str, typer.Option("--scheme", help="a name listed by `substep schemes`")
    ] = "average_acceleration",
    periods: Annotated[str, typer.Option(help="in s, as 0.1,0.5,1; by default 200 from 0.02 to 10 s")] = "",
    csv: Annotated[Path | None, typer.Option(help="write the spectrum here")] = None,
    chart: Annotated[Path | None, typer.Option(help="draw it here, without suffix")] = None,
) -> None:
    """Report the peak response of oscillators to a ground motion, with the scheme's own error.

    Parameters of the scheme follow as numbers.
    """
    from ..ground_motion.spectrum import PERIODS, QUANTITIES, response_spectrum  # noqa: PLC0415

    try:
        require_folders(csv, chart)
        T = [number("--periods", text) for text in periods.split(",")] if periods else PERIODS
        s = response_spectrum(file, periods=T, xi=xi, scheme=scheme(scheme_name, **numbers(context.args)))
    except (ValueError, OSError) as error:
        raise typer.BadParameter(str(error)) from error
    settings = f"{s.samples} samples, dt = {s.dt:g} s, xi = {xi:g}, {' '.join((s.scheme, s.parameters)).strip()}"
    table = Table("", "largest", "at T (s)", "its error", "largest error", "at T (s)", title=f"{file.name}: {settings}")
    for name in QUANTITIES:
        value, error = s[name], s[f"{name}_error"]
        at, off = (int(x.where(x < math.inf, -1.0).to_numpy().argmax()) for x in (value, abs(error)))  # stable periods
        row = (f"{float(value[at]):.6g} {value.units}", f"{float(s.period[at]):.4g}", f"{100 * float(error[at]):.3g} %")
        table.add_row(name, *row, f"{100 * float(error[off]):.3g} %", f"{float(s.period[off]):.4g}")
    console.print(table)
    if s.unstable:
        console.print(f"{s.scheme} is unstable at {s.unstable} of {s.sizes['period']} periods: inf there")
    if csv is not None or chart is not None:
        from ..figures import charts  # noqa: PLC0415 (Matplotlib only when asked for)

        if csv is not None:
            columns = {f"{name} ({x.units})": x.to_numpy() for name, x in {"period": s.period, **s.data_vars}.items()}
            charts.save_csv(csv, list(columns), list(columns.values()))
        if chart is not None:
            charts.save(
                charts.spectrum_figure(s), chart, "Response spectra",
                f"""Response spectrum of {file.name}, {settings}: relative displacement, relative velocity and absolute
                acceleration (dashed: pseudo-quantities), and below the error of the scheme's peak, relative to the
                exact response to the record, linear between its samples (Nigam & Jennings 1969).""",
            )  # fmt: skip


def _work_precision(folder: Path, full: bool) -> None:
    from ..studies.precision.jobs import jobs, operations  # noqa: PLC0415

    folder.mkdir(parents=True, exist_ok=True)
    with Progress(console=console) as progress:
        for job in progress.track((*jobs(full), operations), description="speed against accuracy"):
            job(folder)
    console.print(f"charts and tables are in {folder.resolve()}")
