"""Declarations -> text of the index, which tells the runtime what there is without numba or SymPy."""

import hashlib
from collections.abc import Iterable

from sympy import Expr, Float, Pow, fraction, together

from ..algebra import rational
from ..declare.parameter import Family, Parameter, Root
from ..declare.scheme import Scheme
from ..declare.symbols import knot_of, lattice, state_label
from ..kernels.march_form import MarchForm
from .printing import PRINTER, fill, literal_tuple
from .templates.scheme import BANNER, INDEX, ROOT


def index_module(forms: Iterable[MarchForm]) -> str:
    """Text of generated/substep_kernels/index.py: names, parameters, families and members, without numba."""
    roots: list[str] = []
    lines = ["{"]
    for form in forms:
        described = index_entry(form, roots)
        lines += [f'    "{form.scheme.name}": {{', *(f"        {line}" for line in described), "    },"]
    text = fill(INDEX, schemes="\n".join([*lines, "}"]), roots="".join(roots))
    checked = hashlib.sha256(text.encode()).hexdigest()
    return fill(BANNER, source="substep_derive.schemes", digest=checked) + text


def index_entry(form: MarchForm, roots: list[str]) -> list[str]:
    """Lines of one scheme's entry; functions for implicit defaults are added to roots."""
    scheme = form.scheme
    history = [knot_of(s) or ("", "0") for s in scheme.state]
    described = {
        "module": repr(scheme.parent or scheme.name),
        "parameters": literal_tuple(_parameter(scheme, k, roots) for k in range(len(scheme.parameters))),
        "families": "{" + ", ".join(_family(family) for family in scheme.families) + "}",
        "fixed": repr({name: float(value) for name, value in scheme.fixed.items()}),
        "balances": repr(len(scheme.balances)),
        "loads": repr(len(form.stencil)),
        "state": repr(tuple(state_label(s) for s in scheme.state)),
        "history": repr(tuple(("uva".index(kind), int(-(lattice(label) or 0))) for kind, label in history)),
        "start": repr(_start(scheme)),
        "reference": repr(scheme.reference),
    }
    return [f'"{key}": {text},' for key, text in described.items()]


def _start(scheme: Scheme) -> str:
    """ "given": u, h*v, h^2*a are the state; "start": the module's function; else a scheme that marches first."""
    if isinstance(scheme.start, Scheme):
        return scheme.start.name
    return "start" if scheme.start else "given"


def domain_text(parameter: Parameter) -> str:
    """low, high (None: unbounded), low excluded, high excluded."""
    domain = parameter.domain
    low, high = (float(end) if end.is_finite else None for end in (domain.start, domain.end))
    return f"{low}, {high}, {bool(domain.left_open)}, {bool(domain.right_open)}"


def _parameter(scheme: Scheme, k: int, roots: list[str]) -> str:
    """(name, domain..., default as a function of the parameters before it)."""
    parameter, earlier = scheme.parameters[k], ", ".join(p.name for p in scheme.parameters[:k])
    default = parameter.default
    if isinstance(default, Root):
        name = f"_{scheme.name}_{parameter.name}"
        equation = fraction(together(default.equation))[0]
        printed = (
            PRINTER.doprint(rational.horner(e, parameter.symbol)) for e in (equation, equation.diff(parameter.symbol))
        )
        roots.append(
            fill(
                ROOT,
                name=name,
                arguments=earlier,
                unknown=parameter.name,
                start=float((parameter.domain.start + parameter.domain.end) / 2),
                **dict(zip(("equation", "slope"), printed, strict=True)),
            )
        )
        text = name
    else:
        text = f"lambda {earlier}: {number(default)}".replace("lambda :", "lambda:")
    return f'("{parameter.name}", {domain_text(parameter)}, {text})'


def _family(family: Family) -> str:
    argument = family.argument
    values = ", ".join(f'"{s.name}": lambda {argument.name}: {number(e)}' for s, e in family.values.items())
    return f'"{argument.name}": ({domain_text(argument)}, {{{values}}})'


def number(expression: Expr) -> str:
    """Text that evaluates to a float or an array: a number as a float, sqrt as a power."""
    roots = expression.replace(lambda e: e.is_Pow and not e.exp.is_Integer, lambda e: Pow(e.base, Float(e.exp)))
    return repr(float(expression)) if expression.is_number else PRINTER.doprint(roots)
