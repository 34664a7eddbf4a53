"""Text of the function that gives the length of a run's first chosen step, in numbers alone, as a device takes them."""

from collections.abc import Callable, Sequence

from .printing import fill, placed
from .templates.adaptive import FIRST

Names = Sequence[str]


def first_length(numbers: str, start: Sequence[Names], acceleration: Callable[[Names, Names, Names], str]) -> str:
    """Text of `_first`.

    numbers: lines that read a lane's numbers. start: texts of u, v, a at the start. acceleration: the line that stores
    the acceleration at u and v, which are its last two arguments, under the names of the first.
    """
    (u, v, a), d = start, range(len(start[0]))
    then, now, later_u, later_v, of_u, of_v = (
        [f"{name}_{i}" for i in d] for name in ("then", "now", "u", "v", "u_scale", "v_scale")
    )
    scales = [f"{scale} = atol_u + rtol * abs({x}) + 1e-300" for scale, x in zip(of_u, u, strict=True)]
    at_v = zip(of_v, v, strict=True)
    scales += [f"{scale} = atol_v + share_v * fast + rtol * abs({x}) + 1e-300" for scale, x in at_v]
    moves = zip([*later_u, *later_v], [*u, *v], [*v, *then], strict=True)
    slopes = [[f"{new} - {old}" for new, old in zip(*pair, strict=True)] for pair in ((later_v, v), (now, then))]
    return fill(
        FIRST,
        numbers=numbers,
        first=placed([acceleration(then, u, v)], 1),
        fastest=_largest(v),
        steepest=_largest([*a, *then]),
        scales=placed(scales, 1),
        d0=_root_mean_square(u, v, of_u, of_v),
        d1=_root_mean_square(v, then, of_u, of_v),
        moved=placed((f"{new} = {old} + trial * {slope}" for new, old, slope in moves), 1),
        second=placed([acceleration(now, later_u, later_v)], 1),
        moving=_largest(now),
        more=placed((f"{scale} += share_v * fast" for scale in of_v), 2),
        d2=_root_mean_square(*slopes, of_u, of_v),
    )


def _largest(names: Names) -> str:
    """The largest modulus."""
    found = f"abs({names[0]})"
    for name in names[1:]:
        found = f"max({found}, abs({name}))"
    return found


def _root_mean_square(of_u: Names, of_v: Names, u_scale: Names, v_scale: Names) -> str:
    """The root of the mean over the coordinates of the squares of both, over their scales."""
    squares = (
        f"(({x}) / {s}) ** 2 + (({y}) / {r}) ** 2" for x, y, s, r in zip(of_u, of_v, u_scale, v_scale, strict=True)
    )
    return f"np.sqrt(({' + '.join(f'({square})' for square in squares)}) / {len(of_u)})"
