"""Order of a digital filter -> text of the kernels that find the peaks of its output."""

from collections.abc import Callable
from functools import partial

from ..oscillator.transfer import ORDERS
from .march_module import WIDTH, nested, stretch
from .printing import fill, placed
from .templates.decorators import COMPILE_AND_INNER
from .templates.march import FILTER, FILTER_HEADER
from .templates.registers import WIDEST
from .templates.thread import COMPILE_KERNEL, FILTER_THREADS


def filter_module() -> str:
    """Text of linear_filter.py, without its banner."""
    head = fill(FILTER_HEADER, imports=WIDEST, whole=2 * WIDTH)
    return head + COMPILE_AND_INNER + "".join(_kernels(d, followed) for d in ORDERS for followed in (1, 3))


def filter_rows(d: int) -> list[str]:
    """Names of the rows that `transfer` of a scheme's module computes."""
    return ["P", *(f"g{i}" for i in range(1, d)), *_taps("u", d), "S", *_taps("v", d), *_taps("a", d)]


def _taps(kind: str, d: int) -> list[str]:
    return [f"{kind}{i}" for i in range(d)]


def filter_threads(d: int, followed: int) -> str:
    """Text of the module that finds the peaks of filters of that order in the threads of a GPU."""
    moving, given = _moving(d, followed), _given(d, followed)
    lines = [line for stage in _step(d, followed, str, str) for line in stage]
    return fill(
        FILTER_THREADS,
        compiled=COMPILE_KERNEL,
        followed=followed,
        read=placed((f"{name} = T[{r}, lane]" for r, name in enumerate(given)), 2),
        moving=", ".join(moving),
        zeros=", ".join("0.0" for _ in moving),
        step=placed(lines, 3),
        write=placed((f"peak[{r}, lane] = t{r}" for r in range(1, followed)), 2),
    )


def _moving(d: int, followed: int) -> list[str]:
    """Names of what changes from step to step: what is marched, and the peaks so far."""
    return ["q", *(f"e{i}" for i in range(1, d)), *(f"t{r}" for r in range(followed))]


def _given(d: int, followed: int) -> list[str]:
    """Names of what a lane is given."""
    return [*filter_rows(d), "a_q"] if followed == 3 else filter_rows(d)[: 2 * d + 1]


def _step(d: int, followed: int, at: Callable[[str], str], own: Callable[[str], str]) -> list[list[str]]:
    """Lines of a step in stages; at: the text of a number that is given; own: that of one that changes."""
    e = [f"e{i}" for i in range(d)]

    def output(kind: str) -> str:
        terms = [f"{at(name)} * {own(x)}" for name, x in zip(_taps(kind, d), e, strict=True)]
        factors = {"u": "", "a": f"{at('a_q')} * "} if followed == 3 else {"u": ""}
        return nested([*reversed(terms), *([factors[kind] + own("q")] if kind in factors else [])])

    back = nested([*(f"{at(f'g{i}')} * {own(f'e{i}')}" for i in range(d - 1, 0, -1)), "f0"])
    peaks = [f"t{r}" for r in range(followed)]
    return [
        [f"{own('e0')} = ({back}) - {at('P')} * {own('q')}"],
        [f"{own('q')} += {own('e0')}"],
        [f"{own(t)} = max({own(t)}, abs({output(kind)}))" for t, kind in zip(peaks, "uva", strict=False)],
        [f"{own(b)} = {own(a)}" for a, b in zip(reversed(e[:-1]), reversed(e[1:]), strict=True)],
    ]


def _kernels(d: int, followed: int) -> str:
    moving, given = _moving(d, followed), _given(d, followed)
    row = {name: k for k, name in enumerate([*moving, *given])}

    def at(name: str, half: int) -> str:
        place = 2 * WIDTH * row[name] + WIDTH * half
        return f"s[{place} + j]" if place else "s[j]"

    # lines of the halves of a block alternate, so that none waits
    halves = [_step(d, followed, partial(at, half=half), lambda name, half=half: f"{name}_{half}") for half in range(2)]
    step = [line for stage in zip(*halves, strict=True) for half in stage for line in half]
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
