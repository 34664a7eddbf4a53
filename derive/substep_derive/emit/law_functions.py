"""Functions that laws are written with -> their text in a module that calls them."""

from collections.abc import Iterable

from .printing import fill
from .templates.laws import BOUC_WEN, GAUSS, PHI_1, PHI_2


def law_functions(text: str, decorator: str) -> Iterable[str]:
    """The functions that a module's text calls; decorator: the line above each, for kernels.

    Without a decorator they take arrays.
    """
    called = [name for name in ("phi_1", "phi_2", "bouc_wen", "bouc_wen_work", "bouc_wen_slope") if f"_{name}(" in text]
    smooth = [name for name in called if name.startswith("bouc_wen")]
    if "phi_1" in called:
        yield fill(PHI_1, decorator=decorator)
    if "phi_2" in called:
        yield fill(PHI_2, decorator=decorator)
    if smooth:
        yield GAUSS
        yield fill(BOUC_WEN, decorator=decorator)
    if called and not decorator:
        yield "\n\n"
        yield from (f"_{name} = np.vectorize(_{name}, otypes=[float])\n" for name in called)
