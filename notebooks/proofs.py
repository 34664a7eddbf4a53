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
# # Proofs beyond the oscillator
#
# A certificate speaks of one oscillator. Here a scheme's own energy is derived, and stability is proved on every linear
# structure $M > 0$, $C \ge 0$, $K \ge 0$ of any size, whose damping need not decouple.

# %%
import matplotlib.pyplot as plt
import numpy as np
from scipy.optimize import linprog
from substep_derive import Omega, certify, derive, xi
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.stability.structure_form import Rows
from substep_derive.stability.structure_multiplier import Multiplier, pencil
from sympy import factor, simplify

import substep as ss

# %% [markdown]
# ## A scheme's own energy
#
# **Proposition.** Let $x_1 = A x_0$ be a free step in $x = (u, hv)$. Then $E = x^T P x$ with
# $P = \begin{pmatrix} -A_{21} & (A_{11} - A_{22})/2 \\ \cdot & A_{12} \end{pmatrix}$ has $E_1 = \det A \; E_0$ exactly.
#
# *Proof.* With $J = \begin{pmatrix} 0 & 1 \\ -1 & 0 \end{pmatrix}$ it is $P = -J (A - \tfrac12 \operatorname{tr} A)$;
# $A$ commutes with the second factor, and $A^T J A = \det A \; J$. $\square$ $P$ is definite exactly where the
# eigenvalues are complex.
#
# The trapezoidal rule and the central difference have the energies that one expects; so has every scheme that is a
# rational function of the operator of the first order, whatever it dissipates.

# %%
own = {name: derive(name).energy.undamped for name in ("average_acceleration", "bathe", "central_difference")}
own

# %%
assert own["average_acceleration"][0] == own["bathe"][0]
assert own["central_difference"][0][0, 0].equals(Omega**2 * (1 - Omega**2 / 4))
assert own["central_difference"][1] == 1

# %% [markdown]
# Newmark's scheme with $\gamma > \frac{1}{2}$: along a motion the plain energy $\Omega^2 u^2 + (hv)^2$ waves about, the
# scheme's own falls by one and the same factor in every step.

# %%
energy = derive("newmark", beta="0.3025", gamma="3/5").energy
A, P = (np.array(m.subs({Omega: 1, xi: 0}).tolist(), float) for m in (energy.A, energy.P))
ratio = float(energy.ratio.subs({Omega: 1, xi: 0}))
x = [np.array([1.0, 0.0])]
for _ in range(40):
    x.append(A @ x[-1])
own_energy = np.array([v @ P @ v for v in x])
plain = np.array([v @ v for v in x])
figure, axes = plt.subplots(figsize=(6, 3))
axes.semilogy(plain, "o-", label=r"$\Omega^2 u^2 + (hv)^2$")
axes.semilogy(own_energy, "s-", label="the scheme's own")
axes.set(xlabel="step", ylabel="energy, Ω = 1")
axes.legend()

# %%
assert np.allclose(own_energy[1:] / own_energy[:-1], ratio, rtol=1e-12)
assert np.ptp(plain[1:] / plain[:-1]) > 0.01

# %% [markdown]
# ## Every structure: two forms
#
# **Theorem A.** If the step is one balance, $(a(\lambda) M + h b(\lambda) C + h^2 c(\lambda) K) \varphi = 0$, and
# stable on every oscillator, it is stable on every structure. *Proof.* With an eigenvector $\varphi$, $m = \varphi^* M
# \varphi$, $c$ and $k$ are one oscillator. $\square$
#
# **Theorem B.** If the step is $y_1 = R(hL) y_0$ with $|R| \le 1$ in the left half plane, its energy never grows.
# *Proof.* $L$ is dissipative in the energy norm; von Neumann. $\square$
#
# Which schemes have these forms is derived, and the rest is the algebra of the certificates.

# %%
for name in ("generalized_alpha", "bathe", "central_difference_lagged", "rk2"):
    print(certify(name, structures=True).text, "\n")

# %%
assert certify("kr_alpha", structures=True).verdict == "proved"
assert certify("central_difference_lagged", structures=True).bound == (4, 2)

# %% [markdown]
# ## Two sub-steps that differ
#
# Newmark's rule, then backward differences, with the thesis's parameters is neither. Its two balances are
# $(A \otimes M + B \otimes C + D \otimes K) X = 0$ with $2 \times 2$ matrices in $\lambda$.
#
# **Theorem C.** If for every $\lambda \ne 1$ on the unit circle some $S(\lambda)$ makes $SA$, $SB$, $SD$ accretive and
# $SA$ strictly so, no structure with $K > 0$ has an eigenvalue on the circle, and so none outside. *Proof.* The real
# part of $X^* (S \otimes I)(\ldots) X = 0$ is a sum of three terms that are not negative. $\square$ By duality it is
# necessary as well: else Hermitian $P, Q, R \ge 0$ with $A P + B Q + D R = 0$, or limits of such, are a structure of
# four real degrees of freedom with the eigenvalue $\lambda$.
#
# An $S = B^* H$ with a Laurent polynomial $H$ of low degree is found and verified by algebra, as here; drawn are the
# least eigenvalues of the three Hermitian parts over their largest.

# %%
thesis = {"gamma_t": "1/5", "beta": "0.3025", "gamma": "3/5"}
assert certify("newmark_bdf2", structures=True, **thesis).verdict == "proved"


def at(matrix, value):
    return np.array([[sum(float(c) * value**k for k, c in e.items()) for e in row] for row in matrix])


rows = Rows(ParameterSet.of("newmark_bdf2", None, thesis))
multiplier, parts, angles = Multiplier.of(rows), pencil(rows), np.linspace(0.02, np.pi, 200)
assert multiplier is not None
assert parts is not None
print(multiplier.text)
least = []
for value in np.exp(1j * angles):
    matrices = [at(part, value) for part in parts]
    S = matrices[1].conj().T @ at(multiplier.H, value)
    eigenvalues = [np.linalg.eigvalsh(S @ m + (S @ m).conj().T) for m in matrices]
    least.append([low / high for low, high in eigenvalues])
figure, axes = plt.subplots(figsize=(6, 3))
axes.semilogy(angles, least, label=["SA", "SB", "SD"])
axes.set(xlabel="arg λ", ylabel="least over largest eigenvalue")
axes.legend()

# %%
assert np.min(least) > 0

# %% [markdown]
# ## Where nothing is proved
#
# With $\gamma = \frac{1}{2}$, $\beta = \frac{3}{2}$, $\gamma_t = \frac1{20}$ no such $H$ was found: the verdict is
# open. Since the criterion is necessary as well, one linear program at each $\lambda$, with the entries of $S$ as
# unknowns, would show the counterexample; it finds a multiplier at every angle that was tried, so that a proof should
# exist.

# %%
turned = np.pi * (1 + 5**0.5) * (np.arange(400) + 0.5)
half = np.arccos(1 - 2 * (np.arange(400) + 0.5) / 400) / 2
directions = np.stack([np.cos(half), np.sin(half) * np.exp(1j * turned)], axis=1)


def margin(matrices):
    """The largest t with Re x* S m x >= t for all matrices m and directions x, entries of S at most 1."""
    rows = []
    for m in matrices:
        products = np.einsum("ki,kj->kij", directions.conj(), directions @ m.T / np.linalg.norm(m)).reshape(-1, 4)
        rows.append(np.concatenate([-products.real, products.imag, np.ones((len(products), 1))], axis=1))
    rows = np.concatenate(rows)
    found = linprog(
        [0] * 8 + [-1], A_ub=rows, b_ub=np.zeros(len(rows)), bounds=[(-1, 1)] * 8 + [(None, None)], method="highs"
    )
    return found.x[-1]


left = {"gamma_t": "1/20", "beta": "3/2", "gamma": "1/2"}
assert certify("newmark_bdf2", structures=True, **left).verdict == "open"
parts, margins = pencil(Rows(ParameterSet.of("newmark_bdf2", None, left))), []
assert parts is not None
for value in np.exp(1j * np.array([0.2, 0.5, 1.0, 1.6, 2.2, 2.8, 3.1])):
    A, B, D = (at(part, value) for part in parts)
    margins.append(margin([A @ np.linalg.inv(B), np.eye(2), D @ np.linalg.inv(B)]))
print(margins)

# %%
assert min(margins) > 0

# %% [markdown]
# ## What a scheme loses on nonlinear scenes
#
# The motion that a scheme computes is, to every power of $h$, the exact motion of a modified equation, and keeps a
# modified energy $H = T + V + h^p H_p + \ldots$ but for a rate that is a sum of contractions of derivatives of $V$,
# whatever $V$ is. HHT-α loses energy on every potential at the rate $-\alpha (1 + \alpha)^2 h^3/4$ times the square of
# $V'' v$; BDF3 gains it.

# %%
energy = derive("hht_alpha").modified_energy
assert energy is not None
(rate,) = energy.coefficients(energy.rates)[3].values()
print(factor(rate))

# %%
alpha = derive("hht_alpha").symbols["alpha"]
assert simplify(rate - alpha * (1 + alpha) ** 2 / 4) == 0

# %% [markdown]
# One quadrature along the exact motion predicts the loss for every step. Lines are predictions, dots are marches of a
# pendulum; what comes and goes with the motion is predicted as well. Both begin at t = 2 s: until then the start, whose
# acceleration need not be that of the smooth motion, changes the energy once.

# %%
pendulum, h, colours = ss.scene("simple_pendulum", v0=1.5), 0.1, ("#0072B2", "#D55E00", "#009E73")
figure, axes = plt.subplots(figsize=(6.5, 3.5))
off = []
for name, colour in zip(("bathe", "hht_alpha", "bdf3"), colours, strict=True):
    predicted, marched = ss.energy_drift(pendulum, name, t_end=40.0), ss.march(pendulum, name, dt=h, t_end=40.0)
    change, dots = predicted.energy(h)[10:], marched.energy[:: round(0.2 / h)][10:]
    change, dots = (1e3 * (e - e[0]) / predicted.E0 for e in (change, dots))
    axes.plot(predicted.t[10:], change, color=colour, label=name)
    axes.plot(predicted.t[10::4], dots[::4], ".", color=colour)
    off.append(abs(change - dots).max() / abs(change).max())
axes.set(xlabel="t in s", ylabel="energy gained, in thousandths")
axes.legend(loc="center left", bbox_to_anchor=(1, 0.5))
print(off)

# %%
assert max(off) < 0.1
