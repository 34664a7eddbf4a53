# ---
# jupyter:
#   jupytext:
#     text_representation:
#       extension: .py
#       format_name: percent
#   kernelspec:
#     display_name: Python 3
#     language: python
#     name: python3
# ---

# %% [markdown]
# # Steps that choose themselves: where they pay, and by how much
#
# A constant step has to be as short as the fastest moment of the motion asks for. Three motions have such a moment, and
# long stretches without: a mass that meets a stiff spring, a pendulum that almost stops at the top, and a stiff bar
# whose axial vibration dies away. Each is marched with Bathe's scheme in chosen steps, and then in constant ones, finer
# and finer, until these are as accurate.

# %%
from collections.abc import Callable

import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import substep as ss
from substep.exact.pendulum import ElasticPendulum

plt.style.use("substep.charts")  # the look of all charts of substep

bathe = ss.scheme("bathe")


def as_accurate(error: float, error_of: Callable[[int], float], first: int) -> int:
    """The first number of constant steps in a ladder of factors 1.5 with an error up to the given one.

    The next two have to keep it too: where contact begins within a step is luck, and so is the error of a single run.
    """
    steps, good = first, []
    while len(good) < 3:
        good = [*good, steps] if error_of(steps) <= error else []
        steps += steps // 2
    return good[0]


# %% [markdown]
# ## A mass meets a spring
#
# From a height of 0.2 m the mass approaches with 1 m/s, touches a spring for $\pi$ ms, and leaves with 1 m/s again: a
# straight line, half a sine and another straight line.

# %%
height, omega, span = 0.2, 1000.0, 1.0
touch, leave = height, height + np.pi / omega


def bounced(t: np.ndarray) -> np.ndarray:
    within = -np.sin(omega * (np.clip(t, touch, leave) - touch)) / omega
    return np.where(t < touch, height - t, np.where(t > leave, t - leave, within))


bounce = ss.scene("penalty_bounce", u0=height)
r = ss.march(bounce, bathe, tol=1e-5, t_end=span)
error = np.abs(r.u[:, 0] - bounced(r.t)).max()
made = r.statistics.accepted + r.statistics.rejected


def bounce_error(steps: int) -> float:
    constant = ss.march(bounce, bathe, dt=span / steps, t_end=span)
    return float(np.abs(constant.u[:, 0] - bounced(constant.t)).max())


constant_steps = as_accurate(error, bounce_error, 1000)
print(f"bounce: error {error:.1e} m with {made} chosen steps or {constant_steps} constant ones")
assert r.status == "completed"
assert error < 2e-5
assert r.statistics.longest > 1000 * r.statistics.shortest
assert constant_steps > 100 * made

# %% [markdown]
# ## A pendulum that almost reaches the top
#
# It swings up, lingers for seconds near the top, and falls. Both the fast and the slow part last; what a choice of the
# step can gain here is a small factor.

# %%
swing, span = ss.scene("simple_pendulum"), 12.0
first = [float(swing.u0[0]), float(swing.v0[0])]
near_top = solve_ivp(
    lambda t, y: [y[1], -np.sin(y[0])], (0, span), first, "DOP853", rtol=3e-14, atol=3e-14, dense_output=True
)
r = ss.march(swing, bathe, tol=1e-9, t_end=span)
error = np.abs(r.u[:, 0] - near_top.sol(r.t)[0]).max()
made = r.statistics.accepted + r.statistics.rejected


def swing_error(steps: int) -> float:
    constant = ss.march(swing, bathe, dt=span / steps, t_end=span)
    return float(np.abs(constant.u[:, 0] - near_top.sol(constant.t)[0]).max())


constant_steps = as_accurate(error, swing_error, 100)
print(f"pendulum: error {error:.1e} rad with {made} chosen steps or {constant_steps} constant ones")
assert error < 0.03
assert 2 * made < constant_steps < 20 * made

# %% [markdown]
# ## The stiff bar's first milliseconds
#
# The bar starts unstrained and vibrates axially with a period of 0.35 ms. Whoever wants that vibration in the first
# 5 ms and then the rotation over 10 s gets both in one run: Bathe's scheme damps the vibration, and steps grow as it
# dies. A constant step would have to stay as short as in the beginning.

# %%
stiff, span, early = ss.scene("elastic_pendulum", EA=1e10), 10.0, 0.005
exact = ElasticPendulum(1e10)


def strain_error(r: ss.Response) -> float:
    """Largest error of the strain in the first 5 ms over the largest strain."""
    t = r.t[r.t <= early]
    x = exact.position(t)
    L = stiff.parameters["L"]
    should = ((x * x).sum(axis=1) - L**2) / (2 * L**2)
    return float(np.abs(r.strain[: len(t)] - should).max() / np.abs(should).max())


r = ss.march(stiff, bathe, tol=1e-7, t_end=span)
error, in_time = strain_error(r), int((r.t <= early).sum())
made = r.statistics.accepted + r.statistics.rejected
constant_steps = as_accurate(
    error, lambda n: strain_error(ss.march(stiff, bathe, dt=early / n, t_end=early)), 20
) * round(span / early)
print(f"stiff bar: strain to {100 * error:.1f} % in the first 5 ms; {in_time} steps there, {made} in {span:g} s,")
print(f"           where constant ones as short as needed there are {constant_steps}")
assert constant_steps > 10 * made
assert in_time > 100

figure, axes = plt.subplots(figsize=(8, 3.6))
axes.loglog(r.t[1:], np.diff(r.t), linewidth=0.8)
axes.set(xlabel="$t$ (s)", ylabel="chosen step (s)", title="Stiff bar, Bathe's scheme, tol = 1e-7")

# %% [markdown]
# ## Which costs less?
#
# `choose` tries both and counts operations: its answer has a `tol` where chosen steps cost less, else a `dt`.

# %%
from substep.studies.precision import choose

for scene, t_end in ((bounce, 1.0), (ss.scene("elastic_pendulum", EA=1e4), 1.0)):
    found = choose(scene, 1e-4, t_end=t_end, among=[bathe])
    print(found.text, end="\n\n")
    assert found.best.error <= 1e-4
    assert (found.best.tol is not None) == (scene is bounce)
