"""EigenvalueDefect -> lines that evaluate it from Omega, xi and the outputs of the kernel `_defect`."""

from collections.abc import Iterator

from sympy import Rational

from ..kernels.eigenvalue_defect import EigenvalueDefect, series, until_negligible


def defect_lines(defect: EigenvalueDefect, small_Omega: float) -> Iterator[str]:
    """Lines that compute, from Omega, xi and the outputs of the kernel `_defect`, the polynomial's value p0 + p1 zeta.

    It is that over Omega^3, at tau = Omega (a1_1 + b1_1 zeta) of the exact eigenvalue.
    """
    highest = max(n for _, n in defect.tails)
    yield "x, w = 2.0 * xi, Omega * Omega"
    yield "y, z = w * (2.0 - x * x), w * w  # s^4 = -y s^2 - z"
    yield "z1, y1 = 0.0, 1.0  # zeta^n = zn + yn zeta"
    for n in range(2, max(highest, 3) + 1):
        yield f"z{n}, y{n} = -y{n - 1}, z{n - 1} - x * y{n - 1}"
    for j in range(1, max(j for j, _ in defect.tails) + 1):
        starts = [n for i, n in defect.tails if i == j]
        top, low = max(starts, default=j), min(starts, default=j)
        top, low = (max(top, 3), 1) if j == 1 else (top, low)  # all of tau, which is returned too
        if j > 1 and not starts:
            continue
        constants = [_number(c) for c in until_negligible(j, top, small_Omega)]
        *rest, last, highest = (
            constants  # u + v s^2 is the polynomial in s^2 with these constants, where s^4 = -y s^2 - z
        )
        yield f"u, v = {last}, {highest}"
        yield from (f"u, v = {constant} - z * v, u - y * v" for constant in reversed(rest))
        yield f"c{j}, d{j} = u - w * v, -x * w * v"
        yield f"a{j}_{top} = c{j} * z{top} - d{j} * y{top}"
        yield f"b{j}_{top} = c{j} * y{top} + d{j} * (z{top} - x * y{top})"
        for n in range(top - 2, low - 1, -2):
            number, above = _number(series(j, n)), f"_{n + 2}"
            own = (f"{number} * z{n}", f"{number} * y{n}")
            own = tuple(e.removeprefix("1.0 * ") for e in own)
            sums = ", ".join(f"{e} + w * {x}{j}{above}" for e, x in zip(own, "ab", strict=True))
            yield f"a{j}_{n}, b{j}_{n} = {sums}"
    names = [f"{j}_{n}" for j, n in sorted(defect.tails)]
    scale = " * ".join(["Omega"] * (defect.terms - 3))
    yield f"p0 += {scale} * (k0 + " + " + ".join(f"k{name} * a{name}" for name in names) + ")"
    yield f"p1 += {scale} * (" + " + ".join(f"k{name} * b{name}" for name in names) + ")"


def _number(value: Rational) -> str:
    return f"{value.p}.0" if value.q == 1 else f"{value.p}.0 / {value.q}.0"
