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
# # The double pendulum, in two angles or with two rods
#
# The same motion twice: two angles, whose mass matrix depends on where the pendulum is, and two points in the plane
# with the rods as constraints. Both start horizontal and at rest, with unit masses and lengths. Which form is cheaper
# for the same error?

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.integrate import solve_ivp

import substep as ss

plt.style.use("substep.charts")  # the look of all charts of substep

# %% [markdown]
# ## The motion in two angles
#
# The reference integrates Lagrange's equations as they stand in textbooks, independent of substep.

# %%
g, t_end = 9.81, 2.0


def slope(t: float, y: np.ndarray) -> np.ndarray:
    a, b, p, q = y
    c, s = np.cos(a - b), np.sin(a - b)
    mass = [[2.0, c], [c, 1.0]]
    force = [-s * q**2 - 2.0 * g * np.sin(a), s * p**2 - g * np.sin(b)]
    return np.array([p, q, *np.linalg.solve(mass, force)])


start = [np.pi / 2, np.pi / 2, 0.0, 0.0]
exact = solve_ivp(slope, (0.0, t_end), start, "DOP853", rtol=3e-14, atol=3e-14, dense_output=True)
angles, rates = exact.y[:2, -1], exact.y[2:, -1]
assert np.allclose(angles, [-0.48297153, -1.32404871], rtol=0.0, atol=1e-8)
assert np.allclose(rates, [3.06528819, 2.94927155], rtol=0.0, atol=1e-8)

# %% [markdown]
# ## Both forms
#
# Of each run the places of both points at the end are compared. The forms differ by the error of the scheme, and so by
# an amount that falls with the square of the step.


# %%
def places(theta: np.ndarray) -> np.ndarray:
    """x1, y1, x2, y2 (..., 4) of two angles (..., 2)."""
    x, y = np.sin(theta), -np.cos(theta)
    first = np.stack([x[..., 0], y[..., 0]], axis=-1)
    return np.concatenate([first, first + np.stack([x[..., 1], y[..., 1]], axis=-1)], axis=-1)


FORMS = {"angles": "double_pendulum", "rods": "rod_double_pendulum"}
SCHEMES = {"generalized_alpha": {"rho_inf": 0.8}, "bathe": {}, "bdf2": {}}
steps = np.array([200, 400, 800, 1600])


def ended(form: str, scheme: ss.Scheme, n: int) -> tuple[np.ndarray, int]:
    """The places at the end, and how many corrections Newton's iterations have made until then."""
    r = ss.march(FORMS[form], scheme, dt=t_end / n, t_end=t_end)
    assert r.status == "completed"
    return places(r.u[-1]) if form == "angles" else r.u[-1], int(r.newton_iterations.sum())


found = {
    (name, form): [ended(form, ss.scheme(name, **given), n) for n in steps]
    for name, given in SCHEMES.items()
    for form in FORMS
}
found["esdirk43", "angles"] = [ended("angles", ss.scheme("esdirk43"), n) for n in steps]
for name in SCHEMES:
    apart = [np.abs(a - b).max() for (a, _), (b, _) in zip(found[name, "angles"], found[name, "rods"], strict=True)]
    print(f"{name}: forms apart by {apart[0]:.1e} m, then {apart[-1]:.1e} m")
    assert abs(np.log2(apart[-2] / apart[-1]) - 2.0) < 0.2

# %% [markdown]
# ## Error and work
#
# Solid lines are the angles, dashed ones the rods; work is counted in corrections of Newton's iteration, of which one
# solves for two angles, or for four coordinates and two multipliers. At the same step the angles are three times as
# accurate with each of these schemes: in them the points stay on their circles by themselves, and the scheme has only
# to follow the speed along them. Where the motion is smooth, a higher order gains far more than a choice of the form.

# %%
errors = {key: np.array([np.abs(at - places(angles)).max() for at, _ in runs]) for key, runs in found.items()}
work = {key: np.array([made for _, made in runs]) for key, runs in found.items()}
figure, panel = plt.subplots(figsize=(6.4, 4.2))
colors = {}
for (name, form), error in errors.items():
    style = {"color": colors.get(name), "linestyle": "-" if form == "angles" else "--", "marker": "o"}
    (line,) = panel.loglog(work[name, form], error, label=f"{name}, {form}", **style)
    colors[name] = line.get_color()
    order = np.log2(error[-2] / error[-1])
    print(f"{name}, {form}: error {error[-1]:.1e} m, order {order:.2f}, {work[name, form][-1]} corrections")
    assert abs(order - (2.0 if name in SCHEMES else 4.0)) < 0.2
panel.set(xlabel="corrections of Newton's iteration", ylabel="error of the places after 2 s (m)")
panel.legend()
for name in SCHEMES:
    assert 2.0 < errors[name, "rods"][-1] / errors[name, "angles"][-1] < 4.0

# %% [markdown]
# ## Energy, and the rods' lengths
#
# Over 20 s the motion is chaotic, and no step follows it; what remains are the invariants. The rods keep their length
# to rounding at every step. The energy, which the schemes do not keep exactly, stays near its value in either form.

# %%
panel = plt.subplots(figsize=(6.4, 4.2))[1]
for name in ("generalized_alpha", "bathe"):
    for form, line in zip(FORMS, ("-", "--"), strict=True):
        r = ss.march(FORMS[form], ss.scheme(name, **SCHEMES[name]), dt=0.005, t_end=20.0)
        drift = (r.energy - r.energy[0]) / (2.0 * g)
        panel.plot(r.t, drift, line, color=colors[name], label=f"{name}, {form}")
        print(f"{name}, {form}: energy changes by {drift[-1]:.1e} of 2 m g L")
        assert np.abs(drift).max() < 0.01
        if form == "rods":
            lengths = np.hypot(*r.u[:, :2].T), np.hypot(*(r.u[:, 2:] - r.u[:, :2]).T)
            assert np.abs(np.array(lengths) - 1.0).max() < 1e-11
panel.set(xlabel="time $t$ (s)", ylabel="change of the energy over $2 m g L$")
panel.legend()
