"""Fixed text of how functions are compiled whose products and sums may become one operation, in the order written."""

COMPILE = """_compile = njit(cache=True, nogil=True, error_model="numpy", no_cfunc_wrapper=True, fastmath={"contract"})
"""

INNER = """\
_inner = njit(nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, fastmath={"contract"})
"""

INLINE = """_inline = njit(
    nogil=True, error_model="numpy", no_cfunc_wrapper=True, no_cpython_wrapper=True, fastmath={"contract"},
    forceinline=True,
)
"""

COMPILE_AND_INNER = f"""{COMPILE}# called by kernels alone: not from Python, and so without the code for that
{INNER}"""
