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
# # The amplification matrix of Newmark-BDF2, entry by entry
#
# S. Kumar's thesis (IIT Guwahati, 2015) proposes Newmark over $\gamma_t h$ and three-point backward Euler
# over the rest, and prints one entry of the amplification matrix, $A_{31}$ in (4.16). Here all nine are
# derived from the relations (3.2)-(3.16), with damping, and (4.16) is laid beside ours.

# %%
import numpy as np
from matplotlib import style
from matplotlib.figure import Figure
from substep_derive import Omega, derive, xi
from substep_derive.algebra.rational import horner
from sympy import Eq, Matrix, Rational, Symbol, cancel, factor, simplify, symbols, zeros

import substep as ss
from substep.figures.charts import curves

style.use("substep.charts")  # the look of all charts of substep

beta, gamma, gamma_t = symbols("beta gamma gamma_t")
d = derive("newmark_bdf2")
d.state

# %% [markdown]
# Every entry is a numerator over one common denominator, in the state $(u, h v, h^2 a)$ and
# $\Omega = \omega h$:

# %%
Eq(Symbol("d"), horner(d.den, Omega))

# %%
Matrix(3, 3, lambda i, j: horner(d.N[i, j], Omega))

# %% [markdown]
# The denominator is the product of the two effective stiffnesses; the thesis's $\beta_1$ and $\beta_2$.

# %%
c2 = -1 / ((1 - gamma_t) * gamma_t)  # (3.15) with h = 1, omega = Omega
c3 = (2 - gamma_t) / (1 - gamma_t)  # (3.16)
beta_1 = 1 + 2 * xi * Omega * gamma * gamma_t + beta * Omega**2 * gamma_t**2
beta_2 = c3**2 + 2 * xi * Omega * c3 + Omega**2
constant = cancel(d.den / (beta_1 * beta_2))
assert not constant.has(Omega)
factor(constant)

# %% [markdown]
# ## $A_{31}$ beside the printed (4.16)
#
# In the thesis's order $(a, v, u)$ the entry in row 3, column 1 takes $a_n$ to $u_{n+1}$.

# %%
g = gamma_t
printed = -(
    c2
    * (
        2 * (1 - gamma) * g
        + 4 * gamma * xi * Omega * (1 - gamma) * g**2
        + 2 * beta * g**3 * Omega**2 * (1 - gamma)
        - 4 * xi * Omega * gamma * (1 - gamma) * g**2
        - Omega**2 * g**3 * gamma * (1 - 2 * beta)
    )
    + (c2 * c3 + 2 * xi * Omega * c2)
    * (
        g**2 * (1 - 2 * beta)
        + 2 * g**2 * (1 - 2 * beta) * xi * Omega * gamma * g
        + beta * g**4 * Omega**2 * (1 - 2 * beta)
        - 4 * xi * Omega * beta * (1 - gamma) * g**3
        - beta * (1 - 2 * beta) * g**4 * Omega**2
    )
) / (beta_1 * beta_2)
ratio = factor(cancel(printed / d.A_thesis[2, 0]))
ratio

# %% [markdown]
# The printed entry is a constant multiple of the derived one: every term is right, the factor in front is not.

# %%
assert ratio.is_Rational
assert ratio == 2

# %% [markdown]
# ## Bathe and Silva-Bezerra are members
#
# `bathe` is declared on its own, with the trapezoidal rule; that it is the composite at
# $\gamma_t = \tfrac{1}{2}$, $\beta = \tfrac{1}{4}$, $\gamma = \tfrac{1}{2}$ (thesis, p. 27) is a result.

# %%
half, quarter = Rational(1, 2), Rational(1, 4)
bathe = d.A.subs({gamma_t: half, beta: quarter, gamma: half})
assert (bathe - derive("bathe").A).applyfunc(cancel) == zeros(3, 3)
bathe.applyfunc(factor)

# %%
silva_bezerra = d.A.subs({beta: quarter, gamma: half})
assert (silva_bezerra - derive("silva_bezerra").A).applyfunc(cancel) == zeros(3, 3)
silva_bezerra[0, 0].factor()

# %% [markdown]
# ## At $\Omega \to \infty$

# %%
simplify(d.rho_inf)

# %%
assert d.rho_inf.subs({gamma_t: Rational(9, 10), beta: Rational(49, 100), gamma: Rational(9, 10)}) == Rational(40, 49)
assert derive("bathe").rho_inf == 0

# %% [markdown]
# The numerator $2\beta - \gamma$ vanishes for $\beta = \tfrac{1}{4}, \gamma = \tfrac{1}{2}$ alone among the sets of
# Table 4.1: only that one annihilates the stiffest modes.

# %%
ratios = np.logspace(-2, 3, 400)
sets = ((0.25, 0.5), (0.3025, 0.6), (0.36, 0.7), (0.4225, 0.8), (0.49, 0.9))
radius = {
    rf"$\beta$ = {b:g}, $\gamma$ = {c:g}": ss.scheme("newmark_bdf2", gamma_t=0.4, beta=b, gamma=c).spectral_radius(
        2 * np.pi * ratios
    )
    for b, c in sets
}
radius["Bathe"] = ss.scheme("bathe").spectral_radius(2 * np.pi * ratios)
assert all(rho.max() <= 1.0 for rho in radius.values())
figure = Figure(figsize=(7, 4.5))
axes = figure.subplots()
curves(axes, ratios, radius, x_label="time ratio $h/T$", y_label=r"spectral radius $\rho$")
axes.set_xscale("log")
axes.set_title(r"Newmark-BDF2, $\gamma_t$ = 0.4, $\xi$ = 0")
axes.legend(fontsize=8)
figure
