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
# # A proof of stability, step by step
#
# A plot of the spectral radius shows that a scheme is stable where it was drawn. A certificate shows it for every
# $\Omega = \omega h > 0$: by exact algebra, in steps that can be checked by hand. Two examples: Newmark-BDF2 with a
# parameter set of the thesis's Table 4.1, stable, and Fox-Goodwin's scheme, not.

# %%
import numpy as np
from substep_derive import Algebraic, certify, xi
from substep_derive.stability.all_damping import certify_all_damping
from substep_derive.stability.critical_curve import critical_curve
from sympy import sqrt

import substep as ss

stable = certify("newmark_bdf2", gamma_t="1/5", beta="121/400", gamma="3/5")
print(stable.text)

# %% [markdown]
# In words: the characteristic polynomial has two eigenvalues that are not zero. The bilinear map takes the unit disk to
# the left half plane, so that "all eigenvalues inside" becomes "all roots s have a negative real part"; for that
# Lienard and Chipart's conditions are necessary and sufficient. Each is a polynomial in $\Omega$; where it has no
# positive root it keeps one sign, and one sample decides for the whole cell.

# %%
assert stable.stable
assert stable.critical_Omega is None

# %% [markdown]
# ## One that is not
#
# Undamped, Fox-Goodwin's eigenvalues lie *on* the circle for small $\Omega$: that is allowed while they are simple. At
# $\Omega = \sqrt 6$ they meet at $-1$, and beyond one of them is outside.

# %%
conditional = certify("fox_goodwin")
print(conditional.text)

# %%
assert conditional.critical_Omega == sqrt(6)
assert conditional.intervals[0][3] is False  # the end itself is not stable: a double eigenvalue on the circle
assert [low for low, *_ in conditional.multiple] == [sqrt(6)]

# %% [markdown]
# The double eigenvalue is a true instability, though no eigenvalue is outside the circle: the run grows linearly.

# %%
scene = ss.scene("linear_oscillator", omega=1.0, u0=0.0, v0=1.0)
on_the_edge = ss.march(scene, ss.scheme("fox_goodwin"), dt=float(np.sqrt(6)), t_end=float(np.sqrt(6)) * 1000)
inside = ss.march(scene, ss.scheme("fox_goodwin"), dt=2.4, t_end=2.4 * 1000)
growth = np.abs(on_the_edge.u[:, 0])
growth[[10, 100, 1000]] / growth[10], np.abs(inside.u).max()

# %%
assert growth[1000] / growth[10] > 90
assert np.abs(inside.u).max() < 20

# %% [markdown]
# ## With damping
#
# With the damping taken implicitly the limit of the central difference stays at 2 whatever the damping; with lagged
# damping it falls.

# %%
critical_curve("central_difference").explicit, critical_curve("central_difference_lagged").explicit

# %%
assert critical_curve("central_difference").explicit == 2
assert critical_curve("central_difference_lagged").explicit.subs(xi, 1).equals(2 * sqrt(2) - 2)
assert certify_all_damping("bathe").stable_for_all_xi

# %% [markdown]
# ## Parameters that are not rational
#
# Wilson's threshold is $\theta = (1 + \sqrt 3)/2$, the root of $2\theta^2 - 2\theta - 1$. At that number itself every
# sign is decided modulo the polynomial; nothing is rounded.

# %%
threshold = Algebraic((2, -2, -1), ("1", "2"))
at_it, below = certify("wilson_theta", theta=threshold), certify("wilson_theta", theta="1366/1000")
at_it.stable, below.stable, below.intervals

# %%
assert at_it.stable
assert not below.stable
