"""Laws without a memory."""

from sympy import Symbol

from ..branches import clip, larger
from ..law import Law, e
from ..scene import required

k, k_2, k_3, e_1, e_2 = (Symbol(name) for name in ("k", "k_2", "k_3", "e_1", "e_2"))
last = larger(e_1, e_2)  # without a part of k_2 where e_2 is the smaller
first, second = clip(e, -e_1, e_1), clip(e, -last, last)

linear = Law(
    "linear",
    parameters=(required(k),),
    force=k * e,
    stored=k * e**2 / 2,
    reference="a linear spring",
)

multilinear = Law(
    "multilinear",
    parameters=(required(k), required(e_1), required(k_2), required(e_2), required(k_3)),
    force=k_3 * e + (k - k_2) * first + (k_2 - k_3) * second,
    stored=k_3 * e**2 / 2 + (k - k_2) * (first * e - first**2 / 2) + (k_2 - k_3) * (second * e - second**2 / 2),
    reference="elastic: the stiffness k up to the elongation e_1, k_2 up to e_2 and k_3 beyond, in both directions",
)

ALL = (linear, multilinear)
