"""EstimatedBody -> text of a module that marches one scheme on one scene in steps of chosen length."""

from dataclasses import replace
from textwrap import wrap
from typing import Any

from sympy import Integer, Symbol

from ..declare.symbols import knot
from ..estimate.held import END, HALVED, START
from ..kernels.balance_step import Part
from ..kernels.estimated_body import EstimatedBody
from ..kernels.local_error import Terms, combined
from .error_size import size_of_errors
from .first_length import first_length
from .gpu_thread import on_device
from .lane_names import LaneNames
from .one_lane import ONE_LANE, opened
from .pair_module import helpers
from .printing import KernelPrinter, block, docstring, fill, lines, literal_tuple, operations, placed
from .step_text import TOL, part_text, rooms, step_text
from .templates.adaptive import (
    ACCELERATION,
    ADAPTED,
    ADAPTIVE_HEADER,
    ADAPTIVE_LANE,
    ADAPTIVE_MARCH,
    ADAPTIVE_THREADS,
    AGAIN,
    DENSE,
    HALVES,
    IMPORTS,
    IMPORTS_OF_DEVICE,
    JUMP,
    RESTART,
    UNEVEN,
)
from .templates.decorators import COMPILE_AND_INNER
from .templates.pair import COUNT
from .templates.step_control import STEP_CONTROL
from .templates.thread import COMPILE_THREADS

# what `_halved` is given besides the length and the state
HALVES_GIVEN = ("numbers", "start", "t", "load", "samples", "middle")


def adaptive_module(p: EstimatedBody, banner: str) -> str:
    """Text of the module."""
    header, text, to = _parts(p, IMPORTS)
    march = fill(ADAPTIVE_MARCH, rows=to.rows, d=len(to.d))
    return "".join([banner, header, COMPILE_AND_INNER, text, march])


def adaptive_threads(p: EstimatedBody, banner: str) -> str:
    """Text of the module that marches lanes in the threads of a GPU."""
    header, text, _ = _parts(p, IMPORTS_OF_DEVICE)
    return "".join([banner, header, COMPILE_THREADS, on_device(text), ADAPTIVE_THREADS])


def _parts(p: EstimatedBody, imports: str) -> "tuple[str, str, _Writer]":
    """Text of the module's head, and of the functions that march one lane; and their writer."""
    to, body = _Writer(p), p.body
    lane, counts = to.lane()
    text = "".join([to.accelerations(), to.first(), to.halved(), lane])
    header = fill(
        ADAPTIVE_HEADER,
        imports=imports,
        scheme=body.scheme.name,
        scene=body.motion.scene.name,
        errors=docstring(_errors(p.terms)),
        scalars=literal_tuple(f'"{name}"' for name in to.scalars),
        balances=len(body.scheme.balances),
        rung=repr(2**0.5 if p.refactored else 0.0),
        change=f"{sum(operations([a]) for a in p.changing) / max(counts['step'], 1):.3g}",
        state=body.rows + len(p.kept),
        degree=p.between.degree,
        operations=counts,
    )
    return header, "".join([STEP_CONTROL, *helpers(text, body), text]), to


def _errors(terms: Terms) -> str:
    """Lines that say what is estimated."""
    rows = ["Estimated local errors, numerical - exact; the weights are numbers of each lane:"]
    kinds = "u", "v", "v, by the acceleration at the end"
    rows += [f"    of {kind}: {e}" for kind, e in zip(kinds, combined(terms), strict=False)]
    return "\n".join(line for row in rows for line in wrap(row, 110, subsequent_indent=" " * 8))


class _Writer(LaneNames):
    """Writes the functions of the module."""

    def accelerations(self) -> str:
        """Text of `_acceleration`."""
        p, given = self.p, self.body.parameters(self.p.of_acceleration)
        outputs = [(f"value_{i}", e) for i, e in enumerate(p.acceleration)]
        before = [part_text(part, 1, self.w)[0] for part in p.accelerating if part.assignments]
        made = [line for part in p.accelerating for line in rooms(part.assignments)]
        names = [*(self.w.doprint(s) for s in given), "t", "load"]
        names += [name for kind in "uv" for name in self.body.components(f"{kind}_*now")] + self.memory[0]
        return fill(
            ACCELERATION,
            arguments=", ".join(names),
            body=opened(made, "\n".join([*before, block(outputs, 1, self.w)[0]])),
            value=", ".join(name for name, _ in outputs),
        )

    def first(self) -> str:
        """Text of `_first`."""
        memory = [f"start[{place}]" for place in self.remembered_at]
        return first_length(
            self.numbers, self.start, lambda targets, u, v: self.acceleration(targets, "t", u, v, memory)
        )

    def halved(self) -> str:
        """Text of a function that makes two steps of h; none where no estimate needs it."""
        body = self.p.halved
        if body is None:
            return ""
        results = [self.w.doprint(e) for vector in body.report[:2] for e in vector]
        failed = replace(TOL, failed=f"return {', '.join(['np.nan'] * len(results))}")
        step = step_text(body, failed, ONE_LANE, [Part(body.closing)])
        given = [f"begin_{k}" for k in range(len(body.places))]
        return fill(
            HALVES,
            arguments=", ".join([*HALVES_GIVEN, "h", *given]),
            numbers=self.numbers,
            initial=self.initial,
            constants=opened(step.rooms, lines([*body.constants, *body.near], 1, self.w)),
            state=placed((f"{name} = {x}" for (name, _), x in zip(body.places, given, strict=True)), 1),
            steps=step.phases,
            reported=step.last,
            shift=lines(body.shift, 2, self.w),
            result=", ".join(results),
        )

    def lane(self) -> tuple[str, dict[str, Any]]:
        """Text of `_lane`, and operations of a step, the estimate included, and of each iteration."""
        p, body, w = self.p, self.body, self.w
        state = [(name, f"state[{place}]") for name, place in (*body.places, *body.places_of(p.kept, body.rows))]
        step = step_text(body, TOL, ONE_LANE, self._results())
        size, weighing = size_of_errors(self)
        return fill(
            ADAPTIVE_LANE,
            numbers=self.numbers,
            initial=self.initial,
            once=opened(step.rooms, lines(p.once, 1, w)),
            begin=self._begin(),
            read_state=placed((f"{name} = {place}" for name, place in state), 1),
            changing=lines(p.changing, 3, w),
            no_step="    at_h, at_last = np.nan, np.nan\n" if p.uneven else "",
            adapted=self._adapted(),
            uneven=fill(UNEVEN, uneven=lines(p.uneven, 3, w)) if p.uneven else "",
            steps=step.phases,
            reported=step.last,
            size=size,
            sum=" + ".join(body.finite),
            count="".join(fill(COUNT, balance=k, row="row") for k in body.iterated),
            dense=self._dense(),
            remember=self._remember(),
            shift=self._shift(),
            jump=self._jump(),
            measured="last == last" if any(p.by_before) else "True",
            restart=self._restart(),
            first_old=placed((f"{name} = {at}" for at, name in self.old_back), 1),
            old_back=self._old_back(1),
            extremes=placed(
                (
                    f"extremes[{k}, {i}] = max(extremes[{k}, {i}], abs({name}))"
                    for k, row in enumerate(self.old)
                    for i, name in enumerate(row)
                ),
                3,
            ),
            store=placed((f"out[row, {place[5:-1]}] = {name}" for place, name in self._here), 3),
            write_state=placed((f"{place} = {name}" for name, place in state), 1),
        ), {**step.operations, "step": step.operations["step"] + weighing}

    @property
    def _here(self) -> list[tuple[str, str]]:
        """The places of u, v, a and what laws remember in `here`, and the names that hold them after a step."""
        return [
            *self.old_back,
            *((f"here[{at}]", name) for at, name in zip(self.remembered_at, self.memory[0], strict=True)),
        ]

    def _old_back(self, depth: int) -> str:
        return placed((f"{at} = {name}" for at, name in self._here), depth)

    def _results(self) -> list[Part | str]:
        """What is reported, its energy and the estimated errors."""
        p, body = self.p, self.body
        errors = [*p.error_u, *p.error_v, *(p.error_end if p.always else [])]
        between: list[str] = []
        if p.end_is_estimated:
            between += [self.acceleration_at_end(self.end_a)]
        if p.halved is not None:
            names = [name for s in HALVED[:2] for name in body.components(s)]
            state = [name for name, _ in body.places]
            between += [f"{', '.join(names)} = _halved({', '.join([*HALVES_GIVEN, '0.5 * h', *state])})"]
        closing, energy = body.results
        filters = [Part(body.filters, named=False)] if body.filters else []
        apart = [energy, *between, *filters, Part(errors)]
        together = apart if between or filters else [Part([*energy.assignments, *errors])]
        return [closing, *together]

    def _begin(self) -> str:
        """Lines that take the state from the start."""
        places = enumerate(map(knot(0).index, self.body.scheme.state))
        rows = [f"_copy(start[{k} : {k + 1}], state[{j} : {j + 1}])" for j, k in places]
        memory = [f"start[{place}]" for place in self.remembered_at]
        places = self.body.laid(self.memory[0], len(rows))
        rows += [f"state[{at}] = {given}" for (_, at), given in zip(places, memory, strict=True)]
        for j, s in enumerate(self.p.kept, start=self.body.rows):
            if s == START.a:
                rows += [self.acceleration([f"state[{j}, {i}]" for i in self.d], "t_begin", *self.start[:2], memory)]
            else:
                rows += [f"state[{j}, {i}] = 0.0" for i in self.d]
        return placed(rows, 2)

    def _dense(self) -> str:
        """Lines that fill a row of the grid from the interpolant of the step."""
        p, before = self.p, list[str]()
        begin, end = self.old[2], self.ends[2] if p.own_acceleration else [f"now_{i}" for i in self.d]
        if not p.own_acceleration:
            begin = [f"then_{i}" for i in self.d]
            before = [self.acceleration(begin, "t", *self.old[:2]), self.acceleration_at_end(end)]
        old, new = (*self.old[:2], begin), (*self.ends[:2], end)
        rows = list[str]()
        for i in self.d:
            names = {s.name: row[i] for s, row in (*zip(knot(0), old, strict=True), *zip(knot(1), new, strict=True))}
            motion = [(f"out[place, {k}, {i}]", e) for k, e in enumerate((p.between.u, p.between.v, p.between.a))]
            rows += [block(motion, 4, KernelPrinter(names))[0]]
        if self.memory[0]:
            places = [f"out[place, {at}]" for at in self.remembered_at]
            u = [f"out[place, 0, {i}]" for i in self.d]
            rows += [placed(["elapsed = share * h", *self.committed(places, u, self.memory[0])], 4)]
        at_end = placed(
            [
                *(f"out[place, {k}, {i}] = {new[k][i]}" for k in range(3) for i in self.d),
                *(f"out[place, {at}] = {name}" for at, name in zip(self.remembered_at, self.memory[1], strict=True)),
            ],
            4,
        )
        filled = fill(DENSE, at_end=at_end, between="\n".join(rows))
        return "\n".join([*([placed(before, 3)] if before else []), filled])

    def _remember(self) -> str:
        """Lines that keep what was reached, for the scales of the next step, for rows and for the interpolant."""
        rows = [f"{old} = {new}" for k, end in enumerate(self.ends) for old, new in zip(self.old[k], end, strict=True)]
        rows += ["speed = fast"]
        if not self.p.own_acceleration and self.p.end_is_estimated:
            rows += [f"{old} = {name}" for old, name in zip(self.old[2], self.end_a, strict=True)]
        elif not self.p.own_acceleration:
            rows += [
                "if row < times.size or extremes.shape[0] > 0 or end >= t_end:",
                f"    {self.acceleration_at_end(self.old[2])}",
            ]
        return placed(rows, 2)

    def _adapted(self) -> str:
        """Lines that bring an acceleration which depends on the length of its step to that of the next."""
        if self.p.lag is None:
            return ""
        both = zip(*(self.body.components(s) for s in (knot(0).a, START.a)), strict=True)
        return fill(
            ADAPTED, lag=self.p.lag, rows=placed((f"{a} = {own} + ratio * ({a} - {own})" for a, own in both), 3)
        )

    def _shift(self) -> str:
        """Lines that keep what an estimate reads of this step in the next, and make its end the start of that."""
        rows = list[str]()
        for s, source in self.p.kept.items():
            names = self.body.components(s)
            if source == END.a and not self.p.end_is_estimated:
                rows += [self.acceleration_at_end(names)]
            else:
                found = self.body.components(source)
                rows += [f"{new} = {old}" for new, old in zip(names, found, strict=True)]
        return "\n".join(part for part in (placed(rows, 2), lines(self.body.shift, 2, self.w)) if part)

    def _jump(self) -> str:
        """Lines for a jump of the load at the end of a step: the acceleration jumps with it, by M^-1 of it."""
        if not self.body.loads:
            return ""
        carried = [s for s in (knot(0).a, START.a) if s in self.body.scheme.state or s in self.p.kept]
        rows = list[str]()
        if self.p.accelerating:  # which is linear in the load
            names = [[f"{name}_{i}" for i in self.d] for name in ("loaded", "unloaded")]
            for targets, load in zip(names, ("1.0", "0.0"), strict=True):
                rows.append(self.acceleration(targets, "t", *self.old[:2], load=load))
            slope = [(Integer(1), f"({one} - {other})") for one, other in zip(*names, strict=True)]
        else:
            of_load = self.p.acceleration.diff(Symbol("load"))
            slope = [(e, text) for e, text in zip(of_load, self.at(of_load, *self.old[:2]), strict=True)]
        for names in (*map(self.body.components, carried), self.old[2]):
            rows += [f"{name} += {text} * jump" for name, (e, text) in zip(names, slope, strict=True) if e != 0]
        return fill(JUMP, jumps=placed(rows, 4))

    def _restart(self) -> str:
        """Lines for a break point of the load, behind which the step before does not help to estimate an error."""
        if not any(self.p.by_before):
            return ""
        return fill(RESTART, again=fill(AGAIN, old_back=self._old_back(3)) if self.p.by_before[0] else "")
