"""Fixed text that modules share whose loops over lanes fill the widest registers of a CPU."""

WIDEST_IMPORTS = """from numba.core import types
from numba.extending import intrinsic, overload
"""

WIDEST = '''

@intrinsic
def _prefer_widest(typing):
    """Let LLVM take the widest registers there are: on Intel's CPUs with AVX-512 it takes half of them by itself."""

    def lower(context, builder, signature, arguments):
        # past the check of llvmlite's class, which has no attributes with a value
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.none(), lower


def _widest():
    """As `_prefer_widest`, in plain Python."""


@overload(_widest, inline="always")
def _widest_compiled():
    return lambda: _prefer_widest()
'''
