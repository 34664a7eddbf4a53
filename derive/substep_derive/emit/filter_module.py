"""Order of a digital filter -> text of the kernels that find the peaks of its output."""

from ..oscillator.transfer import ORDERS
from .march_module import WIDTH, nested, stretch
from .printing import fill, placed
from .templates.decorators import COMPILE_AND_INNER
from .templates.march import FILTER, FILTER_HEADER
from .templates.widest import WIDEST, WIDEST_IMPORTS


def filter_module() -> str:
    """Text of linear_filter.py, without its banner."""
    head = fill(FILTER_HEADER, imports=WIDEST_IMPORTS, whole=2 * WIDTH)
    return head + COMPILE_AND_INNER + WIDEST + "".join(_kernels(d, followed) for d in ORDERS for followed in (1, 3))


def filter_rows(d: int) -> list[str]:
    """Names of the rows that `transfer` of a scheme's module computes."""
    return ["P", *(f"g{i}" for i in range(1, d)), *_taps("u", d), "S", *_taps("v", d), *_taps("a", d)]


def _taps(kind: str, d: int) -> list[str]:
    return [f"{kind}{i}" for i in range(d)]


def _kernels(d: int, followed: int) -> str:
    e, peaks = [f"e{i}" for i in range(d)], [f"t{r}" for r in range(followed)]
    moving = ["q", *e[1:], *peaks]
    given = [*filter_rows(d), "a_q"] if followed == 3 else filter_rows(d)[: 2 * d + 1]
    row = {name: k for k, name in enumerate([*moving, *given])}

    def at(name: str, half: int) -> str:
        place = 2 * WIDTH * row[name] + WIDTH * half
        return f"s[{place} + j]" if place else "s[j]"

    def lines(half: int) -> list[list[str]]:
        """Lines of a step of one half of the block, in stages; those of the halves alternate, so that none waits."""
        own = {name: f"{name}_{half}" for name in [*e, *moving]}

        def output(kind: str) -> str:
            terms = [f"{at(name, half)} * {own[x]}" for name, x in zip(_taps(kind, d), e, strict=True)]
            factors = {"u": "", "a": f"{at('a_q', half)} * "} if followed == 3 else {"u": ""}
            return nested([*reversed(terms), *([factors[kind] + own["q"]] if kind in factors else [])])

        back = nested([*(f"{at(f'g{i}', half)} * {own[f'e{i}']}" for i in range(d - 1, 0, -1)), "f0"])
        return [
            [f"{own['e0']} = ({back}) - {at('P', half)} * {own['q']}"],
            [f"{own['q']} += {own['e0']}"],
            [f"{own[t]} = max({own[t]}, abs({output(kind)}))" for t, kind in zip(peaks, "uva", strict=False)],
            [f"{own[b]} = {own[a]}" for a, b in zip(reversed(e[:-1]), reversed(e[1:]), strict=True)],
        ]

    step = [line for stage in zip(lines(0), lines(1), strict=True) for half in stage for line in half]
    places = {f"{name}_{half}": at(name, half) for half in range(2) for name in moving}
    doc = "March a block through all samples f; rows of s: q, e1, ... and the peaks, then those of `transfer`."
    text = stretch(
        f"_filter_{d}_{followed}",
        doc,
        2,
        places,
        {"f0": "f"},
        lambda depth: placed(step, depth),
        "i, n = 1, f.size - 1",
    )
    return text + fill(
        FILTER,
        d=d, followed=followed, whole=2 * WIDTH, rows=len(row), given=len(given), moved=len(moving),
        peaks=row["t0"], scale=2 * WIDTH * row["S"],
    )  # fmt: skip
