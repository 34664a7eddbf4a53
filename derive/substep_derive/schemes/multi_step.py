"""Multi-step schemes: the state holds earlier steps."""

from ..scheme import Balance, Scheme
from ..symbols import h, knot

u0, v0, a0 = knot(0)
u1, v1, a1 = end = knot(1)
um, vm, am = knot(-1)
umm, vmm, amm = knot(-2)

houbolt = Scheme(
    "houbolt",
    relations={
        a1: (2 * u1 - 5 * u0 + 4 * um - umm) / h**2,
        v1: (11 * u1 - 18 * u0 + 9 * um - 2 * umm) / (6 * h),
    },
    balances=(Balance.at(end, 1),),
    reference="Houbolt, J. Aeronaut. Sci. 17 (1950) 540-550",
)

park = Scheme(
    "park",
    relations={
        v1: (10 * u1 - 15 * u0 + 6 * um - umm) / (6 * h),
        a1: (10 * v1 - 15 * v0 + 6 * vm - vmm) / (6 * h),
    },
    balances=(Balance.at(end, 1),),
    reference="Park, J. Appl. Mech. 42 (1975) 464-470",
)
