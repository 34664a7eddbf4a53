"""The commands `substep schemes`, `substep show` and `substep scenes`: what is in the catalogue."""

from collections.abc import Iterable, Sequence
from html import escape
from itertools import groupby
from pathlib import Path
from textwrap import wrap
from typing import TYPE_CHECKING, Annotated, Any, Literal, get_args

import typer
from rich.console import Console

from ..core.schemes import Kind, Scheme, scheme
from ..core.schemes import schemes as scheme_names
from .arguments import SchemeArgument, declared, refuse, require_folders, scheme_of, source_of, working
from .lines import width, wrapped

if TYPE_CHECKING:
    from collections.abc import Mapping

    from ..derived.facade import ClosedForm

Part = Literal[
    "relations", "stiffness", "amplification", "spectrum", "energy", "load", "series", "nonlinear", "modified",
    "constrained", "turning", "all",
]  # fmt: skip
COLUMNS = ("scheme", "order", "rho_inf", "stable", "solves", "growth")
GROWTH = "growth U2-V3: in the first step u grows like Omega^2, v/omega like Omega^3"
LINE = 78  # columns of a line in lists


def schemes(
    context: typer.Context,
    search: Annotated[str, typer.Argument(help="a text in a name, a synonym or a reference")] = "",
    order: Annotated[int | None, typer.Option(help="of u and v, the lower of the two")] = None,
    solves: Annotated[int | None, typer.Option(help="balances a step")] = None,
    A_stable: Annotated[bool | None, typer.Option("--A/--not-A", help="A-stable or not")] = None,
    L_stable: Annotated[bool | None, typer.Option("--L/--not-L", help="L-stable or not")] = None,
    explicit: Annotated[bool | None, typer.Option("--explicit/--implicit", help="without or with solves")] = None,
    references: Annotated[bool, typer.Option("--references", help="where each was published")] = False,
    parameters: Annotated[bool, typer.Option("--parameters", help="the parameters of each, with defaults")] = False,
    markdown: Annotated[bool, typer.Option("--markdown", help="the table as Markdown")] = False,
) -> None:
    """List schemes by kind: order of u, v and a, spectral radius at infinity, and for which Omega they are stable.

    Those that are as asked, such as substep schemes --order 4 --A; at default parameters. stable: A, L for A-stable,
    L-stable; else for which Omega, undamped. solves: balances a step. growth: overshoot, the powers of Omega with which
    u and v/omega grow in the first step.
    """
    try:
        refuse(context, ("references", "parameters") if markdown else (), "with --markdown")
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    names = scheme_names(
        order=order, solves=solves, A_stable=A_stable, L_stable=L_stable, explicit=explicit, search=search
    )
    if not names:
        raise typer.BadParameter("expected what some scheme has, got none that has all of it; ask for less")
    every = [scheme(name) for name in names]
    if markdown:
        rows = map(_row, every)
        print("\n".join(f"| {' | '.join(cells)} |" for cells in (COLUMNS, ("---",) * len(COLUMNS), *rows)))
    elif references or parameters:
        for s in every:
            text = "; ".join(
                [*([_parameters(s) or "no parameters"] if parameters else []), *([s.reference] if references else [])]
            )
            print("\n".join([s.name, *wrap(text, LINE, initial_indent="  ", subsequent_indent="  ")]))
    else:
        widths = [max(map(len, column)) for column in zip(COLUMNS, *map(_row, every), strict=True)]
        print(_aligned(COLUMNS, widths))
        for kind in get_args(Kind):
            if rows := [_aligned(_row(s), widths) for s in every if s.kind == kind]:
                print("\n".join(["", kind, *rows]))
        print(GROWTH)


def _aligned(row: Sequence[str], widths: Iterable[int]) -> str:
    return "  ".join(cell.ljust(wide) for cell, wide in zip(row, widths, strict=True)).rstrip()


def _row(s: Scheme) -> tuple[str, ...]:
    """A scheme's row in the table, for COLUMNS."""
    order = ",".join(map(str, s.order or ()))
    return (s.name, order, f"{s.rho_inf:.3g}", _stability(s), str(s.balances), str(s.overshoot))


def _stability(s: Scheme) -> str:
    assert s.critical_Omega is not None  # known at defaults
    if s.critical_Omega == float("inf"):
        return "L" if s.L_stable else "A" if s.A_stable else "undamped"
    return f"Ω < {s.critical_Omega:.3g}" if s.critical_Omega > 0 else "no"


def _parameters(s: Scheme) -> str:
    return ", ".join(f"{name} ({float(value):.4g})" for name, value in s.parameters.items())


def show(
    context: typer.Context,
    name: SchemeArgument,
    part: Annotated[
        Part | None, typer.Option(metavar="PART", help=f"closed forms, derived now: {', '.join(get_args(Part))}")
    ] = None,
    latex: Annotated[bool, typer.Option("--latex", help="closed forms in LaTeX; all parts if none is named")] = False,
    html: Annotated[
        Path | None, typer.Option(help="a page of closed forms, typeset; all parts if none is named")
    ] = None,
) -> None:
    """Print what is known of a scheme: state, order, spectral radius at infinity, stability, effective stiffness.

    At the defaults, or at parameters that follow the name: newmark:beta=1/4,gamma=3/5. With --part, the closed forms of
    one part, or of all.
    """
    from ..derived.facade import closed_forms, fact_row  # noqa: PLC0415 (SymPy only when asked for)

    try:
        require_folders(html)
        refuse(context, ("latex",) if html else (), "with --html")
        s = scheme_of(name)
        if part is None and not latex and html is None:
            with working(f"deriving {name}"):
                source, given = source_of(name)
                row = fact_row(source, **given)
            _print_facts(s, row, name)
            return
        with working(f"deriving {part or 'all parts'} of {name}"):
            forms = list(closed_forms(declared(name), part or "all"))
    except (ValueError, NotImplementedError) as error:
        raise typer.BadParameter(str(error)) from error
    if html is not None:
        html.write_text(_page(s, forms), encoding="utf-8")
        Console().print(f"{html}")
        return
    for section, found in groupby(forms, key=lambda form: form.section):
        print(f"% {section}" if latex else f"\n{section}")
        for form in found:
            print(rf"\[ {form.latex} \]" if latex else wrapped(f"{form.name} = ", form.text))


def _print_facts(s: Scheme, row: "Mapping[str, Any]", name: str) -> None:
    """State, order, limits, stability, first errors and effective stiffness; row: see `fact_row`; name: as given."""
    from substep_kernels.facts import FORMS  # noqa: PLC0415

    form = FORMS.get(name, {})  # closed forms in parameters, where all are at their defaults
    lines = {
        "state": ", ".join(s.state),
        "parameters": _parameters(s) or "none",
        "order of u, v, a": ", ".join(map(str, row["order"])),
        "rho_inf": " = ".join(dict.fromkeys([row["rho_inf"], *filter(None, [form.get("limit_text")])])),
        "stable, undamped": "for every Omega" if row["critical_Omega"] == "none" else _limit(row),
        "A-stable, L-stable": f"{row['A_stable']}, {row['L_stable']}",
        "overshoot": row["overshoot"],
        "constrained": row["constrained"],
        **{f"{kind}, first term": _term(row[kind]) for kind in ("damping", "period")},
        **{f"K_eff of balance {k}": text for k, text in enumerate(row["stiffness"], start=1)},
    }
    print("\n".join([s.name, *wrap(s.reference, width(), initial_indent="  ", subsequent_indent="  "), ""]))
    for label, text in lines.items():
        print(wrapped(f"{label}: ", text))
    more = f"All at these parameters. Closed forms: substep show {name} --part PART, one of {', '.join(get_args(Part))}"
    print("\n".join(["", *wrap(more, width())]))


def _limit(row: "Mapping[str, Any]") -> str:
    exact, value = row["critical_Omega"], float(row["values"]["critical_Omega"])
    if not value:
        return "for no Omega"
    return f"up to Omega = {value:.6g}" + ("" if "CRootOf" in exact else f" = {exact}")


def _term(term: tuple[int, str] | None) -> str:
    return "0" if term is None else f"{term[1]} Omega^{term[0]}"


def _page(s: Scheme, forms: "Iterable[ClosedForm]") -> str:
    """Closed forms as a page of its own, typeset by MathML."""
    parts = [f"<h1>{escape(s.name)}</h1><p>{escape(s.reference)}</p>"]
    for section, found in groupby(forms, key=lambda form: form.section):
        parts.append(f"<h2>{escape(section)}</h2>")
        for form in found:
            is_text = isinstance(form.value, str)
            body = escape(form.mathml) if is_text else f'<math display="block">{form.mathml}</math>'
            parts.append(f"<h3>{escape(form.name)}</h3><div>{body}</div>")
    style = "body{font-family:serif;max-width:60em;margin:2em auto}div{overflow-x:auto}h3{font-size:1em}"
    head = f'<meta charset="utf-8"><title>{escape(s.name)}</title><style>{style}</style>'
    return f'<!doctype html><html lang="en"><head>{head}</head><body>{"".join(parts)}</body></html>\n'


def scenes(
    references: Annotated[bool, typer.Option("--references", help="where each is from")] = False,
) -> None:
    """List all scenes with their coordinates and parameters (default value; those without one have to be given)."""
    from ..core.scene_catalogue import scene_info  # noqa: PLC0415
    from ..core.scene_catalogue import scenes as scene_names  # noqa: PLC0415

    for name in scene_names():
        info = scene_info(name, {})
        given = ", ".join(
            p.name if p.default is None else f"{p.name} ({p.default():.7g})" for p in info.parameters.values()
        )
        lines = [f"coordinates {', '.join(f'{q} ({unit})' for q, unit in info.coordinates)}", f"parameters {given}"]
        lines += [info.reference] if references else []
        wrapped = (wrap(x, LINE, initial_indent="  ", subsequent_indent="    ") for x in lines)
        print("\n".join([name, *(line for block in wrapped for line in block)]))
