"""Kernels of our own in C, as near to the machine's limit as we can write them, with which substep is compared."""

import ctypes
import hashlib
import os
import shutil
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import platformdirs
from numpy.typing import NDArray

from ..target import march

Array = NDArray[np.float64]

# no fast-math: the sums keep their order, only a product and a sum may become one operation
FLAGS = (
    "-O3",
    f"-march={march()}",
    "-ffp-contract=fast",
    "-fno-math-errno",
    "-std=gnu11",
    "-fPIC",
    "-shared",
    "-Wno-psabi",
)
HERE = Path(__file__).parent


class MissingCompilerError(RuntimeError):
    """No C compiler, or one that does not take these sources."""


def compiler() -> str:
    """Path of the C compiler. Raises MissingCompilerError if there is none."""
    found = shutil.which(os.environ.get("CC", "cc"))
    if found is None:
        raise MissingCompilerError("no C compiler: install gcc, or name one in CC")
    return found


@cache
def library(source: str, *flags: str, header: str = "") -> ctypes.CDLL:
    """The compiled source; header stands in for polynomials.h. Kept by digest in the cache folder."""
    own = "".join(path.read_text() for path in sorted(HERE.glob("*.[ch]")))
    about, machine = Path("/proc/cpuinfo"), ""  # a user's folder may be shared by machines with other processors
    if about.exists():
        machine = about.read_text().partition("flags")[2].partition("\n")[0]
    digest = hashlib.sha256("\0".join([compiler(), own, source, header, machine, *FLAGS, *flags]).encode()).hexdigest()
    folder = Path(platformdirs.user_cache_dir("substep")) / "benchmarks"
    built = folder / f"{digest[:32]}.so"
    if not built.exists():
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder) as work:
            (Path(work) / "polynomials.h").write_text(header)
            new = Path(work) / "new.so"
            command = [compiler(), *FLAGS, *flags, f"-I{work}", str(HERE / source), "-o", str(new), "-lm"]
            made = subprocess.run(command, capture_output=True, text=True, check=False)
            if made.returncode:
                raise MissingCompilerError(f"{' '.join(command)} failed: {made.stderr[:2000]}")
            new.replace(built)
    return ctypes.CDLL(str(built))


def assembly(source: str) -> str:
    """The compiler's assembly of a source."""
    command = [compiler(), *FLAGS, "-S", str(HERE / source), "-o", "-"]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def _pointer(array: Array) -> ctypes.c_void_p:
    assert array.flags.c_contiguous
    assert array.dtype == np.float64
    return ctypes.c_void_p(array.ctypes.data)


def _call(function: Any, *arguments: Any) -> Any:
    """Call a C function with converted numbers and arrays: int -> ptrdiff_t, float -> double, array -> pointer."""
    kinds = {int: ctypes.c_ssize_t, float: ctypes.c_double}
    return function(*(kinds[type(x)](x) if type(x) in kinds else _pointer(x) for x in arguments))


def _columns(inputs: tuple[Array, ...]) -> Any:
    return (ctypes.c_void_p * len(inputs))(*(x.ctypes.data for x in inputs))


def aligned(shape: tuple[int, ...]) -> Array:
    """Zeros that begin on a cache line, every page touched."""
    size = int(np.prod(shape))
    raw = np.zeros(size + 8)
    first = (-raw.ctypes.data % 64) // 8
    raw[:] = 0.0
    return raw[first : first + size].reshape(shape)


def _check_aligned(array: Array) -> None:
    if array.ctypes.data % 64:
        raise ValueError("expected an array that begins on a cache line, got another; make it with aligned")


@cache
def _header(scheme: str) -> str:
    from .polynomials import header  # noqa: PLC0415 (SymPy, only where it is needed)

    return header(scheme)


class Stability:
    """Stability functions of a scheme with two or three live eigenvalues; inputs Omega, xi, parameters, (n,), 8 | n.

    Raises ValueError for a scheme with more.
    """

    def __init__(self, scheme: str):
        self.library = library("stability.c", header=_header(scheme))

    def radius(self, inputs: tuple[Array, ...], out: Array) -> Array:
        """Spectral radius, into out (n,)."""
        _call_with_columns(self.library.radius, inputs, out)
        return out

    def radius_same(self, inputs: tuple[Array, ...], out: Array) -> Array:
        """What `radius` computes, with substep's digits at large Omega. Raises ValueError, as substep does."""
        if _call_with_columns(self.library.radius_same, inputs, out):
            raise ValueError("expected finite Omega and xi, none negative")
        return out

    def all(self, inputs: tuple[Array, ...], out: Array) -> Array:
        """Spectral radius, numerical damping, period error, into out (3, n), the digits of small Omega as substep's."""
        _call_with_columns(self.library.stability, inputs, *out)
        return out

    def all_far(self, inputs: tuple[Array, ...], out: Array) -> Array:
        """What `all` computes, but with the formula for large Omega at all points."""
        _call_with_columns(self.library.stability_far, inputs, *out)
        return out


def _call_with_columns(function: Any, inputs: tuple[Array, ...], *outputs: Array) -> Any:
    return function(ctypes.c_ssize_t(inputs[0].size), _columns(inputs), *map(_pointer, outputs))


def map_peaks(D: Array, B0: Array, B1: Array, f: Array, peak: Array) -> Array:
    """Peaks of |u| by the map, D (m, m, lanes), B0, B1 (m, lanes), m 2 or 3, f (n + 1,), 32 | lanes."""
    spectrum = library("spectrum.c")
    march = {2: spectrum.map_two, 3: spectrum.map_three}[len(D)]
    _call(march, D.shape[2], len(f) - 1, D, B0, B1, f, peak)
    return peak


def all_peaks(D: Array, B0: Array, B1: Array, damping: Array, stiffness: Array, f: Array, peaks: Array) -> Array:
    """Peaks (3, lanes) of |u|, |hv|, |h^2 a|."""
    _call(library("spectrum.c").map_two_peaks, D.shape[2], len(f) - 1, D, B0, B1, damping, stiffness, f, peaks)
    return peaks


def companion_peaks(coefficients: Array, f: Array, peak: Array) -> Array:
    """Peaks of |u| by the companion form, coefficients (5, lanes), f[0] = 0."""
    _call(library("spectrum.c").companion, coefficients.shape[1], len(f) - 1, coefficients, f, peak)
    return peak


def bilinear(way: str, numbers: Array, loads: Array, out: Array) -> Array:
    """Oscillators with a bilinear spring from rest, into out (6, lanes), 16 | lanes; loads (n,), the rest as in laws.c.

    way: "bilinear" or "bilinear_energy", numbers (5, lanes), or "bilinear_printed", numbers (13, lanes).
    """
    _call(getattr(library("laws.c"), way), numbers.shape[1], len(loads), numbers, loads, out)
    return out


def single_run(
    D: Array, B0: Array, B1: Array, damping: float, stiffness: float, f: Array, out: Array, *, increment: bool = False
) -> Array:
    """One run from out[0]; out (n + 1, 3), D (2, 2), B0, B1 (2,). increment: x + D x, not (1 + D) x."""
    functions = library("single.c")
    march = functions.single_increment if increment else functions.single
    _call(march, len(f) - 1, D, B0, B1, float(damping), float(stiffness), f, out)
    return out


def single_run_of_three(D: Array, B0: Array, B1: Array, f: Array, out: Array) -> Array:
    """One run whose acceleration is carried too; D (3, 3), B0, B1 (3,)."""
    _call(library("single.c").single_three, len(f) - 1, D, B0, B1, f, out)
    return out


def history(D: Array, B0: Array, B1: Array, damping: Array, stiffness: Array, f: Array, out: Array) -> Array:
    """History of many lanes from out[0]; out (n + 1, 3, lanes), `aligned`."""
    _check_aligned(out)
    state = out[0, :2].copy()
    _call(library("memory.c").history, D.shape[2], len(f) - 1, D, B0, B1, damping, stiffness, f, state, out)
    return out


def write(out: Array, *, stream: bool) -> None:
    """Fill an array, `aligned`, through the caches or past them."""
    _check_aligned(out)
    functions = library("memory.c")
    _call(functions.store_stream if stream else functions.store_plain, out.size, 1.0, out)


def pendulum(
    state: Array, stiffness: Array, peak: Array, *, n: int, h: float, parameters: tuple[float, ...],
    length: float, tolerance: float, vectors: bool = True,
) -> int:  # fmt: skip
    """Steps on the elastic pendulum; state (6, lanes) overwritten, 32 | lanes. Steps completed.

    parameters: gamma_t, beta, gamma of newmark_bdf2, or alpha_m, alpha_f, beta, gamma of generalized_alpha.
    """
    functions = (
        library("pendulum.c", "-DMARCH=vectors") if vectors else library("pendulum.c", "-DMARCH=scalar", "-DSCALAR")
    )
    name = "vectors" if vectors else "scalar"
    march = getattr(functions, name if len(parameters) == 3 else f"{name}_alpha")
    march.restype = ctypes.c_ssize_t
    return _call(march, state.shape[1], n, h, *parameters, length, tolerance, stiffness, state, peak)
