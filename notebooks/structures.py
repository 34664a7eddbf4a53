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
# # Structures: schemes on finite element models
#
# `ss.structure(M, K, ...)` takes the matrices of any program; every scheme of the catalogue marches them. The models
# here come from `substep.structures.examples`, two of which are assembled by scikit-fem (extra `fem`).

# %%
import matplotlib.pyplot as plt
import numpy as np

import substep as ss
from substep.figures.structure_modes import kinds_of_modes, modes_figure
from substep.structures.examples import bar, frame, plate, solid

plt.style.use("substep.charts")  # the look of all charts of substep

# %% [markdown]
# ## A frame on a base that moves
#
# Five stories and three bays under a decaying shake of the ground. Displacements are relative to the base; what the
# roof feels is the absolute acceleration. The account says where the energy went: with the average acceleration scheme
# nothing is left over, since it dissipates none.

# %%
dt, t = 0.01, np.arange(0.0, 8.0, 0.01)
shake = ss.Record(dt, 3.0 * np.exp(-0.5 * t) * np.sin(2 * np.pi * 1.6 * t))
building = frame(5, 3, C=ss.rayleigh(0.03, 0.03, at=(10.0, 60.0)))
sideways = [name for name in building.names if name.startswith("ux")]
quake = building.ground_motion(shake, sideways)
r = ss.march(quake, "average_acceleration", dt=dt, t_end=8.0, dofs=["ux at 0 15", "ux at 0 3"])
roof = r.at("ux at 0 15")[0]
assert r.account is not None
print(f"roof: {1e3 * np.abs(roof).max():.1f} mm relative to the base, {np.abs(r.absolute_a[:, 0]).max():.2f} m/s^2")
print(f"energy: {r.account.work[-1]:.0f} J put in, {r.account.damped[-1]:.0f} J damped away, "
      f"{r.account.share:.1e} of it by the scheme")  # fmt: skip
assert np.abs(r.account.numerical).max() < 1e-9 * r.account.work.max()
assert np.abs(roof).max() > 2 * np.abs(r.u[:, 1]).max()

figure, axes = plt.subplots(2, 1, figsize=(8, 5), sharex=True)
axes[0].plot(r.t, 1e3 * r.u, linewidth=0.9, label=["roof", "first floor"])
axes[0].set(ylabel="relative displacement (mm)", title="Five stories on a moving base")
axes[0].legend()
for name in ("work", "damped", "strain", "kinetic"):
    axes[1].plot(r.t, getattr(r.account, name), linewidth=0.9, label=name)
axes[1].set(xlabel="$t$ (s)", ylabel="energy (J)")
axes[1].legend()

# %% [markdown]
# ## A few modes in place of the frame
#
# A march of `modes` takes each mode as an oscillator. Two of 375 carry 93 % of the mass that the base moves, and give
# the roof to a thousandth; the account is that of their energies. Design codes go without the history:
# `ss.spectrum_beside_history` puts the peaks by SRSS and CQC beside it.

# %%
modes = quake.modes(20)
share = modes.participation(sideways).share
two = ss.march(modes.first(2), "average_acceleration", dt=dt, t_end=8.0, dofs=["ux at 0 15"])
off = np.abs(two.u[:, 0] - roof).max() / np.abs(roof).max()
print(f"two modes: {share[:2].sum():.1%} of the mass, roof off by {off:.1e}")
assert share[:2].sum() > 0.9
assert off < 2e-3
assert two.account is not None
assert abs(two.account.share) < 1e-12

peaks = ss.spectrum_beside_history(modes, shake, sideways, dofs=["ux at 0 15"])
for way in peaks.way.values:
    at = peaks.sel(way=way)
    print(f"{way:8} roof {1e3 * at.u.item():.1f} mm ({at.u_difference.item():+.2%}), "
          f"base {1e-3 * at.shear.item():.0f} kN ({at.shear_difference.item():+.2%})")  # fmt: skip
assert np.abs(peaks.u_difference).max() < 0.02

# %% [markdown]
# ## What to choose
#
# From the modes alone the error of every scheme, step and number of modes is known before anything is marched; the
# choice is the one of the least work. Here it is held against direct steps four times as short.

# %%
choice = ss.choose(modes, 1e-2, t_end=8.0, quantity="ux at 0 15", among=["average_acceleration", "bathe"])
print(choice.text)
assert choice.best is not None
taken = choice.march()
fine = ss.march(quake, "bathe", dt=choice.best.dt / 4, t_end=8.0, dofs=["ux at 0 15"], stride=4)
found = np.abs(taken.u - fine.u).max() / np.abs(fine.u).max()
print(f"found: {found:.2e}; predicted: {choice.best.error:.2e}")
assert found < 1e-2
assert abs(found / choice.best.error - 1) < 0.2

# %% [markdown]
# ## The spectrum of the structure on that of the scheme
#
# Every mode is a mark on the scheme's curves, as large as its share of the moving mass. Two modes that carry nearly all
# of it are resolved. Of those that no step of 0.01 s can follow, Bathe's scheme leaves nothing after some steps; the
# trapezoidal rule keeps eight of them, and wrong.

# %%
sixty = building.modes(60)
kinds = {name: kinds_of_modes(sixty, ss.scheme(name), dt) for name in ("average_acceleration", "bathe")}
for name, found_kinds in kinds.items():
    print(name, {kind: found_kinds.count(kind) for kind in sorted(set(found_kinds))})
assert kinds["bathe"][:2] == kinds["average_acceleration"][:2] == ["resolved", "resolved"]
assert "spurious" in kinds["average_acceleration"]
assert "spurious" not in kinds["bathe"]
modes_figure(sixty, "bathe", dt, direction=sideways)

# %% [markdown]
# ## What rings, and for how long
#
# A stiff spring on a soft one: the stiff part vibrates a hundred thousand times within a step. No scheme can follow
# that; the question is what it makes of it. The trapezoidal rule keeps it for ever. A dissipative scheme multiplies it
# by $\rho_\infty$ a step, so that it falls below 1 % after $\ln 0.01/\ln\rho_\infty$ steps.

# %%
k_stiff, k_soft, dt = 1e12, 1.0, 0.2618
K = np.array([[k_stiff + k_soft, -k_soft], [-k_soft, k_soft]])
mode = np.linalg.eigh(K)[1][:, 1]
stiff = ss.structure(np.eye(2), K, u0=mode)


def ringing(scheme: ss.Scheme, steps: int = 60) -> np.ndarray:
    return np.abs(ss.march(stiff, scheme, dt=dt, t_end=steps * dt, account=False).u @ mode)


figure, axes = plt.subplots(figsize=(8, 3.6))
axes.semilogy(np.maximum(ringing(ss.scheme("average_acceleration")), 1e-6), label="trapezoidal rule")
for rho in (0.9, 0.8, 0.5):
    ring = ringing(ss.scheme("rho_inf_bathe", rho_inf=rho))
    found, predicted = int(np.flatnonzero(ring >= 0.01)[-1]) + 1, np.log(0.01) / np.log(rho)
    print(f"rho_inf = {rho}: below 1 % after {found} steps; predicted {predicted:.1f}")
    assert found == np.ceil(predicted)
    axes.semilogy(np.maximum(ring, 1e-6), label=rf"$\rho_\infty$-Bathe, {rho}")
alpha = ringing(ss.scheme("generalized_alpha", rho_inf=0.8))
late = int(np.flatnonzero(alpha >= 0.01)[-1]) + 1
print(f"generalized-alpha with the same rho_inf = 0.8: {late} steps")
assert late > 1.5 * np.log(0.01) / np.log(0.8)
axes.semilogy(np.maximum(alpha, 1e-6), "--", label=r"generalized-$\alpha$, 0.8")
axes.axhline(0.01, color="gray", linewidth=0.5)
axes.set(xlabel="step", ylabel="amplitude of the stiff mode", title="Two eigenvalues share 0.8: n 0.8^n, not 0.8^n")
axes.legend()

# %% [markdown]
# ## A plate, and a published number
#
# NAFEMS' benchmark 13T gives 3.523 mm and, static, 1.817 mm for the centre of a plate under a sudden pressure. The
# scheme and the elements agree with Navier's series to four digits: and that says 3.460 and 1.774. What is published is
# the first term of the series alone.

# %%
side, D, mass = 10.0, 200e9 * 0.05**3 / 12 / (1 - 0.3**2), 8000.0 * 0.05
damped = ss.Rayleigh(0.299, 1.339e-3)
model = plate(8, load=ss.Step(100.0), C=damped)
r = ss.march(model, "bathe", dt=0.002, t_end=0.3, dofs=["w at 5 5"], account=False)


def navier(terms: int) -> tuple[np.ndarray, float]:
    moving, static = np.zeros_like(r.t), 0.0
    for m in range(1, 2 * terms, 2):
        for n in range(1, 2 * terms, 2):
            stiffness = D * (np.pi / side) ** 4 * (m * m + n * n) ** 2
            part = (-1) ** ((m + n) // 2 - 1) * 1600.0 / (np.pi**2 * m * n) / stiffness
            omega = np.sqrt(stiffness / mass)
            root = np.emath.sqrt(damped.ratio(omega) ** 2 - 1) * omega
            first, second = -damped.ratio(omega) * omega + root, -damped.ratio(omega) * omega - root
            decay = (first * np.exp(second * r.t) - second * np.exp(first * r.t)) / (first - second)
            moving += part * (1 - decay.real)
            static += part
    return moving, static


whole, static = navier(12)
first, first_static = navier(1)
print(f"substep {1e3 * r.u.max():.3f} mm; series {1e3 * whole.max():.3f} and {1e3 * static:.3f}; "
      f"its first term {1e3 * first.max():.3f} and {1e3 * first_static:.3f}")  # fmt: skip
assert abs(r.u.max() / whole.max() - 1) < 2e-4
assert abs(first.max() - 3.523e-3) < 1.1e-6
assert abs(first_static - 1.817e-3) < 1e-6

# %% [markdown]
# ## A wave in a bar
#
# A hat of displacement splits into two that run apart. On lumped masses the central difference scheme at its critical
# step moves them by exactly one element a step. Bathe's scheme at the same step on the same elements rounds the kinks,
# and leaves little behind them; the trapezoidal rule leaves a tail.

# %%
elements, t_end = 200, 0.35


def hat(x: np.ndarray) -> np.ndarray:
    return np.maximum(0.0, 1.0 - np.abs(x - 0.5) / 0.05)


x = np.linspace(0.0, 1.0, elements + 1)
exact = 0.5 * (hat(x - t_end) + hat(x + t_end))
rod = bar(elements, lumped=True, fixed_ends=(True, True), start=hat)
figure, axes = plt.subplots(figsize=(8, 3.6))
errors = {}
for name in ("central_difference", "average_acceleration", "bathe"):
    u = ss.march(rod, name, dt=1 / elements, t_end=t_end, account=False).u[-1]
    errors[name] = np.abs(u - exact).max()
    axes.plot(x, u, linewidth=0.9, label=f"{name}: {errors[name]:.1e}")
axes.plot(x, exact, "k:", linewidth=0.9, label="d'Alembert")
axes.set(xlabel="$x$", ylabel="$u$", title=f"After t = {t_end} at h = dx/c")
axes.legend()
assert errors["central_difference"] < 1e-12
assert errors["bathe"] < errors["average_acceleration"]

# %% [markdown]
# ## A solid
#
# Two thousand degrees of freedom here, a hundred thousand with the same line and more patience. Two sub-steps of one
# length ratio share their factorization: `solver=` shows it, since it may be a function of one's own.

# %%
from substep.structures.solvers.factorization import superlu

counted = []


def counting(matrix):  # type: ignore[no-untyped-def]
    counted.append(matrix.shape)
    return superlu(matrix)


block = solid((8, 8, 8), load=ss.HalfSine(1e6, 5e-4), C=ss.Rayleigh(0.0, 1e-6), solver=counting)
r = ss.march(block, "rho_inf_bathe", dt=2e-5, t_end=1e-3, dofs=["uz at 1 1 1"])
print(f"{block}: corner {1e6 * np.abs(r.u).max():.1f} micrometres; factorizations: {len(counted)}")
assert r.status == "completed"
assert len(counted) == 2  # the mass matrix for the start, and one for both sub-steps
