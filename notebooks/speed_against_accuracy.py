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
# # Speed against accuracy
#
# How much work does an accuracy cost, and which scheme and step reach it with the least? Sweeps give the data, a
# work-precision chart shows them, and `choose` answers.

# %%
import numpy as np

import substep as ss
from substep.studies.precision import choose

# %% [markdown]
# ## A sweep
#
# Every keyword that holds a row of values is a dimension of the result. Here: how the energy that Newmark-BDF2 keeps on
# the flexible pendulum depends on its sub-step ratio and on the step.

# %%
kept = ss.sweep(
    ss.scene("elastic_pendulum", EA=1e4),
    "newmark_bdf2",
    dt=[0.1, 0.05, 0.025],
    t_end=10.0,
    gamma_t=np.linspace(0.1, 0.9, 9),
)
loss = 1 - kept.energy / ss.scene("elastic_pendulum", EA=1e4).E0
print(loss.to_pandas().map("{:.2e}".format))
assert kept.energy.dims == ("dt", "gamma_t")
assert (kept.status == 0).all()
assert (loss.sel(dt=0.025) < loss.sel(dt=0.1)).all()

# %% [markdown]
# ## A response spectrum, and the scheme's own error in it
#
# Peaks of oscillators under a ground motion. The error beside each value is that against the exact response to the
# record, linear between its samples: short periods are those that a step does not resolve.

# %%
dt, t = 0.01, np.arange(0, 20, 0.01)
rng = np.random.default_rng(1940)
ground = np.exp(-(((t - 6) / 4) ** 2)) * np.convolve(rng.standard_normal(t.size), np.hanning(12), "same")
ground[0] = 0.0
for name in ("average_acceleration", "bathe", "newmark_bdf2"):
    spectrum = ss.response_spectrum(ground, dt, [0.1, 0.5, 2.0], xi=0.05, scheme=name)
    off = np.abs(spectrum.displacement_error)
    print(f"{name:22}", "error of SD at T = 0.1, 0.5, 2 s:", ", ".join(f"{100 * x:.3f} %" for x in off.values))
    assert off[2] < off[0]

# %% [markdown]
# ## Error over work
#
# Duffing's oscillator, against its exact motion (Jacobi's cn). The slope on log-log paper is the derived order.
# Composites solve twice a step: at equal work they have to be that much better. Newmark-BDF2 at its default parameters
# is Bathe's scheme, to the last digit shown.

# %%
from substep.studies.precision.cases import FURTHER
from substep.studies.precision.charts import order
from substep.studies.precision.measure import measure

duffing = FURTHER[0]
exact = duffing.reference()
names = ("average_acceleration", "bathe", "newmark_bdf2", "rk4")
runs = {name: [measure(exact, ss.scheme(name), n, 0) for n in duffing.steps(2)] for name in names}
for name, found in runs.items():
    errors = [run.errors["u"].maximum for run in found]
    reported = (f"{run.cost.evaluations}: {run.errors['u'].maximum:.1e}" for run in found)
    print(f"{name:22} order {order(name)}:", ", ".join(reported))
    assert abs(np.log2(errors[-2] / errors[-1]) / 2 - order(name)) < 0.3

# %%
from matplotlib import style
from matplotlib.figure import Figure

style.use("substep.charts")  # the look of all charts of substep

figure = Figure(figsize=(7, 4.5))
axes = figure.subplots()
for (name, found), line in zip(runs.items(), ("-", "--", "-.", ":"), strict=True):
    cost, error = zip(*((run.cost.evaluations, run.errors["u"].maximum) for run in found), strict=True)
    axes.loglog(cost, error, line, marker="o", label=name)
axes.set(xlabel="force and tangent evaluations", ylabel="largest error of $u$, relative", title="Duffing, 10 periods")
axes.legend()
figure

# %% [markdown]
# ## What to choose
#
# The least work, counted in operations of the compiled kernels, over schemes, steps and models. For the angle of the
# stiff pendulum to 1e-5 rad no axial coordinate is needed; to 1e-7 rad it is.

# %%
stiff = ss.scene("elastic_pendulum", EA=1e10)
among = [ss.scheme(name) for name in ("energy_momentum", "bathe", "wilson_theta")]
answers = {wish: choose(stiff, wish, t_end=10.0, quantity="angle", among=among, chosen=()) for wish in (1e-5, 1e-7)}
for wish, found in answers.items():
    print(found.text, end="\n\n")
    assert found.best.error <= wish
    assert found.runner_up is None or found.runner_up.error > wish
assert answers[1e-5].best.model.name == "rigid_pendulum"
assert answers[1e-7].best.model.name == "elastic_pendulum"
