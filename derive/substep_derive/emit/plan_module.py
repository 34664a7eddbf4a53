"""Plan -> text of the module that says what a step computes on a structure: plain data, evaluated once a run."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from sympy import Expr

from ..declare.digest import scheme_digest
from ..declare.names import python_name
from ..declare.scheme import Scheme
from ..declare.symbols import h
from ..kernels.reactions import holds, why_no_contact
from ..motion.plan import Combination, Operation, Plan, Row, System
from .printing import KERNEL_PRINTER, docstring, fill, literal_tuple
from .templates.plan import PLAN_FUNCTION, PLAN_HEADER
from .templates.scheme import BANNER


def plan_module(scheme: Scheme, source: str) -> str:
    """Text of a scheme's plan. Raises DeclarationError for coefficients that a plan has no systems for."""
    inside = scheme.in_kernels
    plan, start = Plan.of(inside), Plan.of_start(inside)
    reasons = [why_no_contact(scheme, **asked) for asked in ({}, {"restitution": True}, {"friction": True})]
    if all(reasons):
        rows = int(holds(scheme))
        plan = replace(plan, operations=tuple(_of_constraints(o, rows) for o in plan.operations))
    arguments = ", ".join([h.name, *(s.name for s in inside.values)])
    text = fill(BANNER, source=source, digest=scheme_digest(scheme)) + fill(
        PLAN_HEADER,
        name=scheme.name,
        equations=docstring(equations(Plan.of(scheme))),
        parameters=literal_tuple(repr(s.name) for s in scheme.values),
        state=literal_tuple(repr(python_name(s)) for s in plan.given),
        no_memory=repr(plan.no_memory),
        no_contact=repr(reasons[0]),
        no_restitution=repr(reasons[1]),
        no_friction=repr(reasons[2]),
    )
    text += _function("step", "A step from t_n to t_n + h.", arguments, plan)
    if start is not None:
        text += _function("start", "The state at t = 0 from u_0, v_0, a_0.", arguments, start)
    return text


def _of_constraints(o: Operation, rows: int) -> Operation:
    """The operation of a scheme that takes no contacts and no frictions; rows: 1 if it takes constraints, else 0."""
    return replace(o, contact=None, held=(o.held or ())[:rows] or None) if isinstance(o, System) else o


def equations(plan: Plan) -> str:
    """The systems of a step as a paper writes them."""
    return "\n".join(f"    {o.vector}: {equation(o)}" for o in plan.operations if isinstance(o, System))


def equation(system: System) -> str:
    """One of them."""
    left = [f"{name}*({_sum(row)})" for name, row in system.rows.items() if row]
    left += [_term(w, f"N({_sum(row)})") for w, row, _ in system.forces]
    left += [_term(w, f"N_discrete({_sum(old)}, {_sum(new)})") for w, old, new in system.differences]
    right = [_term(w, f"f({tau})") for w, tau in system.loads]
    return f"{' + '.join(left)} = {' + '.join(right) or 0}"


def _sum(row: Row) -> str:
    return " + ".join(_term(e, str(s)) for s, e in row.items())


def _term(w: Expr, what: str) -> str:
    return what if w == 1 else f"({w})*{what}"


def _function(name: str, doc: str, arguments: str, plan: Plan) -> str:
    operations = []
    for o in plan.operations:
        if isinstance(o, Combination):
            operations.append(f'("combine", "{python_name(o.vector)}", {_row(o.row)}),')
        else:
            operations.append(f'("solve", "{python_name(o.vector)}", {{')
            operations += [f'    "{slot}": {text},' for slot, text in _slots(o)]
            operations.append("}),")
    return fill(
        PLAN_FUNCTION,
        name=name,
        doc=doc,
        arguments=arguments,
        operations=_several("[]", operations),
        out=_several("{}", _rows({python_name(s): row for s, row in plan.out.items()})),
        report=_several("{}", _rows(plan.report)),
    )


def _several(brackets: str, lines: Sequence[str]) -> str:
    """The lines between brackets, indented."""
    inner = "".join(f"\n        {line}" for line in lines) + "\n    " if lines else ""
    return brackets[0] + inner + brackets[1]


def _slots(system: System) -> list[tuple[str, str]]:
    """Name and text of every slot that is not empty."""
    slots = [(name, _row(row)) for name, row in system.rows.items() if row]
    slots += _pairs("N", [(w, f"{_row(row)}, {_number(tau)}") for w, row, tau in system.forces])
    slots += _pairs("N_discrete", [(w, f"{_row(old)}, {_row(new)}") for w, old, new in system.differences])
    slots += (
        [("commit", "[" + ", ".join(f"({_row(u)}, {_row(v)}, {_number(tau)})" for u, v, tau in commits) + "]")]
        if (commits := system.commits)
        else []
    )
    if system.contact is not None:
        u, v, *numbers = system.contact
        slots.append(("contact", f"({_row(u)}, {_row(v)}, {', '.join(map(_number, numbers))})"))
    if system.held is not None:
        slots.append(("held", f"[{', '.join(map(_row, system.held))}]"))
    return slots + _pairs("f", [(w, _number(tau)) for w, tau in system.loads])


def _pairs(name: str, pairs: Sequence[tuple[Expr, str]]) -> list[tuple[str, str]]:
    return [(name, "[" + ", ".join(f"({_number(w)}, {text})" for w, text in pairs) + "]")] if pairs else []


def _rows(rows: Mapping[str, Row]) -> list[str]:
    return [f'"{name}": {_row(row)},' for name, row in rows.items()]


def _row(row: Row) -> str:
    return "{" + ", ".join(f'"{python_name(s)}": {_number(e)}' for s, e in row.items()) + "}"


def _number(e: Expr) -> str:
    return KERNEL_PRINTER.doprint(e)
