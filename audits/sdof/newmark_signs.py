"""Two signs in sdof.integration.newmark.newmark are wrong, so each of its schemes, named stable, grows without bound.

Source, sdof 0.0.12, sdof/integration/newmark.py: line 108 has b4 = 1 + 1/(2 beta), the factor of the old acceleration
in the new one, which is 1 - 1/(2 beta); line 127 adds b2 C a to the effective load, from which it is to be taken,
since the new velocity is b1 v + b2 a + c2 du. The public function, sdof.integrate, has both right
(src/_integrate.c:93).

Integrators, by their names in the report: newmark_0, newmark_1, newmark_3, newmark_4.
"""

import numpy as np
from sdof import integrate
from sdof.integration.newmark import newmark

DT, STEPS, DAMPING = 0.5, 20, 0.1
load = np.zeros(STEPS + 1)


def corrected(beta: float, gamma: float, damping: float) -> np.ndarray:
    """The increments of the same function with both signs set right."""
    u, v = 1.0, 0.0
    a = -u - damping * v
    history = [u]
    c2, c3 = gamma / (beta * DT), 1 / (beta * DT**2)
    b1, b2 = 1 - gamma / beta, DT * (1 - gamma / (2 * beta))
    b3, b4 = -1 / (beta * DT), 1 - 1 / (2 * beta)
    for _ in range(STEPS):
        force = (1 / (beta * DT) + gamma / beta * damping) * v + (1 / (2 * beta) - b2 * damping) * a
        du = force / (c3 + c2 * damping + 1)
        u, v, a = u + du, b1 * v + b2 * a + c2 * du, b4 * a + b3 * v + c3 * du
        history.append(u)
    return np.array(history)


for n, beta, gamma in ((0, 0.25, 0.5), (1, 1 / 6, 0.5), (3, 0.8, 1.5), (4, 1.0, 1.5)):
    obtained = newmark(1.0, DAMPING, 1.0, load, DT, n=n, u0=1.0)[0]
    public = integrate(load, DT, k=1.0, c=DAMPING, m=1.0, u0=1.0, beta=beta, gamma=gamma)[0]
    right = corrected(beta, gamma, DAMPING)
    print(f"n = {n}: u after {STEPS} steps of free vibration from 1")
    print(f"  newmark {obtained[-1]: .6e}, signs set right {right[-1]: .12f}, sdof.integrate {public[-1]: .12f}")
