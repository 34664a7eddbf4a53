"""The command line `substep`."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from rich.console import Console
from rich.table import Table
from typer.core import TyperGroup

from ..core import extras
from ..core.schemes import scheme
from .arguments import (
    SceneArgument,
    SchemeArgument,
    SchemeOfRun,
    SchemeOption,
    StartOption,
    StrainOption,
    as_options,
    declared,
    exact_options,
    known_schemes,
    number,
    numbers,
    require_files,
    require_folders,
    scene_of,
    scheme_of,
    source_of,
    working,
)
from .catalogue import scenes, schemes, show
from .charts import chart
from .choose import choose
from .command import Command
from .estimators import estimator
from .failure_map import failure_map
from .failures import failures
from .inelastic import inelastic, report
from .lines import folded

if TYPE_CHECKING:
    from ..derived.facade import Equivalence

INTERRUPTED = 130  # the exit code of a shell's command that Ctrl-C ended
STOPPED = 3


class Guide(TyperGroup):
    """The commands in the order in which they are added, then those that other packages bring.

    Ctrl-C ends them with a line that says what is kept.
    """

    def list_commands(self, ctx: Any) -> list[str]:
        """The names of all commands."""
        return [*dict.fromkeys((*self.commands, *extras.installed(extras.COMMANDS)))]

    def get_command(self, ctx: Any, cmd_name: str) -> Any:
        """The command of that name; None where there is none."""
        if cmd_name not in self.commands:
            try:
                command: Command | None = extras.brought(extras.COMMANDS, cmd_name)
            except ImportError as error:
                return ctx.fail(str(error))
            if command is None:
                for name in extras.installed(extras.COMMANDS):  # so that the nearest of all is named
                    self.get_command(ctx, name)
                return None
            self.add_command(command.alone(), cmd_name)
        return super().get_command(ctx, cmd_name)

    def invoke(self, ctx: Any) -> Any:
        """Run the command."""
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            done = "interrupted; what was printed or written before is complete and kept"
            Console(stderr=True).print(f"\nsubstep {ctx.invoked_subcommand}: {done}")
            raise typer.Exit(INTERRUPTED) from None


app = typer.Typer(
    cls=Guide,
    invoke_without_command=True,
    pretty_exceptions_enable=False,
    epilog="Exit codes: 0 done; 2 wrong input, with the cure on stderr; 3 the march of `run` stopped early, and what "
    "it reached is printed; 130 interrupted. The --help of each command has an example; --install-completion completes "
    "commands and options in the shell.",
)
console = Console()


def _version(asked: bool) -> None:
    if asked:
        from .. import __version__  # noqa: PLC0415 (read from the package's metadata only when asked for)

        print(f"substep {__version__}")
        raise typer.Exit


@app.callback()
def main(
    context: typer.Context,
    version: Annotated[
        bool, typer.Option("--version", callback=_version, is_eager=True, help="print the version and end")
    ] = False,
) -> None:
    """Direct time integration schemes for structural dynamics: declared once, derived, compiled.

    Which scheme do I take? `substep choose duffing --accuracy 1e-3 --t-end 2 --among bathe,noh_bathe,rk4`,
    `substep schemes`

    Is it stable? `substep certify bathe`, `substep show bathe`

    How large a step? `substep chart bathe newmark`, `substep run duffing bathe --dt 0.01 --t-end 10`

    What does my program do? `substep audit scipy`
    """
    if context.invoked_subcommand is None:
        print(context.get_help())


def certify(
    context: typer.Context,
    name: SchemeArgument,
    xi: Annotated[str, typer.Option(help="damping ratio, exact: 0, 1/20 or 0.05")] = "0",
    structures: Annotated[bool, typer.Option("--structures", help="on every M > 0, C >= 0, K >= 0")] = False,
) -> None:
    """Prove for which Ω a scheme is stable. Parameters follow as exact numbers: --gamma-t 1/5 --beta 0.3025.

    With --structures, whether it is on every structure, whatever its damping: proved, proved under a bound, refuted by
    matrices on which it grows, or open.
    """
    from ..derived.facade import certificate, structures_certificate  # noqa: PLC0415

    try:
        with working(f"certifying {name}"):
            numbers(context.args)  # whose errors name the option
            source, given = source_of(name, exact_options(context.args))
            if structures and xi != "0":
                raise ValueError(
                    f"expected no --xi with --structures, whose matrix C holds all damping, got {xi}; leave it out"
                )
            if structures:
                print(folded(structures_certificate(source, **given).text))
                return
            found = certificate(source, xi=xi, **given)
    except (ValueError, TypeError) as error:
        raise typer.BadParameter(str(error)) from error
    print(folded(found.text))
    parameters = {key: float(value) for key, value in found.parameters.items()}
    for low, high, *_ in found.multiple:  # powers of the matrix grow there, though no eigenvalue is outside the circle
        if low == high:
            norms = (scheme(source, **parameters).power_norm(float(low), float(found.xi), n) for n in (10, 100, 1000))
            print(f"\nLargest ||A^k|| in the energy norm at Omega = {low}: " + ", ".join(f"{x:.4g}" for x in norms))
            print("for k up to 10, 100, 1000.")


def conditions(name: SchemeArgument) -> None:
    """Print for which parameters a scheme is stable for every Ω, undamped, and of second order: derived."""
    from ..derived.facade import conditions as derived  # noqa: PLC0415
    from ..derived.facade import order_conditions  # noqa: PLC0415

    try:
        with working(f"deriving conditions of {name}"):
            own = declared(name)
            text, second_order = derived(own).text, order_conditions(own)
        print(folded(text))
        for quantity, polynomials in second_order.items():
            wanted = " and ".join(f"{p} = 0" for p in polynomials)
            where = f"if {wanted}" if wanted else "without a condition"
            where = "for no parameters" if polynomials == ("1",) else where
            print(folded(f"{quantity} is of second order, free and forced, damped and undamped, {where}"))
    except (ValueError, NotImplementedError) as error:
        raise typer.BadParameter(str(error)) from error


def equivalences(
    names: Annotated[
        list[str] | None,
        typer.Argument(help="at least two schemes; all if none is given", autocompletion=known_schemes),
    ] = None,
) -> None:
    """Find schemes that share their amplification matrix or only their spectrum, with the parameter maps."""
    from ..derived.facade import equivalences as find  # noqa: PLC0415

    try:
        if names and len(names) == 1:
            raise ValueError(
                f"expected at least two schemes to compare, got {names[0]} alone; name another, or none for all"
            )
        pairs = find([declared(name) for name in names or []])

        def next_pair() -> "Equivalence | None":
            with working("comparing schemes"):
                return next(pairs, None)

        for pair in iter(next_pair, None):  # each is printed when it is found, since all take a minute
            print(folded(pair.text), flush=True)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def run(
    context: typer.Context,
    scene_name: SceneArgument,
    scheme_name: SchemeOfRun,
    dt: Annotated[float, typer.Option(help="time step in s")],
    t_end: Annotated[float, typer.Option(help="end of the run in s, a multiple of dt")],
    a0: StartOption = "",
    strain: StrainOption = "",
    csv: Annotated[Path | None, typer.Option(help="write the history here")] = None,
) -> None:
    """March a scene. Parameters of both follow as numbers: --EA 1e4 --gamma-t 0.2."""
    from ..core.scene_catalogue import arguments_of, scene_info  # noqa: PLC0415
    from ..figures.charts import save_csv  # noqa: PLC0415
    from ..marching.gained import gained  # noqa: PLC0415
    from ..marching.run import marched  # noqa: PLC0415

    try:
        require_folders(csv)
        known = arguments_of(scene_info(scene_name, {}))
        try:
            s = scheme_of(scheme_name, {k: x for k, x in exact_options(context.args).items() if k not in known})
        except ValueError as error:
            raise ValueError(f"{error}; parameters of {scene_name}: {', '.join(known) or 'none'}") from error
        here = scene_of(scene_name, a0, strain, {k: x for k, x in numbers(context.args).items() if k in known})
        with working(f"marching {scene_name}"):
            r = marched(here, s, dt, t_end)
            warning = gained(r, dt)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    names = [name for name, _ in here.coordinates]
    columns = {"t (s)": r.t}
    for symbol, values in (("", r.u), ("velocity ", r.v), ("acceleration ", r.a)):
        columns |= {f"{symbol}{name}": values[:, i] for i, name in enumerate(names)}
    columns["energy"] = r.energy
    columns |= {f"momentum of {name}": values for name, values in r.momenta.items()} | dict(r.outputs)
    table = Table("", "start", "end", title=f"{scheme_name} on {scene_name}: {r.status}, {len(r.t) - 1} steps")
    for name, values in columns.items():
        table.add_row(name, f"{values[0]:.12g}", f"{values[-1]:.12g}")
    console.print(table)
    if r.t_failed is not None:
        console.print(f"stopped in the step that ends at t = {r.t_failed:.12g} s; the end is the last good state")
        if r.failure:
            console.print(r.failure, highlight=False, soft_wrap=True)
    if warning:
        Console(stderr=True).print(f"warning: {warning}", highlight=False, soft_wrap=True)
    if r.newton_iterations.any():
        console.print(f"Newton iterations a step and balance: {r.newton_iterations.mean():.3g} in the mean")
    if csv is not None:
        save_csv(csv, list(columns), list(columns.values()))
    if r.status != "completed":
        raise typer.Exit(STOPPED)


def spectrum(
    context: typer.Context,
    file: Annotated[Path, typer.Argument(help="a record: columns of text, PEER's .AT2, ESM's ASCII and others")],
    xi: Annotated[float, typer.Option(help="damping ratio")] = 0.05,
    scheme_name: SchemeOption = "average_acceleration",
    periods: Annotated[str, typer.Option(help="in s, as 0.1,0.5,1; by default 200 from 0.02 to 10 s")] = "",
    dt: Annotated[float | None, typer.Option(help="step in s, of a file of accelerations alone")] = None,
    unit: Annotated[
        str, typer.Option(help="g, m/s^2, cm/s^2, gal, in/s^2, ft/s^2, ...; by default what the file says")
    ] = "",
    resample: Annotated[float | None, typer.Option(help="interpolate the record to this step in s first")] = None,
    refine: Annotated[str, typer.Option(help="auto: more steps a sample where a period needs them for 1 %")] = "",
    ductility: Annotated[str, typer.Option(help="as 1,2,4: of oscillators that yield, and the strength for it")] = "",
    hardening: Annotated[float, typer.Option(help="after yielding, of the initial stiffness; with --ductility")] = 0.0,
    csv: Annotated[Path | None, typer.Option(help="write the spectrum here")] = None,
    chart: Annotated[Path | None, typer.Option(help="draw it here, without suffix")] = None,
) -> None:
    """Report the peak response of oscillators to a ground motion, elastic or yielding, with the scheme's own error.

    Parameters of the scheme follow as numbers.
    """
    from ..ground_motion.records import read_record  # noqa: PLC0415
    from ..ground_motion.spectrum import QUANTITIES, response_spectrum  # noqa: PLC0415

    try:
        require_files(file)
        require_folders(csv, chart)
        T = [number("--periods", text) for text in periods.split(",")] if periods else None
        with working(f"response spectrum of {file.name}"):
            own = scheme_of(scheme_name, exact_options(context.args))
            record = read_record(file, dt, unit or None, resample=resample)
            if ductility:
                yielding = inelastic(record, T, xi, own, ductility, hardening, refine)
                return report(yielding, file.name, csv, chart)
            if hardening:
                raise ValueError(f"expected --hardening with --ductility, got {hardening:g} alone; give both")
            s = response_spectrum(record, periods=T, xi=xi, scheme=own, refine=refine or None)
    except (ValueError, OSError, ImportError) as error:
        raise typer.BadParameter(as_options(str(error), "dt", "unit", "resample")) from error
    settings = f"{s.samples} samples, dt = {s.dt:g} s, xi = {xi:g}, {' '.join((s.scheme, s.parameters)).strip()}"
    table = Table("", "largest", "at T (s)", "its error", "largest error", "at T (s)", title=f"{file.name}: {settings}")
    for name in QUANTITIES:
        value, error = s[name], s[f"{name}_error"]
        at, off = (int(x.where(x < math.inf, -1.0).to_numpy().argmax()) for x in (value, abs(error)))  # stable periods
        row = (f"{float(value[at]):.6g} {value.units}", f"{float(s.period[at]):.4g}", f"{100 * float(error[at]):.3g} %")
        table.add_row(name, *row, f"{100 * float(error[off]):.3g} %", f"{float(s.period[off]):.4g}")
    console.print(table)
    console.print(f"accelerations read in {s.unit}")
    if s.good_from == s.good_from:  # NaN where not even the longest period is
        console.print(f"SA is within 1 % of the exact response from T = {s.good_from:.4g} s on")
    if refine:
        more = int((s.steps > 1).sum())
        console.print(
            f"{more} of {s.sizes['period']} periods took more than a step a sample, at most {int(s.steps.max())}"
        )
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


for command in (
    Command("What there is", "substep schemes --order 4 --A", schemes),
    Command("What there is", "substep show newmark_bdf2 --part amplification", show),
    Command("What there is", "substep scenes --references", scenes),
    Command("Runs", "substep run elastic_pendulum bathe --EA 1e4 --dt 0.01 --t-end 30", run, parameters=True),
    Command(
        "Runs", "substep choose elastic_pendulum --EA 1e4 --accuracy 1e-3 --among bathe,noh_bathe,rk4", choose,
        parameters=True,
    ),
    Command("Runs", "substep spectrum motion.AT2 --scheme bathe --xi 0.02 --chart out", spectrum, parameters=True),
    Command("Runs", "substep chart bathe newmark:beta=1/4,gamma=.6 --xi .05 --quantity period_error", chart),
    Command("Proofs", "substep certify newmark_bdf2 --gamma-t 1/5 --beta 0.3025 --gamma 3/5", certify, parameters=True),
    Command("Proofs", "substep conditions newmark", conditions),
    Command("Proofs", "substep estimator newmark_bdf2 --gamma 1/2", estimator, parameters=True),
    Command("Proofs", "substep equivalences bathe silva_bezerra", equivalences),
    Command("Programs and results", "substep failures --folder results", failures),
    Command("Programs and results", "substep failure-map bathe --port 8000", failure_map),
):  # fmt: skip
    command.add(app)
