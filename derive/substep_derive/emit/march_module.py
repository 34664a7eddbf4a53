"""Shape of a linear march -> text of its kernels, which know no scheme.

A shape is how many numbers x the march carries, and the places of u, h*v and h^2*a in x, -1 for one that is not in x
but an output of its own.
"""

import re
from collections.abc import Callable, Iterable, Mapping
from itertools import product
from typing import Any

from ..declare.names import entry_name
from ..kernels.march_shape import Shape
from .printing import fill, placed, wrapped
from .single import in_single
from .templates.decorators import COMPILE_AND_INNER
from .templates.march import MARCH, MARCH_HEADER, RUN, RUN_AHEAD, STRETCH
from .templates.registers import from_registers
from .templates.thread import COMPILE_KERNEL, MARCH_THREADS

WIDTH = 48  # lanes of a block: 6 vector registers of 8, enough to hide the latency of the recurrence
STEPS_AT_ONCE = 4  # steps for which a block's lanes stay in registers; LLVM unrolls no more of them
AHEAD = 256  # steps of one lane whose loads are taken at once: what they add fits the first cache
INLINE = 12  # most multiply-adds of a step of one lane that hide behind the chain from step to step, loads included
BLOCKS = 10  # blocks of one stretch of a history's rows, whose numbers fit the second cache


def march_module(shape: Shape, loads: Iterable[int], width: int = WIDTH) -> str:
    """Text of the module of a shape, without its banner; width: lanes of a block."""
    s = _Shape(shape, 2, width)
    imports = from_registers("store", "widest")
    sizes = {"m": s.m, "width": width, "blocks": BLOCKS, "ahead": AHEAD}
    head = fill(MARCH_HEADER, imports=imports, reported=", ".join(s.reported), **sizes)
    return head + COMPILE_AND_INNER + "".join(_Shape(shape, K, width).kernels() for K in loads)


def march_in_single(shape: Shape, K: int) -> str:
    """The same in single precision, for K load instants, with as many registers."""
    return in_single(march_module(shape, (K,), 2 * WIDTH))


def march_threads(shape: Shape, K: int) -> str:
    """Text of the module that marches a shape with K load instants in the threads of a GPU."""
    return _Shape(shape, K).threads()


def stretch(
    name: str,
    doc: str,
    at_once: int,
    moving: Mapping[str, str],
    loads: Mapping[str, str],
    step: Callable[[int], str],
    begin: str = "",
    width: int = WIDTH,
) -> str:
    """Text of a function that marches a block through a stretch of steps; lanes stay in registers for at_once of them.

    moving: names of what changes from step to step, and their places in the block. loads: names of a step's loads, and
    of the arrays they are read from. step: lines of a step of one lane, at a depth of indentation. begin: the line that
    gives the first step i and the number n of steps, where these are not arguments: known, i is not looked at again.
    """
    return fill(
        STRETCH,
        name=name,
        docstring=doc,
        steps_at_once=at_once,
        width=width,
        moving=", ".join(moving),
        places=", ".join(moving.values()),
        f=", ".join(loads),
        arguments=", ".join(["s", *loads.values(), *([] if begin else ["i", "n"])]),
        begin=begin and placed([begin], 1) + "\n",
        f_at_k=", ".join(f"{F}[i + k]" for F in loads.values()),
        f_at_i=", ".join(f"{F}[i]" for F in loads.values()),
        step=step(4),
        step_alone=step(3),
    )


class _Shape:
    """Names in the kernels of a shape with K load instants, and their rows in a block of `width` lanes."""

    def __init__(self, shape: Shape, K: int, width: int = WIDTH) -> None:
        self.m, places = shape
        self.width = width
        self.K, self.R = K, sum(place < 0 for place in places)
        self.x, self.y, self.t, self.f = (
            [f"{name}{r}" for r in range(count)] for name, count in (("x", self.m), ("y", self.R), ("t", 3), ("f", K))
        )
        self.F = [f"F{k}" for k in range(K)]
        outputs = iter(self.y)
        self.reported = [self.x[place] if place >= 0 else next(outputs) for place in places]
        columns = {"D": (self.m, self.m), "B": (self.m, K), "O": (self.R, self.m), "P": (self.R, K)}
        self.entries = [entry_name(name, i, j) for name, size in columns.items() for i, j in product(*map(range, size))]
        # h*v and h^2*a in x need a scale to give v and a; that of the outputs is part of O and P
        self.scales = {name: f"z{k}" for k, name in enumerate(self.reported) if k and name[0] == "x"}
        own = [f"own{k}" for k in range(K)]  # loads, where each lane has its own
        before = [*self.x, *self.y, *self.t, *own]
        self.before = len(before)
        self.row = {name: k for k, name in enumerate([*before, *self.entries, *self.scales.values()])}

    def at(self, name: str) -> str:
        """Text of the place of a lane's number in its block."""
        return f"s[{self.row[name] * self.width} + j]" if self.row[name] else "s[j]"

    def sum(self, name: str, i: int, in_block: bool) -> str:
        """Text of row i of D or O times x plus that of B or P times the load."""
        return nested(self.terms(name, i, in_block))

    def terms(self, name: str, i: int, in_block: bool) -> list[str]:
        """Text of the terms of row i of D or O times x, and of B or P times the load."""
        other = {"D": "B", "O": "P"}[name]
        terms = [(entry_name(name, i, j), f"x{j}") for j in range(self.m)]
        terms += [(entry_name(other, i, k), f"f{k}") for k in range(self.K)]
        return [f"{self.at(a) if in_block else a} * {b}" for a, b in terms]

    def scaled_in_block(self, name: str, *, in_block: bool = False) -> str:
        """Text of u, v or a in a loop over lanes; in_block: read from the block, not from the loop's variables."""
        value = self.at(name) if in_block else name
        return f"{self.at(self.scales[name])} * {value}" if name in self.scales else value

    def scales_text(self) -> str:
        """The scales as a docstring names them."""
        rows = [f"1/h{'^2' if z == 'z2' else ''}" for z in self.scales.values()]
        return " and ".join(rows) or "nothing else"

    def step(self, depth: int, in_block: bool = True) -> str:
        """Lines of one step of a lane, with its coefficients in a block or in numbers of their own."""
        lines = [f"{name} = {self.sum('O', i, in_block)}" for i, name in enumerate(self.y)]
        lines += [f"c{i} = {self.sum('D', i, in_block)}" for i in range(self.m)]
        return placed([*lines, *(f"{name} += c{i}" for i, name in enumerate(self.x))], depth)

    def step_with_peaks(self, depth: int) -> str:
        """The same, and the largest |u|, |v|, |a| so far."""
        largest = self.largest(map(self.scaled_in_block, self.reported))
        return f"{self.step(depth)}\n{placed([largest], depth)}"

    def largest(self, values: Iterable[str]) -> str:
        """The line that compares u, v, a of a step with the largest so far."""
        largest = (f"max({t}, abs({value}))" for t, value in zip(self.t, values, strict=True))
        return f"{', '.join(self.t)} = {', '.join(largest)}"

    def kernels(self) -> str:
        """Text of all kernels for K load instants."""
        K, loads = self.K, dict(zip(self.f, self.F, strict=True))
        xy, xyt = ({name: self.at(name) for name in (*self.x, *self.y, *t)} for t in ((), self.t))
        at_once = STEPS_AT_ONCE if self.m < 4 else 1
        stretches = (
            ("_final", "for its last state and outputs", xy, self.step),
            ("_peaks", "for the largest |u|, |v|, |a| too", xyt, self.step_with_peaks),
        )
        text = "".join(
            stretch(
                f"{name}_{K}",
                f"March a block n steps from step i on, {what}.",
                at_once,
                moving,
                loads,
                step,
                width=self.width,
            )
            for name, what, moving, step in stretches
        )
        inline = (self.m + self.R) * (self.m + K) <= INLINE
        run: dict[str, Any] = {"f_at_i": ", ".join(f"{F}[i]" for F in self.F)}
        if not inline:
            ahead = ", ".join(f"{F}[first : first + AHEAD]" for F in self.F)
            run = {"sums": self.R + self.m, "ahead": self.loads_ahead(), "f_ahead": ahead}
        return text + fill(
            MARCH + (RUN if inline else RUN_AHEAD),
            **run,
            K=K, m=self.m, width=self.width, steps_at_once=at_once, rows=len(self.row),
            before=self.before, given=len(self.row) - self.before,
            peaks=self.row["t0"], own=self.row["own0"], scales=self.scales_text(),
            x=", ".join(self.x), xyt=", ".join(xyt), at_xyt=", ".join(xyt.values()),
            f=", ".join(self.f), F=", ".join(self.F),
            at_x=", ".join(f"x[{r}]" for r in range(self.m)),
            f_at_k=", ".join(f"{F}[i + k]" for F in self.F),
            f_of_lane=", ".join(self.at(f"own{k}") for k in range(K)),
            scaled=", ".join(map(self.scaled_in_block, self.reported)),
            staged=", ".join(f"rows[{BLOCKS * self.width} * (3 * k + {r}) + j]" for r in range(3)),
            at_x_in_block=", ".join(map(self.at, self.x)),
            step=self.step(3), step_with_peaks=self.step_with_peaks(2),
            one=self.one_lane(inline),
            takes=placed(
                (
                    f"place = min(max(at + {r} * lanes, 0), FAR)\n"
                    f"for j in range(size):\n    values[place + j] = {self.scaled_in_block(name, in_block=True)}"
                    for r, name in enumerate(self.reported)
                ),
                5,
            ),
            coefficients=wrapped([*self.entries, *self.scales.values()]),
        )  # fmt: skip

    def threads(self) -> str:
        """Text of the module for a GPU: all numbers of a lane have names of their own, for registers of its thread."""
        given, row = [*self.entries, *self.scales.values()], "out[(i + 1) // stride"
        values = [f"{self.scales[name]} * {name}" if name in self.scales else name for name in self.reported]
        read = [f"{name} = C[{r}, lane]" for r, name in enumerate(given)]
        read += [f"{name} = x[{r}, lane]" for r, name in enumerate(self.x)]
        return fill(
            MARCH_THREADS,
            compiled=COMPILE_KERNEL,
            m=self.m, K=self.K, given=len(given), scales=self.scales_text(),
            read=placed(read, 2),
            f=", ".join(self.f), f_at_i=", ".join(f"forces[{k}, i, own]" for k in range(self.K)),
            step=self.step(3, in_block=False),
            largest=placed([self.largest(values)], 4),
            store=placed((f"{row}, {r}, lane] = {value}" for r, value in enumerate(values)), 4),
            write=placed((f"x[{r}, lane] = {name}" for r, name in enumerate(self.x)), 2),
        )  # fmt: skip

    def loads_ahead(self) -> str:
        """Lines of what the loads of a step of one lane add to each output, then to each number of x."""
        rows = [("O", i) for i in range(self.R)] + [("D", i) for i in range(self.m)]
        sums = (nested(self.terms(name, i, False)[self.m :]) for name, i in rows)
        lines = (f"loaded[{_row(r)}i] = {text}" for r, text in enumerate(sums))
        return placed((re.sub(r"\bf(\d+)", r"f\1[i]", line) for line in lines), 3)

    def one_lane(self, inline: bool) -> str:
        """Lines of a step of one lane: x1 = (x0 + D_ii x0) + (the other terms), whose first sum is rounded once.

        inline: what the loads add is computed in these lines, not ahead of them.
        """
        rows, at = "out[i" if inline else "rows[i", 2 if inline else 3

        def terms(name: str, i: int, r: int) -> list[str]:
            found = self.terms(name, i, False)
            return found if inline else [*found[: self.m], f"loaded[{_row(r)}i]"]

        lines = [f"{name} = {nested(terms('O', i, i))}" for i, name in enumerate(self.y)]
        for i, name in enumerate(self.x):
            others = terms("D", i, self.R + i)
            own = others.pop(i)
            lines.append(f"c{i} = ({name} + {own}) + ({nested(others)})")
        stored = (f"{self.scales[name]} * {name}" if name in self.scales else name for name in self.reported)
        lines += [f"{name} = c{i}" for i, name in enumerate(self.x)]
        return placed([*lines, *(f"{rows}, {k}] = {e}" for k, e in enumerate(stored))], at)


def _row(r: int) -> str:
    """Text of where row r of what the loads add begins."""
    return f"{r} * AHEAD + " if r > 1 else "AHEAD + " * r


def nested(terms: Iterable[str]) -> str:
    """The sum as a*b + (c*d + e), which compiles to one multiply-add a term."""
    *others, text = terms
    for k, term in enumerate(reversed(others)):
        text = f"{term} + ({text})" if k else f"{term} + {text}"
    return text
