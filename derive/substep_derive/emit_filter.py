"""Order of a filter -> text of the kernels that follow the peaks of what it puts out."""

from . import templates_march
from .emit_march import WIDTH, nested, place_lines
from .printing import fill
from .transfer import ORDERS


def filter_module() -> str:
    """Text of linear_filter.py, without its banner."""
    head = fill(templates_march.FILTER_HEADER, width=WIDTH)
    return head + "".join(_kernels(d, followed) for d in ORDERS for followed in (1, 3))


def filter_rows(d: int) -> list[str]:
    """Names of the rows of `transfer`."""
    return ["P", *(f"g{i}" for i in range(1, d)), *_taps("u", d), "S", *_taps("v", d), *_taps("a", d)]


def _taps(kind: str, d: int) -> list[str]:
    return [f"{kind}{i}" for i in range(d)]


def _kernels(d: int, followed: int) -> str:
    e, peaks = [f"e{i}" for i in range(d)], [f"t{r}" for r in range(followed)]
    moving = ["q", *e[1:], *peaks]
    given = filter_rows(d) if followed == 3 else filter_rows(d)[: 2 * d + 1]
    row = {name: k for k, name in enumerate([*moving, *given])}

    def at(name: str) -> str:
        return f"s[{row[name] * WIDTH} + j]" if row[name] else "s[j]"

    def told(kind: str) -> str:
        terms = [f"{at(name)} * {x}" for name, x in zip(_taps(kind, d), e, strict=True)]
        return nested([*reversed(terms), *(["q"] if kind == "u" else [])])

    back = nested([*(f"{at(f'g{i}')} * e{i}" for i in range(d - 1, 0, -1)), "f0"])
    step = [f"e0 = ({back}) - {at('P')} * q", "q += e0"]
    step += [f"{t} = max({t}, abs({told(kind)}))" for t, kind in zip(peaks, "uva", strict=False)]
    step += [f"{later} = {sooner}" for sooner, later in zip(reversed(e[:-1]), reversed(e[1:]), strict=True)]
    return fill(
        templates_march.FILTER,
        d=d, followed=followed, width=WIDTH, rows=len(row), given=len(given), moved=len(moving), peaks=row["t0"],
        scale=row["S"] * WIDTH, moving=", ".join(moving), at_moving=", ".join(map(at, moving)),
        step=place_lines(step, 4), step_alone=place_lines(step, 3),
    )  # fmt: skip
