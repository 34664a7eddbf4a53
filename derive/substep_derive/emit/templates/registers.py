"""Fixed text of the one module that other kernels import: what is said to LLVM, and is the same whatever is marched."""

import hashlib

REGISTERS = '''"""What loops over lanes ask of LLVM: the widest registers of a CPU, and stores past its caches."""

from llvmlite import ir
from numba.core import types
from numba.extending import intrinsic, overload

LARGE = 1 << 20  # numbers of a history that is stored past the caches, which could not hold it
FAR = 1 << 50  # beyond any index; loops are vectorised if their first index is known to lie from 0 to FAR


@intrinsic
def _prefer_widest(typing):
    """Let LLVM take the widest registers there are: on Intel's CPUs with AVX-512 it takes half of them by itself."""

    def lower(context, builder, signature, arguments):
        # past the check of llvmlite's class, which has no attributes with a value
        set.add(builder.function.attributes, '"prefer-vector-width"="512"')
        return context.get_dummy_value()

    return types.none(), lower


def widest():
    """As `_prefer_widest`; nothing in plain Python."""


@overload(widest, inline="always")
def _widest_compiled():
    return lambda: _prefer_widest()


@intrinsic
def _stream(typing, values, place, row, at):
    """Store eight numbers from row[at] on past the caches, from values[place] on, which begins a cache line."""

    def lower(context, builder, signature, arguments):
        eight = ir.VectorType(ir.DoubleType(), 8).as_pointer()
        to, source = (
            builder.bitcast(builder.gep(context.make_array(kind)(context, builder, array).data, [index]), eight)
            for kind, array, index in ((values, *arguments[:2]), (row, *arguments[2:]))
        )
        store = builder.store(builder.load(source, align=8), to, align=64)
        store.set_metadata("nontemporal", builder.module.add_metadata([ir.Constant(ir.IntType(32), 1)]))

    return types.void(values, types.intp, row, types.intp), lower


def store(values, place, row, at, size):
    """Store numbers from row[at] on into values[place] on; compiled, past the caches where `values` would empty them.

    Of doubles alone: a line of a cache has eight of them.
    """
    values[place : place + size] = row[at : at + size]


@overload(store)
def _store_compiled(values, place, row, at, size):
    doubles = values.dtype == types.float64

    def stored(values, place, row, at, size):
        place, at, size = min(max(place, 0), FAR), min(max(at, 0), FAR), min(max(size, 0), FAR)
        past = doubles and values.size > LARGE
        head = min(-((values.ctypes.data >> 3) + place) & 7, size) if past else size
        whole = head + (size - head) // 8 * 8
        for j in range(head):
            values[place + j] = row[at + j]
        for j in range(head, whole, 8):
            _stream(values, place + j, row, at + j)
        for j in range(whole, size):
            values[place + j] = row[at + j]

    return stored
'''

_DIGEST = hashlib.sha256(REGISTERS.encode()).hexdigest()[:8]


def from_registers(*names: str) -> str:
    """The line that imports them. numba's cache of a module is valid as long as its text, so that it has the digest."""
    return f"from substep_kernels.shared.registers import {', '.join(names)}  # with the digest {_DIGEST}\n"


WIDEST = from_registers("widest")
