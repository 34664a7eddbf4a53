"""Laws that yield, of which what remains of the elongation is the memory."""

from collections.abc import Callable
from itertools import pairwise

from sympy import Expr, Integer, Interval, Piecewise, Symbol

from ..branches import clip, larger, smaller
from ..law import Law, before, e
from ..parameter import POSITIVE
from ..scene import optional, required

k, q_y, alpha, p = (Symbol(name) for name in ("k", "q_y", "alpha", "p"))
kappa, stiffness, gap = (Symbol(name) for name in ("kappa", "stiffness", "gap"))
HARDENING = optional(alpha, 0, Interval.Ropen(0, 1))

soft = (1 - alpha) * k  # the stiffness of the part that yields, at the force (1 - alpha)*q_y

bilinear = Law(
    "bilinear",
    parameters=(required(k), required(q_y), HARDENING),
    memory={p: 0},
    update={p: clip(p, e - q_y / k, e + q_y / k)},
    force=alpha * k * e + soft * (e - p),
    stored=alpha * k * e**2 / 2 + soft * (e - p) ** 2 / 2,
    dissipated=soft * (e - p) * (p - before(p)),
    reference="kinematic hardening, elastic-perfectly plastic where alpha = 0: Chopra, Dynamics of Structures, 7.1",
)

# with the accumulated plastic elongation kappa the strength grows, by the modulus that gives the slope alpha*k
modulus = alpha * k / (1 - alpha)
trial, limit, flow = k * (e - p), q_y + modulus * kappa, (1 - alpha) / k
above, below = larger(trial - limit, 0), smaller(trial + limit, 0)  # how far the force would be beyond both limits
grown = kappa - before(kappa)

isotropic_bilinear = Law(
    "isotropic_bilinear",
    parameters=(required(k), required(q_y), HARDENING),
    memory={p: 0, kappa: 0},
    # no sum of both for p: one branch of that would be beyond both limits, where the force falls
    update={
        p: clip(p, p + flow * (trial - limit), p + flow * (trial + limit)),
        kappa: kappa + flow * (above - below),
    },
    force=k * (e - p),
    stored=k * (e - p) ** 2 / 2,
    dissipated=(q_y + modulus * (kappa + before(kappa)) / 2) * grown,
    reference="isotropic hardening: Simo & Hughes, Computational Inelasticity (1998), 1.4",
)

coulomb = Law(
    "coulomb",
    parameters=(required(stiffness), required(q_y)),
    memory={p: 0},
    update={p: clip(p, e - q_y / stiffness, e + q_y / stiffness)},
    force=stiffness * (e - p),
    stored=stiffness * (e - p) ** 2 / 2,
    dissipated=stiffness * (e - p) * (p - before(p)),
    reference="dry friction of the force q_y, with the stiffness of what sticks",
)

slip = Law(
    "slip",
    parameters=(required(stiffness), required(q_y), optional(gap, 0, Interval(0, POSITIVE.end))),
    memory={p: 0},
    update={p: larger(p, e - gap - q_y / stiffness)},
    force=larger(0, stiffness * (e - gap - p)),
    stored=larger(0, stiffness * (e - gap - p)) ** 2 / (2 * stiffness),
    dissipated=q_y * (p - before(p)),
    reference="a gap, then elastic, then yielding, in tension alone: OpenSees, ElasticPPGap",
)

# towards the peak reached before on the other side; e_0, q_0: where it stands, e_p, e_m: peaks, z_p, z_m: where the
# lines to them begin. A path up follows the unloading line, or the line to the peak and beyond it the backbone,
# whichever is lower. A line to a peak is never steeper than k: before anything has yielded it has that slope, and a
# rounding more of it would move the crossing of the unloading line at each commit, by a share of what it has moved.
e_0, q_0, e_p, e_m, z_p, z_m = (Symbol(name) for name in ("e_0", "q_0", "e_p", "e_m", "z_p", "z_m"))
crossing = e_0 - q_0 / k
from_p, from_m = Piecewise((crossing, q_0 < 0), (z_p, True)), Piecewise((crossing, q_0 > 0), (z_m, True))
peak_p, peak_m = q_y + alpha * (k * e_p - q_y), -q_y + alpha * (k * e_m + q_y)
slope_p, slope_m = smaller(k, peak_p / (e_p - from_p)), smaller(k, peak_m / (e_m - from_m))


def up(x: Expr) -> Expr:
    """The force on a path up."""
    return smaller(q_0 + k * (x - e_0), smaller(slope_p * (x - from_p), peak_p) + larger(alpha * k * (x - e_p), 0))


def down(x: Expr) -> Expr:
    """The force on a path down."""
    return larger(q_0 + k * (x - e_0), larger(slope_m * (x - from_m), peak_m) + smaller(alpha * k * (x - e_m), 0))


def meets(slope: Expr, begins: Expr) -> Expr:
    """Where the unloading line meets the line to a peak; where it stands, if these are one line."""
    apart = k - slope
    return Piecewise(((k * e_0 - q_0 - slope * begins) / apart, apart > k / 10**9), (e_0, True))


def work(force: Callable[[Expr], Expr], low: Expr, high: Expr, *corners: Expr) -> Expr:
    """The integral of a force from e_0 to e, which bends at corners between low and high, the ends in their order."""
    points = [e_0, *(clip(x, low, high) for x in corners), e]
    return sum(((force(x) + force(y)) * (y - x) / 2 for x, y in pairwise(points)), Integer(0))


followed = smaller(larger(up(e), q_0), down(e))
first_p, first_m = meets(slope_p, from_p), meets(slope_m, from_m)
done = Piecewise(
    (work(up, e_0, e, first_p, larger(first_p, e_p)), e >= e_0),
    (work(down, e, e_0, first_m, smaller(first_m, e_m)), True),
)
committed = {s: before(s) for s in (e_0, q_0, e_p, e_m, z_p, z_m)}

clough = Law(
    "clough",
    parameters=(required(k), required(q_y), HARDENING),
    memory={e_0: 0, q_0: 0, e_p: q_y / k, e_m: -q_y / k, z_p: 0, z_m: 0},
    update={
        e_0: e,
        q_0: followed,
        e_p: larger(e_p, e),
        e_m: smaller(e_m, e),
        z_p: Piecewise((crossing, (q_0 < 0) & (followed >= 0)), (z_p, True)),
        z_m: Piecewise((crossing, (q_0 > 0) & (followed <= 0)), (z_m, True)),
    },
    force=q_0,
    stored=q_0**2 / (2 * k),
    dissipated=done.xreplace(committed) - (q_0**2 - before(q_0) ** 2) / (2 * k),
    reference="peak-oriented, the stiffness degrades: Clough & Johnston, Proc. Japan Earthq. Eng. Symp. (1966) 227-232",
)

ALL = (bilinear, isotropic_bilinear, coulomb, slip, clough)
