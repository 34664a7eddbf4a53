"""EstimatedBody -> the names of what a lane of its march holds, and the lines that compute an acceleration of these."""

from collections.abc import Iterable

from sympy import Expr, Symbol

from ..estimate.held import END
from ..kernels.estimated_body import EstimatedBody
from ..kernels.local_error import weight_names
from .printing import KERNEL_PRINTER, KernelPrinter, block, placed

# what is asked of a run: names of the kernel, after the parameters and the weights
ASKED = (
    *("tolerance", "power", "rtol", "atol_u", "atol_v", "share_v", "length", "dt_first", "dt_min", "dt_max"),
    *("t_begin", "t_end", "bound", "rung"),
)


class LaneNames:
    """Names of what a lane holds at the start of a run and at both ends of a step.

    scalars: names of a lane's numbers. d: places of the coordinates. start, old: names of u, v, a at the start of a run
    and of a step; ends: of u, v and, where the scheme has its own, a at the end of a step. end_a: names of a at the end
    from the equation of motion.
    """

    def __init__(self, p: EstimatedBody) -> None:
        self.p, self.body, self.w = p, p.body, KERNEL_PRINTER
        parameters, weights = self.body.parameters(p.expressions), weight_names(p.terms)
        self.scalars = [*(s.name for s in (*parameters, *weights)), *ASKED]
        self.numbers = placed((f"{name} = numbers[{k}]" for k, name in enumerate(self.scalars)), 1)
        self.d = range(len(self.body.motion.coordinates))
        self.start, self.old = self._rows("start[{}, {}]"), self._rows("old_{}_{}")
        self.ends = [[self.w.doprint(e) for e in vector] for vector in self.body.report]
        self.end_a = self.body.components(END.a)
        self.old_back = [(f"here[{k}, {i}]", name) for k, row in enumerate(self.old) for i, name in enumerate(row)]
        self.rows = 3 + self.body.rows_of_memory  # of here, start and out: u, v, a, and what laws remember
        self.memory = [[s.name for s in names] for names in zip(*self.body.memory, strict=True)] or [[], []]
        self.remembered_at = [place for _, place in self.body.laid(self.memory[0], 3)]
        u_0 = zip(self.body.components("u_0"), self.start[0], strict=True)
        self.initial = placed((f"{name} = {place}" for name, place in u_0), 1)

    def _rows(self, text: str) -> list[list[str]]:
        """Texts of the components of u, v, a."""
        return [[text.format(k, i) for i in self.d] for k in range(3)]

    def acceleration(
        self, targets: Iterable[str], t: str, u: Iterable[str], v: Iterable[str], memory: Iterable[str] | None = None,
        load: str | None = None,
    ) -> str:  # fmt: skip
        """The line that computes it; memory: by default that at t_n; load: by default at t, if the scene takes one."""
        found = self.p.of_acceleration
        if load is None:
            load = f"_load(load, samples, middle, {t})" if any(e.has(Symbol("load")) for e in found) else "0.0"
        given = (self.w.doprint(s) for s in self.body.parameters(found))
        remembered = self.memory[0] if memory is None else memory
        return f"{', '.join(targets)} = _acceleration({', '.join([*given, t, load, *u, *v, *remembered])})"

    def acceleration_at_end(self, targets: Iterable[str]) -> str:
        """The line that computes it at the end of a step."""
        return self.acceleration(targets, "end", self.ends[0], self.ends[1], self.memory[1])

    def at(self, expressions: Iterable[Expr], u: Iterable[str], v: Iterable[str]) -> list[str]:
        """Texts of expressions in u and v named without a knot, at others."""
        both = zip((*self.body.components("u_*now"), *self.body.components("v_*now")), (*u, *v), strict=True)
        return list(map(KernelPrinter(dict(both)).doprint, expressions))

    def committed(self, names: Iterable[str], u: Iterable[str], memory: Iterable[str]) -> list[str]:
        """Lines that commit what laws remember at u, `elapsed` after the memory given."""
        both = zip((*self.body.components("u_*now"), *self.memory[0]), (*u, *memory), strict=True)
        return block(list(zip(names, self.p.remembered, strict=True)), 0, KernelPrinter(dict(both)))[0].splitlines()
