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
# # Constraints: the stiff bar of the thesis becomes a rod
#
# The elastic pendulum's bar is made stiffer and stiffer until a constraint takes its place. What a scheme knows there
# of velocity and tension follows from its relations alone, before any march; then it is marched, and measured.

# %%
import matplotlib.pyplot as plt
import numpy as np
from substep_derive import derive, prescribed

import substep as ss

plt.style.use("substep.charts")  # the look of all charts of substep

# %% [markdown]
# ## Before any march
#
# A constraint prescribes the displacement in its normal direction. The errors of velocity and multiplier that a scheme
# makes there, and the factor by which it multiplies what a start has wrong, are exact. In closed form for Newmark's
# method and the composite of the thesis:

# %%
for name in ("newmark", "newmark_bdf2"):
    found = derive(name).prescribed
    print(f"{name}: multiplier {found.multiplier.coefficient} h^{found.multiplier.power}")

schemes = ("average_acceleration", "generalized_alpha", "bathe", "bdf2")
for name in schemes:
    print(f"{name}: {prescribed(name)}")
assert prescribed("bathe").multiplier.power == 1
assert prescribed("average_acceleration").grows

# %% [markdown]
# ## Measured
#
# A pendulum falls from the horizontal; the reference is its exact motion after 2 s. The multiplier of the equations of
# motion (solid) is as accurate as the motion for every scheme; the scheme's own (dashed) only where the derivation
# says so.

# %%
g = 9.81
rod = ss.scene("rod_pendulum", L=1.0, m=1.0, v0=0.0, g=g)
tension = 17.907682072960784  # at 2 s, by quadrature
steps = np.array([0.02, 0.01, 0.005, 0.0025])
figure, panel = plt.subplots(figsize=(6.4, 4.2))
for name in schemes:
    runs = [ss.march(rod, name, dt=dt, t_end=2.0) for dt in steps]
    errors = np.array([[abs(x["rod"][-1] - tension) for x in (r.multipliers, r.memory)] for r in runs])
    (line,) = panel.loglog(steps, errors[:, 0], "-o", label=name)
    panel.loglog(steps, errors[:, 1], "--", color=line.get_color())
    orders = np.log2(errors[-2] / errors[-1])
    print(f"{name}: order {orders[0]:.2f} from the motion, {orders[1]:.2f} of its own")
    assert abs(orders[0] - 2) < 0.2
    assert abs(orders[1] - min(2, prescribed(name).multiplier.power)) < 0.2
panel.set(
    xlabel="step $h$ (s)", ylabel="error of the tension (N)", title="Solid: from the motion. Dashed: the scheme's own"
)
panel.legend()

# %% [markdown]
# ## Elastic, stiff, rigid
#
# The bar without gravity, EA from 10⁵ to 10¹⁰ N, and the rod in its place, in the same steps, from the rod's
# acceleration. How far the bar is from the rod at the end falls like 1/EA. Newton's iteration takes as many
# corrections for the rod as for the bar, and there is no stiffness to choose: "model no more than a scene needs".

# %%
dt, t_end = 0.01, 1.0
rotating = ss.scene("rod_pendulum")
rigid = ss.march(rotating, "bathe", dt=dt, t_end=t_end)
stiffness = np.geomspace(1e5, 1e10, 11)
apart = []
for EA in stiffness:
    bar = ss.march(ss.scene("elastic_pendulum", EA=EA, a0=rotating.a0), "bathe", dt=dt, t_end=t_end)
    apart.append(np.hypot(*(bar.u[-1] - rigid.u[-1])))
figure, panel = plt.subplots(figsize=(6.4, 4.2))
panel.loglog(stiffness, apart, "-o")
panel.set(xlabel="axial stiffness $EA$ (N)", ylabel="distance of bar from rod at 1 s (m)")
print([f"{x:.1e}" for x in apart])
assert np.all(np.diff(apart) < 0)
assert apart[-1] < 1e-5 * apart[0]

# %% [markdown]
# ## The trapezoidal rule
#
# Its multipliers keep what a start has wrong for ever, with alternating sign, and a double root makes that grow: from
# a start in motion it gains energy at any step, although it is "unconditionally stable".

# %%
start = {"u": [0.905342850921633, -0.424681436237906], "v": [-1.22587000207992, -2.613329775781903]}
figure, panel = plt.subplots(figsize=(6.4, 4.2))
for name, dt in (("average_acceleration", 0.02), ("average_acceleration", 0.005), ("generalized_alpha", 0.02)):
    r = ss.march(rod, name, dt=dt, t_end=5.0, start=start)
    panel.semilogy(r.t, np.maximum(np.abs(r.energy) / g, 1e-8), label=f"{name}, $h$ = {dt} s")
    if name == "average_acceleration":
        assert np.abs(r.energy).max() > g
    else:
        assert np.abs(r.energy).max() < 0.05 * g
panel.set(xlabel="time $t$ (s)", ylabel="error of the energy over $m g L$")
panel.legend()
