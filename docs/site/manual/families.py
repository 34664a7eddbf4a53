"""A page on which scheme is a member of which, and which are the same: found by `substep equivalences`, not typed."""

from collections.abc import Callable, Iterable, Mapping
from pathlib import Path

from matplotlib.figure import Figure
from substep_derive.declare.schemes import declared
from substep_derive.study.equivalence import MATRIX, SPECTRUM, Equivalence, equivalences
from sympy import Expr

from substep.core.style import COLOURS, styled

from .markdown import code, plain, table

FIGURE = "families.svg"
PARAMETERS = {scheme.name: len(scheme.parameters) for scheme in declared()}
STYLES = {MATRIX: "-", SPECTRUM: "--"}


def pages() -> dict[str, Callable[[Path], str]]:
    """Name of a page -> its text."""
    return {"families": page}


def page(folder: Path) -> str:
    """The figure, and one row for each pair."""
    found = tuple(equivalences(steps=(1,)))
    families(whole(found)).savefig(folder / FIGURE)
    lines = [
        [*(_named(*side) for side in ((e.left, e.left_values), (e.right, e.right_values))), plain(e.kind)]
        for e in sorted(found, key=lambda e: (e.left, e.right))
    ]
    return "\n".join(
        [
            "# Map of families", "",
            "A line leads from a scheme to one that it is at some of its parameters. Solid: amplification matrix and",
            "state are the same, so that both are one scheme on linear systems; dashed: the spectrum is the same at",
            "any damping ratio, as it is of schemes in one box. What follows from other lines has none of its own.", "",
            f"![Which scheme is a member of which]({FIGURE})", "",
            "The table also has pairs that are the same without damping only, or at some parameters of both. They were",
            f"found by solving polynomial equations: {code('substep equivalences')} prints those of all or of some.",
            "Where values depend on parameters, these are free.", "",
            *table(("scheme", "is", "in what"), lines),
        ]
    )  # fmt: skip


def _named(name: str, values: Mapping[str, Expr]) -> str:
    given = ", ".join(f"{k} = {v}" for k, v in values.items() if str(v) != k)
    return f"[{name}](schemes/{name}.md)" + (f" {code(given)}" if given else "")


Pairs = dict[tuple[str, str], str]  # (scheme, what it is at some parameters) -> how much both share


def whole(found: Iterable[Equivalence]) -> Pairs:
    """The pairs of which one scheme is all of the other, damped as well."""
    every: Pairs = {}
    for e in found:
        all_of = all(str(v) == k for k, v in e.right_values.items())
        if all_of and e.kind in STYLES and every.get((e.left, e.right)) != MATRIX:
            every[e.left, e.right] = e.kind
    return every


def alike(every: Pairs) -> dict[str, str]:
    """Of each scheme the first one that it is with all its parameters, or itself."""
    first = {name: name for pair in every for name in pair}
    for one, other in every:
        if PARAMETERS[one] == PARAMETERS[other]:
            kept, gone = sorted((first[one], first[other]), key=[*PARAMETERS].index)
            first = {name: kept if x == gone else x for name, x in first.items()}
    return first


def members(every: Pairs) -> Pairs:
    """The lines of the map: between the first of those that are alike, but for lines that follow from others."""
    first, lines = alike(every), Pairs()
    for (one, member), kind in every.items():
        pair = first[one], first[member]
        if pair[0] != pair[1] and lines.get(pair) != MATRIX:
            lines[pair] = kind

    def follows(one: str, member: str, kind: str) -> bool:
        """Whether a scheme with fewer parameters than the one and more than the member stands between them."""
        return any(
            PARAMETERS[one] > PARAMETERS[c] > PARAMETERS[member]
            and (kind == SPECTRUM or (lines[one, c] == MATRIX == lines[c, member]))
            for c in PARAMETERS
            if (one, c) in lines and (c, member) in lines
        )

    return {pair: kind for pair, kind in lines.items() if not follows(*pair, kind)}


@styled
def families(every: Pairs) -> Figure:
    """Schemes in columns by their number of parameters, those with most of them first, and lines to their members."""
    first, lines = alike(every), members(every)
    texts: dict[str, list[str]] = {}
    for name in PARAMETERS:
        if name in first:
            texts.setdefault(first[name], []).append(name)
    columns: dict[int, list[str]] = {}
    for name in texts:
        columns.setdefault(PARAMETERS[name], []).append(name)
    counts = sorted(columns, reverse=True)
    height = max(sum(len(texts[name]) + 0.7 for name in column) for column in columns.values())
    place: dict[str, tuple[float, float]] = {}
    for x, count in enumerate(counts):
        column = sorted(columns[count], key=lambda name: _mean(lines, place, name, height))
        gap = (height - sum(len(texts[name]) for name in column)) / len(column)
        top = height
        for name in column:
            place[name] = (float(x), top - 0.5 * (gap + len(texts[name])))
            top -= gap + len(texts[name])
    figure = Figure(figsize=(11, 0.22 * height + 0.6))
    axes = figure.subplots()
    for k, ((one, member), kind) in enumerate(lines.items()):
        (x0, y0), (x1, y1) = place[one], place[member]
        axes.plot([x0, x1], [y0, y1], STYLES[kind], color=COLOURS[k % len(COLOURS)], linewidth=1, zorder=1)
    for name, (x, y) in place.items():
        box = {"boxstyle": "round,pad=0.25", "facecolor": "white", "edgecolor": "0.6"}
        axes.text(x, y, "\n".join(texts[name]), ha="center", va="center", fontsize=7, bbox=box, zorder=2)
    titles = {0: "no parameter", 1: "one parameter"}
    axes.set_xticks(range(len(counts)), [titles.get(count, f"{count} parameters") for count in counts])
    axes.set_yticks([])
    axes.set(xlim=(-0.5, len(counts) - 0.5), ylim=(0, height))
    axes.xaxis.tick_top()
    axes.tick_params(length=0)
    for side in axes.spines.values():
        side.set_visible(False)
    return figure


def _mean(lines: Pairs, place: dict[str, tuple[float, float]], name: str, height: float) -> float:
    """How far down the schemes are that have this one as a member, for lines to cross little."""
    above = [height - place[one][1] for one, member in lines if member == name and one in place]
    return sum(above) / len(above) if above else 0.0
