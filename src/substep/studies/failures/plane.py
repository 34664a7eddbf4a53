"""The plane of two quantities of the stiff pendulum, at any depth: what becomes of a run at each of its points."""

from collections.abc import Iterable, Mapping
from itertools import combinations
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ...core import device as devices
from ...core.errors import called_as, real_number
from ...core.scene_catalogue import scene_info
from ...core.scenes import make_scene
from ...core.schemes import Array, Scheme
from ...run.schemes import numbers_only
from .maps import MOST_STEPS, SPAN, STEPS
from .outcomes import WORDS, Outcome, run, whole_steps
from .table import stiff

if TYPE_CHECKING:
    import xarray

    from ...derived.modules import Declaration

LANES = 1 << 19  # runs of one march, which take about 300 bytes each while it lasts


class Quantity(NamedTuple):
    """name: of a parameter of the pendulum, or h; limits: between which a page shows it; usual: where it stays."""

    name: str
    meaning: str
    unit: str
    limits: tuple[float, float]
    usual: float


QUANTITIES = {
    x.name: x
    for x in (
        Quantity("h", "step", "s", STEPS, 0.05),
        Quantity("v0", "speed at the start", "m/s", (0.1, 100.0), stiff().parameters["v0"]),
        Quantity("EA", "axial stiffness", "N", (1e4, 1e12), stiff().parameters["EA"]),
    )
}
PLANES = {"-".join(pair): pair for pair in (("h", "EA"), *combinations(QUANTITIES, 2))}  # by name: x and y

Range = tuple[float, float]


@called_as('failure_map("bathe", h=(1e-3, 1.0), EA=(1e4, 1e12), pixels=(4000, 4000))')
def failure_map(
    scheme: "Scheme | str | Declaration",
    *,
    h: float | Range,
    v0: float | Range = QUANTITIES["v0"].usual,
    EA: float | Range = QUANTITIES["EA"].usual,
    pixels: tuple[int, int] = (256, 256),
    columns: range | None = None,
    rows: range | None = None,
    t_end: float = SPAN,
    most_steps: int = MOST_STEPS,
    device: devices.Device = "cpu",
    lanes: int = LANES,
) -> "xarray.Dataset":
    """The outcome of a run of the stiff pendulum at each pixel of a map over two of h (s), v0 (m/s) and EA (N).

    Two of the three are ranges, above 0, in equal ratios from the first end on, without the second; the first named
    above is x, the other y. The third is one number. A run starts with a0 = -19.6 m/s^2 (v0/7.72 m/s)^2 along the bar,
    as it turns, and takes t_end (s) or most_steps steps, whichever is shorter. pixels: how many along x and y.
    columns, rows: those of them that are run, by default all: `range(0, 4000, 2)` is every second one. The run at a
    pixel is the same whatever others are run, on one device. lanes: the most runs of one march, in chunks of which all
    are run, which bounds the memory.

    Returns a Dataset over the two names, y first: outcome, the place in `WORDS`, and max_ratio, the largest E/E0 of the
    states before a run ends. Raises ValueError for ranges, counts and columns that are none, and as `substep.scheme`;
    for the device as `substep.core.device.found`.

    >>> found = failure_map("newmark_bdf2", h=(0.02, 0.8), v0=(1.0, 10.0), pixels=(8, 4))
    >>> found.outcome.dims, found.outcome.shape
    (('v0', 'h'), (4, 8))
    """
    from ...core.result_dataset import ResultDataset  # noqa: PLC0415 (xarray only when asked for)

    one = numbers_only(scheme, "draw a map for each")
    given = {"h": h, "v0": v0, "EA": EA}
    x, y = _swept(given)
    asked: Mapping[str, range | None] = {x: columns, y: rows}
    along = {
        name: _points(name, given[name], total, some) for (name, some), total in zip(asked.items(), pixels, strict=True)
    }
    fixed = {name: real_number(name, value, positive=True) for name, value in given.items() if name not in along}
    if not (isinstance(most_steps, int) and isinstance(lanes, int) and most_steps > 0 and lanes > 0):
        raise ValueError(f"expected most_steps and lanes as counts above 0, got {most_steps!r} and {lanes!r}")
    span, wide = real_number("t_end", t_end, positive=True), len(along[x])
    word, ratio = np.empty(wide * len(along[y]), dtype=np.uint8), np.empty(wide * len(along[y]))
    with devices.on(device):
        for first in range(0, len(word), lanes):
            row, column = np.divmod(np.arange(first, min(first + lanes, len(word))), wide)
            outcome = _runs(one, {**fixed, x: along[x][column], y: along[y][row]}, span, most_steps)
            word[first : first + lanes], ratio[first : first + lanes] = outcome.word, outcome.max_ratio
    shape, meanings = (len(along[y]), wide), " ".join(word.replace(" ", "_") for word in WORDS)
    flags = {"flag_values": list(range(len(WORDS))), "flag_meanings": meanings, "long_name": "outcome"}
    about = {name: {"units": QUANTITIES[name].unit, "long_name": QUANTITIES[name].meaning} for name in given}
    return ResultDataset(
        {
            "outcome": ((y, x), word.reshape(shape), flags),
            "max_ratio": ((y, x), ratio.reshape(shape), {"units": "1", "long_name": "largest E/E0"}),
        },
        {name: (name, values, about[name]) for name, values in along.items()},
        {"scheme": one.name, "scene": "elastic_pendulum", **fixed, "t_end": span, "most_steps": most_steps},
    )


def _runs(scheme: Scheme, at: Mapping[str, Any], span: float, most: int) -> Outcome:
    """The outcomes of P runs at h, v0 and EA, (P,) or numbers."""
    pendulum = stiff()
    swept = {name: at[name] for name in pendulum.parameters if name in at}
    a0 = pendulum.a0 * (np.asarray(at["v0"])[..., None] / QUANTITIES["v0"].usual) ** 2
    lanes = make_scene(scene_info("elastic_pendulum", {}), {**pendulum.parameters, **swept}, a0, None)
    P = max(map(np.size, at.values()))
    h = np.broadcast_to(at["h"], P).astype(float)
    return run(lanes, scheme, h, np.minimum(whole_steps(span, h), most))[1]


def _swept(given: Mapping[str, Any]) -> Iterable[str]:
    """The two that are ranges."""
    found = [name for name, value in given.items() if np.ndim(value)]
    if len(found) != 2:
        ranges = ", ".join(found) or "none"
        raise ValueError(
            f"expected ranges (first, last) for two of h, v0 and EA and a number for the third, got ranges for {ranges}"
        )
    return found


def _points(name: str, limits: Any, total: int, some: range | None) -> Array:
    """The values at some of the pixels of a range: first*(last/first)**(k/total), to the bit whatever others are."""
    first, last = (real_number(name, x, positive=True) for x in limits) if np.shape(limits) == (2,) else (1.0, 0.0)
    if not first < last:
        raise ValueError(f"expected {name} as a range (first, last) with first < last, got {limits!r}")
    if not isinstance(total, int) or total < 1:
        raise ValueError(f"expected pixels along {name} as a count above 0, got {total!r}")
    chosen = range(total) if some is None else some
    if not len(chosen) or min(chosen[0], chosen[-1]) < 0 or max(chosen[0], chosen[-1]) >= total:
        raise ValueError(f"expected some of the {total} pixels along {name}, 0 to {total - 1}, got {some}")
    return first * (last / first) ** (np.array(chosen) / total)
