"""Shape of a linear march -> text of its kernels, which know no scheme.

A shape is how many numbers x the march carries, and where in it u, h*v and h^2*a stand, -1 for one that is an
output of its own.
"""

from collections.abc import Iterable
from functools import partial
from itertools import product
from textwrap import indent, wrap

from ..declare.names import entry_name
from ..kernels.march_shape import LOADS, Shape
from .printing import fill
from .templates.march import MARCH, MARCH_HEADER

WIDTH = 48  # lanes abreast: 6 registers of 8 hide the latency of the recurrence


TURNS = 4  # steps that a block takes at once, as long as LLVM unrolls them


def march_module(shape: Shape, loads: Iterable[int] = LOADS) -> str:
    """Text of the module of a shape, without its banner."""
    s = _Shape(shape, 2)
    head = fill(MARCH_HEADER, reported=", ".join(s.reported), width=WIDTH)
    return head + "".join(_Shape(shape, K).kernels() for K in loads)


class _Shape:
    """Names of a shape with K load instants, and the rows of a block where they stand."""

    def __init__(self, shape: Shape, K: int) -> None:
        self.m, places = shape
        self.K, self.R = K, sum(place < 0 for place in places)
        self.x, self.y, self.t, self.f = (
            [f"{name}{r}" for r in range(count)] for name, count in (("x", self.m), ("y", self.R), ("t", 3), ("f", K))
        )
        self.F = [f"F{k}" for k in range(K)]
        told = iter(self.y)
        self.reported = [self.x[place] if place >= 0 else next(told) for place in places]
        columns = {"D": (self.m, self.m), "B": (self.m, K), "O": (self.R, self.m), "P": (self.R, K)}
        self.entries = [entry_name(name, i, j) for name, size in columns.items() for i, j in product(*map(range, size))]
        # u, v, a of what is in the state: v and a need a scale, that of the other outputs is in O and P
        self.scales = {name: f"z{k}" for k, name in enumerate(self.reported) if k and name[0] == "x"}
        own = [f"own{k}" for k in range(K)]  # loads of every lane its own
        before = [*self.x, *self.y, *self.t, *own]
        self.before = len(before)
        self.row = {name: k for k, name in enumerate([*before, *self.entries, *self.scales.values()])}

    def at(self, name: str) -> str:
        """Where a lane's number stands in its block."""
        return f"s[{self.row[name] * WIDTH} + j]" if self.row[name] else "s[j]"

    def sum(self, name: str, i: int, x: str, f: str, place: bool) -> str:
        """Row i of D or O times x plus that of B or P times the load."""
        other = {"D": "B", "O": "P"}[name]
        terms = [(entry_name(name, i, j), f"{x}{j}") for j in range(self.m)]
        terms += [(entry_name(other, i, k), f"{f}{k}") for k in range(self.K)]
        return nested(f"{self.at(a) if place else a} * {b}" for a, b in terms)

    def scaled_in_block(self, name: str, *, taken: bool = False) -> str:
        """u, v or a in a loop over lanes; taken: from the block, not from the loop."""
        value = self.at(name) if taken else name
        return f"{self.at(self.scales[name])} * {value}" if name in self.scales else value

    def told(self) -> str:
        """What the scales are, for a reader."""
        rows = [f"1/h{'^2' if z == 'z2' else ''}" for z in self.scales.values()]
        return " and ".join(rows) or "no more"

    def step(self, depth: int, place: bool = True) -> str:
        """Lines of one step."""
        lines = [f"{name} = {self.sum('O', i, 'x', 'f', place)}" for i, name in enumerate(self.y)]
        lines += [f"c{i} = {self.sum('D', i, 'x', 'f', place)}" for i in range(self.m)]
        return place_lines([*lines, *(f"{name} += c{i}" for i, name in enumerate(self.x))], depth)

    def kernels(self) -> str:
        """Text of all kernels for K load instants."""
        K, xy, xyt = self.K, [*self.x, *self.y], [*self.x, *self.y, *self.t]
        scaled = [self.scaled_in_block(name) for name in self.reported]
        largest = (f"max({t}, abs({e}))" for t, e in zip(self.t, scaled, strict=True))
        return fill(
            MARCH,
            K=K, m=self.m, width=WIDTH, turns=TURNS if self.m < 4 else 1, rows=len(self.row),
            before=self.before, given=len(self.row) - self.before,
            peaks=self.row["t0"], own=self.row["own0"], scales_told=self.told(),
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
                    f"for j in range(size):\n    values[place + j] = {self.scaled_in_block(name, taken=True)}"
                    for r, name in enumerate(self.reported)
                ),
                4,
            ),
            coefficients=_wrapped([*self.entries, *self.scales.values()]),
            **self.one_lane(),
        )  # fmt: skip

    def one_lane(self) -> dict[str, str]:
        """Of the march of one lane, two steps at once: E x + (1 + D) B f_0 + B f_1."""
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
            "one": "\n".join([place_lines(one, 2), self.step(2, place=False), place_lines(self.stored("x", "i"), 2)]),
        }

    def stored(self, x: str, step: str) -> list[str]:
        """Lines that write u, v, a of a step, x being the name of its state."""
        scaled = (f"{self.scales[name]} * {name}" if name in self.scales else name for name in self.reported)
        return [f"out[{step}, {k}] = {e.replace('x', x)}" for k, e in enumerate(scaled)]


def nested(terms: Iterable[str]) -> str:
    """a*b + (c*d + e): one multiply-add each, the first added last."""
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
