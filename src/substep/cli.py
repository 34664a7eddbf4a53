"""The command line `substep`."""

from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from rich.console import Console
from rich.progress import Progress
from rich.table import Column, Table

from .schemes import scheme
from .schemes import schemes as scheme_names

if TYPE_CHECKING:
    from .claims.judging import Judgement

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
    from .build import closed_forms  # noqa: PLC0415 (SymPy only when asked for)

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
) -> None:
    """Draw the thesis's figures 4.1-4.5 and the charts, write the numbers behind them, judge the claims."""
    from . import reproduce as job  # noqa: PLC0415 (Matplotlib only when asked for)

    with Progress(console=console) as progress:
        task = progress.add_task("figures, properties, claims", total=job.steps())
        results = job.reproduce(folder, lambda: progress.advance(task))
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
    _print_claims(results.claims)
    console.print(f"figures, tables and the ledger (claims.md) are in {folder.resolve()}")


@app.command()
def claims() -> None:
    """Judge what the thesis claims and print, line by line, verdict and evidence."""
    from . import claims as ledger  # noqa: PLC0415

    with Progress(console=console) as progress:
        task = progress.add_task("claims", total=len(ledger.JUDGES))
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
    from .build import certificate  # noqa: PLC0415

    try:
        found = certificate(name, xi=xi, **_exact_options(context.args))
    except (ValueError, TypeError) as error:
        raise typer.BadParameter(str(error)) from error
    print(found.text)
    parameters = {key: float(value) for key, value in found.parameters.items()}
    for low, high, *_ in found.multiple:  # shown by a run as well: powers grow though no eigenvalue is outside
        if low == high:
            norms = (scheme(name, **parameters).power_norm(float(low), float(found.xi), n) for n in (10, 100, 1000))
            print(f"\nLargest ||A^k|| in the energy norm at Omega = {low}: " + ", ".join(f"{x:.4g}" for x in norms))
            print("for k up to 10, 100, 1000.")


@app.command()
def conditions(name: Annotated[str, typer.Argument(help="a name listed by `substep schemes`")]) -> None:
    """Print for which parameters a scheme is stable for every Ω, undamped, and of second order: derived."""
    from .build import conditions as derived  # noqa: PLC0415
    from .build import order_conditions  # noqa: PLC0415

    try:
        print(derived(name).text)
        for quantity, polynomials in order_conditions(name).items():
            wanted = " and ".join(f"{p} = 0" for p in polynomials) or "always"
            print(f"{quantity} is of second order, free and forced, damped and undamped: {wanted}")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


@app.command()
def equivalences(
    names: Annotated[list[str] | None, typer.Argument(help="at least two schemes; all if none is given")] = None,
) -> None:
    """Find schemes that share their amplification matrix or only their spectrum, with the parameter maps."""
    from .build import equivalences as find  # noqa: PLC0415

    try:
        for found in find(names or []):
            print(found.text)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error


def _exact_options(arguments: list[str]) -> dict[str, str]:
    """--name value or --name=value, a dash in the name standing for an underscore; values stay text."""
    values: dict[str, str] = {}
    rest = iter(arguments)
    for argument in rest:
        if not argument.startswith("--"):
            raise ValueError(f"expected a parameter such as --gamma-t 1/5, got '{argument}'")
        key, joined, value = argument[2:].partition("=")
        if not joined:
            value = next(rest, "")
        if not value:
            raise ValueError(f"expected a number after --{key}, got none")
        values[key.replace("-", "_")] = value
    return values
