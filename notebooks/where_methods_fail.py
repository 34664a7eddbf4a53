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
# # Where methods fail
#
# A scheme that is stable for every step on a linear oscillator may still gain energy, blow up, or make Newton's
# iteration fail. A run has one of four outcomes: *survived* ($E \le 1.01 E_0$), *gains energy* ($E \le 10^3 E_0$),
# *blew up*, *Newton failed*.

# %%
import matplotlib.pyplot as plt
import numpy as np

import substep as ss
from substep.derived import facade
from substep.studies.failures import WORDS
from substep.studies.failures.contact import restitution
from substep.studies.failures.linear import alternating_radius
from substep.studies.failures.maps import first_rise, lattice
from substep.studies.failures.outcomes import run
from substep.studies.failures.table import stiff
from substep.studies.turning import bar_of, first_growth

plt.style.use("substep.charts")  # the look of all charts of substep

# %% [markdown]
# ## The stiff pendulum
#
# The trapezoidal rule is unconditionally stable on the linear oscillator. On the stiff pendulum it gains energy at a
# time that depends on the given initial acceleration; with the published one, first beyond 1.1 $E_0$ at 3.5 s.

# %%
for a0 in (-19.6, -(7.72**2) / 3.0443):
    times = first_rise(stiff(a0), np.array([0.1, 0.05, 0.02, 0.009]))
    print(f"a0 = {a0:.4f} m/s^2: E > 1.1 E0 first at", ", ".join(f"{t:.3f} s" for t in times))
assert np.isclose(first_rise(stiff(), np.array([0.1]))[0], 3.5)  # an independent 40-digit computation

# %% [markdown]
# Why, and from which step on, is derived: the bar turns by $\tau = h v_0/L$ in a step, which feeds errors along it once
# $h^2 \omega v_0/L > 4$, and schemes that dissipate once $\tau$ is large for their $\rho_\infty$.

# %%
bar, steps = bar_of(stiff()), np.geomspace(1e-3, 0.25, 1000)
first = {name: first_growth(ss.scheme(name), bar, steps) for name in ("average_acceleration", "hht_alpha", "bathe")}
print({name: round(h, 4) for name, h in first.items()}, "s")
assert np.isclose(first["average_acceleration"], 0.00933, rtol=0.01)
assert np.isnan(first_rise(stiff(), np.array([0.99 * first["average_acceleration"]]))[0])
assert first["bathe"] == np.inf

# %% [markdown]
# ## A map over step and sub-step
#
# Newmark-BDF2 with $\beta = 1/4$, $\gamma = 1/2$, 10 s or 500 steps. In the rigid limit of the bar the energy change a
# step is known in closed form; it changes sign at a $\gamma_t$ that the derivation gives and the runs show.

# %%
(split,) = facade.rigid_energy("newmark_bdf2", beta="1/4", gamma="1/2").sign_changes
h, gamma_t = np.geomspace(0.01, 1.0, 40), np.linspace(0.02, 0.98, 41)
grid = [x.ravel() for x in np.meshgrid(h, gamma_t)]
outcome, end = lattice(stiff(), lambda g: ss.scheme("newmark_bdf2", gamma_t=g), *grid)
change = np.where(outcome.word < 2, end - 1, np.nan).reshape(len(gamma_t), len(h))
figure, axes = plt.subplots(figsize=(6, 4))
signs = axes.pcolormesh(h, gamma_t, np.sign(change), cmap="PuOr_r", vmin=-1.5, vmax=1.5)
axes.axhline(split, color="black", linestyle="--", label=rf"derived: $\gamma_t$ = {split:.4f}")
axes.set(xscale="log", xlabel="step $h$ (s)", ylabel=r"$\gamma_t$", title="energy lost (purple) or gained (orange)")
axes.legend(loc="upper left", frameon=True)

column = change[:, np.argmin(abs(h - 0.05))]
resolved = np.isfinite(column) & (gamma_t > 0.1) & (gamma_t < 0.9)
assert (column[resolved & (gamma_t < split - 0.02)] > 0).all()
assert (column[resolved & (gamma_t > split + 0.02)] < 0).all()

# %% [markdown]
# ## Stiffening, softening
#
# At a quarter of the period a conditionally stable scheme blows up on the hardening spring; on the softening one an
# "unconditionally stable" scheme gains energy. The energy-momentum method survives both.

# %%
for scene, period in ((ss.scene("duffing"), 0.1515328344472604), (ss.scene("softening"), 1.14187632340189)):
    outcomes = {}
    for name in ("central_difference", "average_acceleration", "newmark_bdf2", "energy_momentum"):
        _, found = run(scene, ss.scheme(name), np.array([period / 4]), np.array([400]))
        outcomes[name] = WORDS[found.word[0]]
    print(scene.name, outcomes)
    assert outcomes["energy_momentum"] == "survived"
    assert outcomes["average_acceleration"] == "gains energy"
    assert scene.name != "duffing" or outcomes["central_difference"] == "blew up"

# %% [markdown]
# ## Contact
#
# A mass hits a penalty spring and should leave as fast as it came. Its computed speed depends on where in a step
# contact begins, and on $\omega_c h$.

# %%
phases = np.arange(50) / 50
for name in ("average_acceleration", "newmark_bdf2", "energy_momentum"):
    ratio, _ = restitution(name, np.array([1.0, 10.0]), phases)
    with np.errstate(all="ignore"):
        print(f"{name:21}", *(f"{np.nanmin(r):.3f} .. {np.nanmax(r):.3f}" for r in ratio))
ratio, _ = restitution("energy_momentum", np.array([1.0]), phases)
assert np.allclose(ratio[np.isfinite(ratio)], 1, atol=1e-9)

# %% [markdown]
# ## Steps that alternate
#
# A multi-step scheme carries earlier steps; if the step changes from $h$ to $\kappa h$ and back, it is the product of
# two amplification matrices that must not grow. One-step schemes are not affected.

# %%
Omega = 2 * np.pi * np.logspace(-2, 3, 201)
for name in ("bathe", "houbolt", "park"):
    largest = [float(alternating_radius(ss.scheme(name), Omega, ratio).max()) for ratio in (1.0, 1.25, 2.0)]
    print(f"{name:8}", [f"{r:.4f}" for r in largest])
assert alternating_radius(ss.scheme("bathe"), Omega, 2.0).max() < 1 + 1e-6
