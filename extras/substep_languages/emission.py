"""A scheme in another language."""

from typing import TYPE_CHECKING, Any

from substep.core.errors import called_as

if TYPE_CHECKING:
    from substep.derived.modules import Declaration


@called_as('emit("bathe", "c")')
def emit(scheme: "str | Declaration", language: str, /, **parameters: Any) -> str:
    """A scheme as the text of one self-contained file: a step, stability functions and a test of itself.

    scheme: a name or a declaration. language: c, fortran, javascript, julia, matlab or python. parameters: exact
    numbers, int, Fraction or text such as "1/5", which are the file's defaults. See docs/emit.md.

    Raises ValueError for an unknown language, and what `substep_derive.derive` raises for the scheme and parameters.

    >>> print(ss.emit("newmark_bdf2", "python", gamma_t="1/5").splitlines()[4])
    # Parameters: newmark_bdf2, gamma_t = 1/5, beta = 1/4, gamma = 1/2
    """
    from .standalone import standalone  # noqa: PLC0415 (SymPy)

    return standalone(scheme, language, **parameters)
