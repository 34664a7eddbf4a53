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
# # Inelastic response: springs that yield, and what a scheme makes of them
#
# A law with memory is declared once, and the schemes of the catalogue march an oscillator with it. Here are the loops
# of four laws; an oscillator that yields under a pulse, with its account of energy; the order of schemes across
# yielding and unloading; a map of where schemes go wrong; and an inelastic spectrum.

# %%
import matplotlib.pyplot as plt
import numpy as np

import substep as ss
from substep.figures.inelastic_charts import inelastic_figure

plt.style.use("substep.charts")  # the look of all charts of substep

# %% [markdown]
# ## Loops
#
# Each law is strained to and fro, farther with every cycle. In a closed cycle the area of the loop is what the law has
# dissipated in it; its own account must say the same.

# %%
T = 1.0
omega = 2 * np.pi / T
phase = np.linspace(0.0, 3.0, 1201)  # cycles
path = (0.5 + 0.5 * np.floor(phase)) * np.sin(2 * np.pi * phase)  # m
shown = {
    "bilinear": {"k": 10.0, "q_y": 3.0, "alpha": 0.1},
    "clough": {"k": 10.0, "q_y": 3.0, "alpha": 0.1},
    "bouc_wen": {"k": 10.0, "q_y": 3.0, "alpha": 0.1, "n": 2.0},
    "slip": {"stiffness": 10.0, "q_y": 3.0, "gap": 0.2},
}
figure, axes = plt.subplots(1, 4, figsize=(12, 3.2), sharex=True, sharey=True)
for panel, (name, parameters) in zip(axes, shown.items(), strict=True):
    law = ss.law(name, **parameters)
    force, memory = law.loop(path)
    panel.plot(path, force, "-")
    panel.set(title=name, xlabel="elongation $e$ (m)")
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(path))])
    stored = law.evaluate(path[-1:], memory=memory[-1:]).stored[0]
    dissipated = memory[-1, law.memory.index("dissipated")]
    print(f"{name}: work {work[-1]:.3f} J, stored {stored:.3f} J, dissipated {dissipated:.3f} J")
    assert abs(work[-1] - stored - dissipated) < 2e-3 * dissipated  # the trapezoidal rule's error at bends
axes[0].set_ylabel("force $q$ (N)")

# %% [markdown]
# ## A pulse
#
# An elastic-perfectly plastic oscillator under half a sine. It yields, is unloaded, and vibrates about the displacement
# that remains. What the load puts in is damped by the damper, dissipated by the spring, stored, or kinetic.

# %%
pulse = ss.HalfSine(40.0, 0.8)
given = {"omega": omega, "xi": 0.05, "load": pulse}
yielding = ss.scene("hysteretic_oscillator", law="bilinear", strength=20.0, **given)
r = ss.march(yielding, "average_acceleration", dt=0.002, t_end=4.0)
velocity = r.v[:, 0]


def accumulated(power: np.ndarray) -> np.ndarray:
    return np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]) * np.diff(r.t))])


put_in, damped = accumulated(pulse(r.t) * velocity), accumulated(2 * 0.05 * omega * velocity**2)
kinetic = 0.5 * velocity**2
parts = {
    "dissipated by the spring": r.energy_dissipated,
    "dissipated by the damper": damped,
    "stored in the spring": r.energy - kinetic,
    "kinetic": kinetic,
}
left_over = put_in - sum(parts.values())
print(f"put in {put_in[-1]:.2f} J/kg, left over {np.abs(left_over).max():.1e} J/kg")
assert np.abs(left_over).max() < 1e-4 * put_in.max()
assert np.abs(r.force).max() <= 20.0 * (1 + 1e-12)
assert np.all(np.diff(r.energy_dissipated) >= 0)
remains = r.memory["p"][-1]
assert abs(r.u[-1, 0] - remains) < 0.5 * 20.0 / omega**2  # it vibrates about what remains

figure, axes = plt.subplots(1, 3, figsize=(12, 3.4))
axes[0].plot(r.t, r.u[:, 0], "-", label="$u$")
axes[0].plot(r.t, r.memory["p"], "--", label="plastic part $p$")
axes[0].set(xlabel="time $t$ (s)", ylabel="displacement (m)")
axes[0].legend()
axes[1].plot(r.u[:, 0], r.force, "-")
axes[1].set(xlabel="displacement $u$ (m)", ylabel="spring force per mass $q$ (m/s$^2$)")
axes[2].stackplot(r.t, *parts.values(), labels=parts, colors=["#56B4E9", "#E69F00", "#009E73", "#F0E442"])
axes[2].plot(r.t, put_in, "k-", linewidth=1.0, label="put in by the load")
axes[2].set(xlabel="time $t$ (s)", ylabel="energy per mass (J/kg)")
axes[2].legend(loc="lower right", frameon=True)

# %% [markdown]
# ## The order across yielding and unloading
#
# The force bends where the spring yields and where it unloads, so that no scheme has an order above two across such
# events, however high its own. A single error is erratic, since it depends on where in a step an event falls; the table
# takes the root of the mean square over several strengths. In place of the exact motion stands one of 40 000 steps.

# %%
strengths, span, ladder = np.linspace(12.0, 24.0, 40), 2.0, (50, 100, 200, 400, 800)


def at_end(scheme: str, n: int) -> np.ndarray:
    """The displacement after n steps, for each strength."""
    shared = {"dt": span / n, "t_end": span, "strength": strengths, "hardening": 0.1, **given}
    return ss.sweep("hysteretic_oscillator", scheme, keep="final", **shared).u.to_numpy()[:, 0]


exact = at_end("bathe", 40_000)
assert np.abs(at_end("rk4", 40_000) - exact).max() < 1e-7
print("scheme               own order" + "".join(f"{n:>9} steps" for n in ladder) + "   observed")
for name in ("average_acceleration", "bathe", "rk4", "backward_euler"):
    errors = [float(np.sqrt(np.mean((at_end(name, n) - exact) ** 2))) for n in ladder]
    observed = -np.polyfit(np.log(ladder[1:]), np.log(errors[1:]), 1)[0]
    order = ss.scheme(name).order
    assert order is not None
    print(f"{name:<20} {order[0]:>9}" + "".join(f"{e:>15.1e}" for e in errors) + f"   {observed:>8.2f}")
    assert abs(observed - min(order[0], 2)) < 0.25

# %% [markdown]
# ## Where do schemes go wrong?
#
# Step over strength, or rather over the pulse's peak in strengths: how far what remains is from that of a fine run,
# relative. Colours grow lighter with the square of the step, whatever the strength. Backward Euler, of first order,
# takes energy out of the motion before the spring can, the more of it the less the spring yields. A dark stripe is
# where the error changes its sign: luck, not accuracy.

# %%
per_period = np.array([160, 120, 80, 60, 40, 30, 20, 16, 12, 10, 8, 6])  # steps
weakness = np.geomspace(1.0, 8.0, 40)  # the pulse's peak over the strength
over = 40.0 / weakness
ends = 6.0


def remaining(scheme: str, dt: float) -> np.ndarray:
    """The plastic part of the displacement at the end, for each strength."""
    shared = {"dt": dt, "t_end": ends, "hardening": 0.02, "strength": over, **given}
    return ss.sweep("hysteretic_oscillator", scheme, keep="final", **shared).memory.sel(remembered="p").to_numpy()


true = remaining("bathe", T / 4000)
print(f"what remains: {true.min():.2f} to {true.max():.2f} m")
figure, axes = plt.subplots(1, 3, figsize=(13, 3.8), sharey=True)
means = {}
for panel, name in zip(axes, ("average_acceleration", "bathe", "backward_euler"), strict=True):
    drift = np.array([np.abs(remaining(name, T / n) / true - 1) for n in per_period])
    means[name] = dict(zip(per_period.tolist(), np.sqrt(np.mean(drift**2, axis=1)).tolist(), strict=True))
    panel.pcolormesh(
        weakness,
        1 / per_period,
        np.log10(np.maximum(drift, 1e-6)),
        cmap="cividis",
        vmin=-5,
        vmax=-0.5,
        shading="nearest",
    )
    panel.set(xscale="log", yscale="log", title=name, xlabel="peak of the pulse over strength")
    panel.set_xticks([1, 2, 4, 8], ["1", "2", "4", "8"])
    panel.set_xticks([], minor=True)
axes[0].set_ylabel("step over period $h/T$")
figure.colorbar(axes[0].collections[0], ax=axes, label=r"$\log_{10} |p/p_\mathrm{fine} - 1|$")

# %% [markdown]
# In the mean over strengths, what remains is good to 1 % from 30 steps a period on with average acceleration, and
# from 16 on with Bathe's scheme, which makes two solves a step.

# %%
for name, mean in means.items():
    print(f"{name}: " + ", ".join(f"{n} steps a period {mean[n]:.1e}" for n in (10, 20, 40, 80)))
assert means["average_acceleration"][30] < 0.01 < means["average_acceleration"][20]
assert means["bathe"][16] < 0.01 < means["bathe"][12]
assert means["backward_euler"][160] > 0.01

# %% [markdown]
# ## An inelastic spectrum
#
# The strength that keeps the ductility at a wanted value, the displacement, and what of it remains, under a ground
# motion of three seconds. Each value carries the scheme's own error, from a march with half the step.

# %%
t = np.arange(0.0, 3.0, 0.02)
accelerations = 3.0 * np.sin(6.0 * t) * np.sin(t)  # m/s^2
spectrum = ss.inelastic_spectrum(
    accelerations, dt=0.02, periods=np.geomspace(0.1, 4.0, 40), ductility=[1, 2, 4], hardening=0.02
)
inelastic_figure(spectrum, plt.subplots(1, 3, figsize=(13, 3.8))[1])
weaker = (spectrum.A_y.sel(ductility=4) / spectrum.A_y.sel(ductility=1)).to_numpy()
print(f"ductility 4 takes {weaker.min():.2f} to {weaker.max():.2f} of the elastic strength")
assert np.all(weaker < 1)
assert np.abs(spectrum.ductility_demand / spectrum.ductility - 1).max() < 0.011
assert spectrum.residual_displacement.sel(ductility=1).max() < 1e-12
