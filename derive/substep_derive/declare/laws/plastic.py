"""Laws that yield, of which what remains of the elongation is the memory."""

from sympy import Interval, Max, Min, Piecewise, Symbol

from ..law import Law, before, clip, e
from ..scene import POSITIVE, optional, required

k, q_y, alpha, p = (Symbol(name) for name in ("k", "q_y", "alpha", "p"))
kappa, stiffness, gap = (Symbol(name) for name in ("kappa", "stiffness", "gap"))
HARDENING = optional(alpha, 0, Interval.Ropen(0, 1))

soft = (1 - alpha) * k  # the stiffness of the part that yields, at the force (1 - alpha)*q_y

bilinear = Law(
    "bilinear",
    parameters=(required(k), required(q_y), HARDENING),
    memory={p: 0},
    update={p: e - clip(e - p, -q_y / k, q_y / k)},
    force=alpha * k * e + soft * (e - p),
    stored=alpha * k * e**2 / 2 + soft * (e - p) ** 2 / 2,
    dissipated=soft * (e - p) * (p - before(p)),
    reference="kinematic hardening, elastic-perfectly plastic where alpha = 0: Chopra, Dynamics of Structures, 7.1",
)

# with the accumulated plastic elongation kappa the strength grows, by the modulus that gives the slope alpha*k
modulus = alpha * k / (1 - alpha)
trial, limit = k * (e - p), q_y + modulus * kappa
returned = Max(Min(trial, limit + alpha * (trial - limit)), -limit + alpha * (trial + limit))
grown = kappa - before(kappa)

isotropic_bilinear = Law(
    "isotropic_bilinear",
    parameters=(required(k), required(q_y), HARDENING),
    memory={p: 0, kappa: 0},
    update={p: e - returned / k, kappa: kappa + Max(e - returned / k - p, p - e + returned / k)},
    force=k * (e - p),
    stored=k * (e - p) ** 2 / 2,
    dissipated=(q_y + modulus * (kappa + before(kappa)) / 2) * grown,
    reference="isotropic hardening: Simo & Hughes, Computational Inelasticity (1998), 1.4",
)

coulomb = Law(
    "coulomb",
    parameters=(required(stiffness), required(q_y)),
    memory={p: 0},
    update={p: e - clip(e - p, -q_y / stiffness, q_y / stiffness)},
    force=stiffness * (e - p),
    stored=stiffness * (e - p) ** 2 / 2,
    dissipated=stiffness * (e - p) * (p - before(p)),
    reference="dry friction of the force q_y, with the stiffness of what sticks",
)

slip = Law(
    "slip",
    parameters=(required(stiffness), required(q_y), optional(gap, 0, Interval(0, POSITIVE.end))),
    memory={p: 0},
    update={p: Max(p, e - gap - q_y / stiffness)},
    force=Max(0, stiffness * (e - gap - p)),
    stored=Max(0, stiffness * (e - gap - p)) ** 2 / (2 * stiffness),
    dissipated=q_y * (p - before(p)),
    reference="a gap, then elastic, then yielding, in tension alone: OpenSees, ElasticPPGap",
)

# towards the peak reached before on the other side; e_0, q_0: where it stands, e_p, e_m: peaks, z_p, z_m: where the
# lines to them begin. A path up follows the unloading line, the line to the peak and the backbone, whichever is lowest.
e_0, q_0, e_p, e_m, z_p, z_m = (Symbol(name) for name in ("e_0", "q_0", "e_p", "e_m", "z_p", "z_m"))
unloading = q_0 + k * (e - e_0)
crossing = e_0 - q_0 / k
from_p, from_m = Piecewise((crossing, q_0 < 0), (z_p, True)), Piecewise((crossing, q_0 > 0), (z_m, True))
peak_p, peak_m = q_y + alpha * (k * e_p - q_y), -q_y + alpha * (k * e_m + q_y)
slope_p, slope_m = peak_p / (e_p - from_p), peak_m / (e_m - from_m)
up = Min(unloading, slope_p * (e - from_p), q_y + alpha * (k * e - q_y))
down = Max(unloading, slope_m * (e - from_m), -q_y + alpha * (k * e + q_y))
followed = Min(Max(up, q_0), down)

clough = Law(
    "clough",
    parameters=(required(k), required(q_y), HARDENING),
    memory={e_0: 0, q_0: 0, e_p: q_y / k, e_m: -q_y / k, z_p: 0, z_m: 0},
    update={
        e_0: e,
        q_0: followed,
        e_p: Max(e_p, e),
        e_m: Min(e_m, e),
        z_p: Piecewise((crossing, (q_0 < 0) & (followed >= 0)), (z_p, True)),
        z_m: Piecewise((crossing, (q_0 > 0) & (followed <= 0)), (z_m, True)),
    },
    force=q_0,
    stored=q_0**2 / (2 * k),
    reference="peak-oriented, the stiffness degrades: Clough & Johnston, Proc. Japan Earthq. Eng. Symp. (1966) 227-232",
)

ALL = (bilinear, isotropic_bilinear, coulomb, slip, clough)
