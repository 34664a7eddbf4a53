"""The failure map of contact: the gains of a bar that falls on a floor, as table, chart and sentences."""

from collections.abc import Sequence
from itertools import groupby
from pathlib import Path

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Patch, Rectangle

from ...core.style import COLOURS, styled
from ...figures.charts import save
from .impact_bar import COURANT, LAWS, PRESSURE, BarRow, by_pair, never_gain
from .outcomes import SECTION, write_rows

NORM, SHADES = LogNorm(1e-2, 1e3, clip=True), colormaps["YlOrBr"]  # of gains in %
NEVER, FAILED = "#cfe3f2", COLOURS[0]
LEAST = 1e-4  # of E0: a smaller gain is written as that it is


def worst(rows: Sequence[BarRow]) -> float:
    """The largest gain of some rows; inf where runs failed, and 0 where none was made."""
    return max(np.inf if row.failed else row.gain or 0.0 for row in rows)


def by_gain(rows: Sequence[BarRow]) -> list[str]:
    """The schemes, those first whose largest gain is least; those that gain nothing in their order, idle ones last."""
    found: dict[str, list[BarRow]] = {}
    for row in rows:
        found.setdefault(row.scheme, []).append(row)
    ran = {name: any(row.failed is not None for row in own) for name, own in found.items()}
    gains = {name: worst(own) if any(row.share for row in own) else 0.0 for name, own in found.items()}
    return sorted(found, key=lambda name: (not ran[name], gains[name]))


def percent(row: BarRow) -> str:
    """The worst gain in % in few digits: 0 where there is none, <.01, 0.73, 122; what there is in its place."""
    if row.refused:
        return "unstable" if row.refused.startswith("unstable") else ""
    if row.gain is None or row.failed:
        return "failed"
    if not row.share:
        return "0"
    return "<.01" if row.gain < LEAST else _digits(row.gain)


def _digits(part: float) -> str:
    """A part in %, with two digits or, from 10 on, to whole ones."""
    return f"{100 * part:.2g}" if part < 0.0995 else f"{100 * part:.0f}"


def summary(rows: Sequence[BarRow]) -> str:
    """Of each law the schemes that never gain with the least error, as a sentence, the best law first."""
    pairs = never_gain(rows)
    said = []
    for law in dict.fromkeys(pair.law for pair in pairs):
        own = [pair for pair in pairs if pair.law == law]
        best = [pair for pair in own if pair.error == own[0].error]
        names = ", ".join(pair.scheme for pair in best)
        of = f"the pressure scatters by {100 * best[0].scatter:.2g} %, and {100 * best[0].loss:.2g} % is lost"
        said.append(f"{names} with {law} ({of})")
    sizes = dict.fromkeys(
        (f"{row.elements} elements" + " under gravity" * (row.gravity > 0), row.phases) for row in rows
    )
    elements = " and ".join(text for text, _ in sizes)
    size = f"{elements}, {rows[0].phases} phases, Courant numbers {', '.join(map(str, COURANT))}"
    return f"never gain energy ({size}), with the least error of each law: {'; '.join(said) or 'none'}."


def table(rows: Sequence[BarRow]) -> list[str]:
    """Lines of a table in Markdown, a cell for each scheme and law.

    In it the worst gain at each Courant number; then the largest share of phases that gain, and the largest scatter of
    the pressure; all in %. Schemes with the same numbers share a line.
    """
    pairs = by_pair(rows)
    lines = []
    for name in by_gain(rows):
        cells = []
        for law in LAWS:
            own = pairs[name, law]
            ran = [row for row in own if row.share is not None]
            text = " \\| ".join(percent(row) or "–" for row in own)
            if not ran:
                cells.append("unstable" if any(percent(row) for row in own) else "–")
                continue
            share, scatter = (max(getattr(row, of) or 0.0 for row in ran) for of in ("share", "scatter"))
            cells.append(f"{text}; {100 * share:.0f}; {_digits(scatter / PRESSURE)}")
        lines.append((" | ".join(cells), name))
    head = ["| scheme | " + " | ".join(LAWS) + " |", "|---" * (1 + len(LAWS)) + "|"]
    same = ((cells, ", ".join(f"`{name}`" for _, name in own)) for cells, own in groupby(lines, lambda line: line[0]))
    return [*head, *(f"| {names} | {cells} |" for cells, names in same)]


def contact_map(folder: Path, rows: Sequence[BarRow]) -> None:
    """The rows as CSV, and the worst gains as maps of schemes over laws and Courant numbers, one for each gravity."""
    write_rows(folder / "contact_map.csv", rows)
    for gravity in dict.fromkeys(row.gravity for row in rows):
        name = "contact_map_under_gravity" if gravity else "contact_map"
        _draw(folder / name, [row for row in rows if row.gravity == gravity])


@styled
def _draw(path: Path, rows: Sequence[BarRow]) -> None:
    names, columns = by_gain(rows), [(law, number) for law in LAWS for number in COURANT]
    figure = Figure(figsize=(15, 2.6 + 0.22 * len(names)))
    axes = figure.subplots()
    axes.grid(visible=False)
    for row in rows:
        x, y, text = columns.index((row.law, row.courant)), names.index(row.scheme), percent(row)
        dark = text == "failed" or bool(row.share and row.gain and row.gain > 0.25)
        look = {"facecolor": "white", "hatch": "xxx" if text else "///"}  # no run was made
        if text == "failed":
            look = {"facecolor": FAILED}
        elif not row.refused:
            look = {"facecolor": NEVER if text == "0" else SHADES(NORM(100 * (row.gain or 0.0)))}
        axes.add_patch(Rectangle((x - 0.5, y - 0.5), 1, 1, edgecolor="0.75", linewidth=0.5, **look))
        if not row.refused:
            axes.text(x, y, text, ha="center", va="center", fontsize=7, color="white" if dark else "black")
    axes.set_xlim(-0.5, len(columns) - 0.5)
    axes.set_ylim(len(names) - 0.5, -0.5)
    axes.set_xticks(range(len(columns)), [f"{number:g}" for _, number in columns])
    axes.set_yticks(range(len(names)), names, fontsize=8)
    axes.tick_params(length=0)
    axes.set_xlabel(r"Courant number $c\,h/\ell$, for each law of contact")
    for i, law in enumerate(LAWS):
        at = len(COURANT) * i
        axes.axvline(at - 0.5, color="black", linewidth=1.2)
        axes.text(at + len(COURANT) / 2 - 0.5, -0.7, law, ha="center", va="bottom", fontsize=9)
    shades = figure.colorbar(ScalarMappable(NORM, SHADES), ax=axes, shrink=0.8, pad=0.02, extend="both")
    shades.set_label("worst gain of energy (% of $E_0$)")
    figure.legend(
        handles=[
            Patch(facecolor=NEVER, edgecolor="0.75", label="never gains"),
            Patch(facecolor=FAILED, label="runs failed"),
            Patch(facecolor="white", edgecolor="0.75", hatch="///", label="law not taken"),
            Patch(facecolor="white", edgecolor="0.75", hatch="xxx", label="unstable steps"),
        ],
        loc="outside lower center", ncols=4,
    )  # fmt: skip
    how = "from rest, under gravity, and bounces twice" if rows[0].gravity else "with the velocity 10"
    save(
        figure, path, SECTION,
        f"""A bar of {rows[0].elements} elements falls on a floor {how} (Doyen, Ern & Piperno 2011): by how much its
        energy exceeds that at the start, at any time and the worst of {rows[0].phases} phases of the impact in the
        step, in %. Impulse: a contact acts in its own step alone, as `Contact(gap)`; remembered: its acceleration is
        kept; restitution 0 and 1: the velocity is held, or turned round; massless node: the mass of the node is moved
        to others, and what is remembered is what stiffness balances; penalty: the floor is a spring with the stiffness
        of an element.
        Of all schemes {summary(rows)}""",
    )  # fmt: skip
