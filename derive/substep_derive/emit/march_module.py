"""Shape of a linear march -> text of its kernels, which know no scheme.

A shape is how many numbers x the march carries, and the places of u, h*v and h^2*a in x, -1 for one that is not in x
but an output of its own.
"""

from collections.abc import Iterable
from functools import partial
from itertools import product
from textwrap import indent, wrap

from ..declare.names import entry_name
from ..kernels.march_shape import LOADS, Shape
from .printing import fill
from .templates.march import MARCH, MARCH_HEADER

WIDTH = 48  # lanes of a block: 6 vector registers of 8, enough to hide the latency of the recurrence
STEPS_AT_ONCE = 4  # steps for which a block's lanes stay in registers; LLVM unrolls no more of them


def march_module(shape: Shape, loads: Iterable[int] = LOADS) -> str:
    """Text of the module of a shape, without its banner."""
    s = _Shape(shape, 2)
    head = fill(MARCH_HEADER, reported=", ".join(s.reported), width=WIDTH)
    return head + "".join(_Shape(shape, K).kernels() for K in loads)


class _Shape:
    """Names in the kernels of a shape with K load instants, and their rows in a block."""

    def __init__(self, shape: Shape, K: int) -> None:
        self.m, places = shape
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
        return f"s[{self.row[name] * WIDTH} + j]" if self.row[name] else "s[j]"

    def sum(self, name: str, i: int, x: str, f: str, in_block: bool) -> str:
        """Text of row i of D or O times x plus that of B or P times the load; in_block: coefficients from it."""
        other = {"D": "B", "O": "P"}[name]
        terms = [(entry_name(name, i, j), f"{x}{j}") for j in range(self.m)]
        terms += [(entry_name(other, i, k), f"{f}{k}") for k in range(self.K)]
        return nested(f"{self.at(a) if in_block else a} * {b}" for a, b in terms)

    def scaled_in_block(self, name: str, *, in_block: bool = False) -> str:
        """Text of u, v or a in a loop over lanes; in_block: read from the block, not from the loop's variables."""
        value = self.at(name) if in_block else name
        return f"{self.at(self.scales[name])} * {value}" if name in self.scales else value

    def scales_text(self) -> str:
        """The scales as a docstring names them."""
        rows = [f"1/h{'^2' if z == 'z2' else ''}" for z in self.scales.values()]
        return " and ".join(rows) or "nothing else"

    def step(self, depth: int, in_block: bool = True) -> str:
        """Lines of one step; in_block: with coefficients read from the block."""
        lines = [f"{name} = {self.sum('O', i, 'x', 'f', in_block)}" for i, name in enumerate(self.y)]
        lines += [f"c{i} = {self.sum('D', i, 'x', 'f', in_block)}" for i in range(self.m)]
        return place_lines([*lines, *(f"{name} += c{i}" for i, name in enumerate(self.x))], depth)

    def kernels(self) -> str:
        """Text of all kernels for K load instants."""
        K, xy, xyt = self.K, [*self.x, *self.y], [*self.x, *self.y, *self.t]
        scaled = [self.scaled_in_block(name) for name in self.reported]
        largest = (f"max({t}, abs({e}))" for t, e in zip(self.t, scaled, strict=True))
        return fill(
            MARCH,
            K=K, m=self.m, width=WIDTH, steps_at_once=STEPS_AT_ONCE if self.m < 4 else 1, rows=len(self.row),
            before=self.before, given=len(self.row) - self.before,
            peaks=self.row["t0"], own=self.row["own0"], scales=self.scales_text(),
            x=", ".join(self.x), xy=", ".join(xy), xyt=", ".join(xyt), t=", ".join(self.t),
            f=", ".join(self.f), F=", ".join(self.F),
            at_x=", ".join(f"x[{r}]" for r in range(self.m)),
            at_xy=", ".join(map(self.at, xy)), at_xyt=", ".join(map(self.at, xyt)),
            f_at_k=", ".join(f"{F}[i + k]" for F in self.F), f_at_i=", ".join(f"{F}[i]" for F in self.F),
            f_of_lane=", ".join(self.at(f"own{k}") for k in range(K)),
            scaled=", ".join(scaled),
            step=self.step(4), step_alone=self.step(3), step_own=self.step(2), largest=", ".join(largest),
            takes=place_lines(
                (
                    f"place = min(max(at + {r} * lanes, 0), FAR)\n"
                    f"for j in range(size):\n    values[place + j] = {self.scaled_in_block(name, in_block=True)}"
                    for r, name in enumerate(self.reported)
                ),
                4,
            ),
            coefficients=_wrapped([*self.entries, *self.scales.values()]),
            **self.one_lane(),
        )  # fmt: skip

    def one_lane(self) -> dict[str, str]:
        """Lines of the march of one lane, by two steps: x2 = x0 + E x0 + (1 + D) B f_0 + B f_1, E = (1 + D)^2 - 1."""
        m, K = range(self.m), range(self.K)
        D, E, B = (partial(entry_name, name) for name in "DEB")
        squares = [
            f"{E(i, j)} = 2.0 * {D(i, j)} + ({nested(f'{D(i, k)} * {D(k, j)}' for k in m)})"
            for i, j in product(m, repeat=2)
        ]
        two = [f"f{k}, l{k} = F{k}[i], F{k}[i + 1]" for k in K]
        two += [f"g{i} = {nested(f'{B(i, k)} * f{k}' for k in K)}" for i in m]
        two += [f"{name} = {self.sum('O', i, 'x', 'f', False)}" for i, name in enumerate(self.y)]
        two += [f"w{i} = x{i} + ({nested([*(f'{D(i, j)} * x{j}' for j in m), f'g{i}'])})" for i in m]
        two += self.stored("w", "i")
        two += [
            f"h{i} = g{i} + ({nested([*(f'{D(i, j)} * g{j}' for j in m), *(f'{B(i, k)} * l{k}' for k in K)])})"
            for i in m
        ]
        two += [f"{name} = {self.sum('O', i, 'w', 'l', False)}" for i, name in enumerate(self.y)]
        two += [f"c{i} = {nested([*(f'{E(i, j)} * x{j}' for j in m), f'h{i}'])}" for i in m]
        two += [f"x{i} += c{i}" for i in m]
        one = [f"f{k} = F{k}[i]" for k in K]
        return {
            "squares": place_lines(squares, 1),
            "two": place_lines([*two, *self.stored("x", "i + 1")], 2),
            "one": "\n".join(
                [place_lines(one, 2), self.step(2, in_block=False), place_lines(self.stored("x", "i"), 2)]
            ),
        }

    def stored(self, x: str, step: str) -> list[str]:
        """Lines that store u, v, a of a step, whose state has the name x."""
        scaled = (f"{self.scales[name]} * {name}" if name in self.scales else name for name in self.reported)
        return [f"out[{step}, {k}] = {e.replace('x', x)}" for k, e in enumerate(scaled)]


def nested(terms: Iterable[str]) -> str:
    """The sum as a*b + (c*d + e), which compiles to one multiply-add a term."""
    *others, text = terms
    for k, term in enumerate(reversed(others)):
        text = f"{term} + ({text})" if k else f"{term} + {text}"
    return text


def place_lines(texts: Iterable[str], depth: int) -> str:
    """Lines at that depth of indentation."""
    return indent("\n".join(texts), "    " * depth)


def _wrapped(names: list[str]) -> str:
    lines = wrap(", ".join(names), 100)
    return lines[0] if len(lines) == 1 else "(\n        " + "\n        ".join(lines) + "\n    )"
