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
# # Where contact fails
#
# A body meets a stop somewhere inside a step. What a scheme makes of the impact depends on where: on its phase. So no
# single run says anything; here every figure is taken over phases. Two readings are compared. A scheme that keeps an
# acceleration for its next step may keep what the pressure gives, or leave it out, so that an impact acts in its own
# step alone; the second is the default of a declared contact.

# %%
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
from substep_derive import Contact, Scene, impact, optional, rate
from substep_derive.constrained.impact import phi
from sympy import Rational, Symbol, symbols

import substep as ss

plt.style.use("substep.charts")  # the look of all charts of substep
schemes = {"average_acceleration": {}, "generalized_alpha": {"rho_inf": 0.8}, "bathe": {}, "bdf2": {}}

# %% [markdown]
# ## A mass point, exactly
#
# A point without forces meets a floor with the velocity 1. The velocity that it leaves with is affine in the phase,
# piece by piece, and follows from the scheme's relations alone.

# %%
figure, panels = plt.subplots(1, 2, figsize=(9, 3.6), sharey=True)
for panel, remembered in zip(panels, (True, False), strict=True):
    for name, parameters in schemes.items():
        exact = {key: str(x) for key, x in parameters.items()}
        found = impact(name, remembered=remembered, **exact)
        ends = [(float(x), float(p.velocity.subs(phi, x))) for p in found.pieces for x in (p.low, p.high)]
        panel.plot(*zip(*ends, strict=True), label=name)
        print(f"{name}, {'remembered' if remembered else 'not remembered'}: {found}")
    panel.axhline(1.0, color="black", linewidth=0.6)
    panel.set(xlabel="phase of the impact (steps)", title="remembered" if remembered else "acts in its own step alone")
panels[0].set_ylabel("velocity that the impact leaves (m/s)")
figure.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
assert impact("average_acceleration", remembered=True).most == 3
assert impact("average_acceleration").gains == 0
assert impact("bathe").gains > 0

# %% [markdown]
# ## An elastic bar
#
# Doyen, Ern and Piperno (SIAM J. Sci. Comput. 33, 2011, 223-249): a bar of length 10, E = 900, density 1, flies with
# the velocity 10 against a wall. It is in contact for 2/3 s, with the pressure 300, and leaves as it came. Here it has
# twelve elements with lumped masses, and meets the wall at 32 phases.


# %%
def bar(n: int, remembered: bool) -> Scene:
    """The bar of n elements, at the distance d from the wall."""
    u, d, length, stiffness = symbols(f"u0:{n + 1}"), Symbol("d"), Rational(10, n), 900
    masses = [length / 2, *[length] * (n - 1), length / 2]
    return Scene(
        f"bar_{n}_{'remembered' if remembered else 'alone'}",
        coordinates=dict.fromkeys(u, "m"),
        kinetic=sum(m * rate(x) ** 2 for m, x in zip(masses, u, strict=True)) / 2,
        potential=sum(stiffness / length * (b - a) ** 2 for a, b in pairwise(u)) / 2,
        contacts={"wall": Contact(d + u[0], remembered=remembered)},
        parameters=(optional(d, 5),),
        start={**dict.fromkeys(u, 0), **{rate(x): -10 for x in u}},
        length=1,
    )


elements, courant = 12, (0.5, 0.9, 2.0)
gains = {}
for name, parameters in schemes.items():
    for remembered in (True, False):
        scene, scheme = bar(elements, remembered), ss.scheme(name, **parameters)
        for number in courant:
            h = number * 10 / elements / 30
            phases = 5 + 10 * h * np.arange(32) / 32
            n = int(np.ceil(1.6 / h))
            ds = ss.sweep(scene, scheme, dt=h, t_end=n * h, keep="final", d=phases, progress=False)
            assert not ds.status.values.any()
            gains[name, remembered, number] = float(ds.energy.max()) / 500 - 1
for (name, remembered, number), gain in gains.items():
    print(f"{name}, {'remembered' if remembered else 'alone'}, Courant number {number}: {100 * gain:+.1f} %")

# %%
figure, panel = plt.subplots(figsize=(7, 3.6))
places = np.arange(len(schemes))
for k, number in enumerate(courant):
    worst = [100 * max(gains[name, True, number], 0.0) for name in schemes]
    panel.bar(places + 0.27 * (k - 1), worst, 0.25, label=f"Courant number {number:g}")
panel.set(yscale="symlog", ylabel="worst gain of energy (%)", xticks=places, xticklabels=list(schemes))
panel.set_title("an elastic bar meets a wall; pressures remembered")
panel.legend()
assert min(gains["average_acceleration", True, number] for number in courant) > 1.0
assert gains["bathe", True, 0.5] > 0.1
assert max(gain for (_, remembered, _), gain in gains.items() if not remembered) < 1e-9

# %% [markdown]
# Where the impact acts in its own step alone, no scheme gained anything at any phase. So a contact has that reading
# unless it is declared otherwise, and `average_acceleration` is proved with it not to gain on the mass point.

# %% [markdown]
# ## The pressure
#
# The mean pressure of each step, against the exact 300 from 0.5 to 1.1667 s. The trapezoidal rule rings about it as
# long as the contact lasts; Bathe's scheme does so for some steps behind the front only.

# %%
h = 0.5 * 10 / elements / 30
figure, panel = plt.subplots(figsize=(7, 3.6))
for name in ("average_acceleration", "bathe"):
    r = ss.march(ss.scene(bar(elements, False)), name, dt=h, t_end=100 * h)
    panel.plot(r.t, r.memory["wall"], label=name)
    impulse = h * r.memory["wall"].sum()
    print(f"{name}: impulse {impulse:.2f} of 200")
    assert abs(impulse / 200 - 1) < 0.05
panel.plot([0.5, 0.5, 7 / 6, 7 / 6], [0, 300, 300, 0], color="black", linewidth=0.8, label="exact")
panel.set(xlabel="time $t$ (s)", ylabel="pressure (N)")
panel.legend()

# %% [markdown]
# ## Friction
#
# A block on a spring rides on a belt until the spring pulls it off, and then swings about where the friction holds it.
# The force of the friction is against sliding: negative, it pulls the block along with the belt.

# %%
r = ss.march(ss.scene("friction_oscillator", limit=0.3, belt=0.2, u0=0.0, v0=0.2), "bathe", dt=0.01, t_end=10.0)
exact = np.where(r.t < 1.5, 0.2 * r.t, 0.3 + 0.2 * np.sin(r.t - 1.5))
figure, panel = plt.subplots(figsize=(7, 3.2))
panel.plot(r.t, r.u[:, 0], label="block")
panel.plot(r.t, r.memory["pad"], label="friction")
panel.set(xlabel="time $t$ (s)", ylabel="position (m), friction (N)")
panel.legend()
assert np.abs(r.u[:, 0] - exact).max() < 2e-3
