"""Declarations -> text of the index, from which the runtime knows the schemes without numba or SymPy."""

from collections.abc import Iterable

from sympy import Expr, Float, Poly, Pow, Symbol, factor, fraction, together

from ..declare.catalogue import as_member
from ..declare.errors import DeclarationError
from ..declare.parameter import Family, Parameter, Root
from ..declare.scheme import Scheme
from ..declare.symbols import kind_of, state_label, steps_back
from ..step.step import Step
from .printing import KERNEL_PRINTER, fill, literal_tuple, with_banner
from .templates.scheme import INDEX


def index_module(schemes: Iterable[tuple[Scheme, int]]) -> str:
    """Text of generated/substep_kernels/index.py: names, parameters, families and members, without numba.

    schemes: each with the number of load instants of a step.
    """
    lines = ["{"]
    for scheme, loads in schemes:
        described = index_entry(scheme, loads)
        lines += [f'    "{scheme.name}": {{', *(f"        {line}" for line in described), "    },"]
    body = "\n".join([*lines, "}"])
    text = fill(INDEX, imports=numpy_for(body), schemes=body)
    return with_banner("substep_derive.declare.schemes", text)


def index_entry(scheme: Scheme, loads: int, *, own: bool = False) -> list[str]:
    """Lines of one scheme's entry; loads: load instants of a step; own: it is the user's scheme."""
    described = {
        "module": repr(f"schemes.{scheme.parent or scheme.name}"),
        "parameters": literal_tuple(_parameter(scheme, k) for k in range(len(scheme.parameters))),
        "balances": repr(len(scheme.balances)),
        "loads": repr(loads),
        "state": repr(tuple(state_label(s) for s in scheme.state)),
        "history": repr(tuple((kind_of(s), int(steps_back(s))) for s in scheme.state)),
        "reference": repr(scheme.reference),
    }
    if scheme.families:
        described["families"] = "{" + ", ".join(_family(family) for family in scheme.families) + "}"
    if scheme.fixed:
        described["fixed"] = repr({name: float(value) for name, value in scheme.fixed.items()})
    if scheme.start_scheme is not None:
        described |= {"start": "'scheme'", "starter": repr(_starter(scheme, scheme.start_scheme, own))}
    elif scheme.start:
        described["start"] = "'function'"
    if scheme.decided:
        described["decided"] = "{" + ", ".join(_decided(s, *by) for s, by in scheme.decided.items()) + "}"
    described |= {"synonyms": repr(scheme.synonyms)} if scheme.synonyms else {}
    described |= {} if scheme.takes_damping else {"damping": "False"}
    described |= {} if all(stage.alone for stage in Step.of(scheme).stages) else {"together": "True"}
    return [f'"{key}": {text},' for key, text in described.items()]


def _starter(scheme: Scheme, start: Scheme, own: bool) -> tuple[str, dict[str, float]]:
    """Name and parameters of the scheme that marches the first steps; an empty name if it is not in the catalogue.

    Raises DeclarationError for a scheme of the catalogue that is started by one outside of it.
    """
    found = as_member(start)
    if found is None and not own:
        raise DeclarationError(
            f"{scheme.name}: expected the scheme that starts it in the catalogue, got {start.name} "
            "outside of it; add it to a file of declarations and to its ALL"
        )
    return ("", {}) if found is None else (found[0], {key: float(value) for key, value in found[1].items()})


def numpy_for(text: str) -> str:
    """The line that imports NumPy, if the text calls one of its functions."""
    return "\nimport numpy as np\n" if "np." in text else ""


def domain_text(parameter: Parameter) -> str:
    """Text of low, high (None: unbounded), low excluded, high excluded."""
    domain = parameter.domain
    low, high = (float(end) if end.is_finite else None for end in (domain.start, domain.end))
    return f"{low}, {high}, {bool(domain.left_open)}, {bool(domain.right_open)}"


def _parameter(scheme: Scheme, k: int) -> str:
    """Text of (name, domain..., default as a function of earlier parameters); for a `Root`, its polynomial."""
    parameter, earlier = scheme.parameters[k], ", ".join(p.name for p in scheme.parameters[:k])
    default = parameter.default
    function = f"lambda {earlier}: ".replace("lambda :", "lambda:")
    if not isinstance(default, Root):
        return f'("{parameter.name}", {domain_text(parameter)}, {function}{number(default)})'
    polynomial = Poly(fraction(together(default.equation))[0], parameter.symbol)
    coefficients = literal_tuple(number(factor(c)) for c in reversed(polynomial.all_coeffs()))
    return f'("{parameter.name}", {domain_text(parameter)}, None, {function}{coefficients})'


def _decided(symbol: Symbol, by: Symbol, value: Expr) -> str:
    """Text of a parameter that another one decides where it is given, and how."""
    return f'"{symbol.name}": ("{by.name}", lambda {by.name}: {number(value)})'


def _family(family: Family) -> str:
    argument = family.argument
    values = ", ".join(f'"{s.name}": lambda {argument.name}: {number(e)}' for s, e in family.values.items())
    return f'"{argument.name}": ({domain_text(argument)}, {{{values}}})'


def number(expression: Expr) -> str:
    """Text of the expression with numbers as floats, and sqrt as a power, which arrays have too."""
    roots = expression.replace(lambda e: e.is_Pow and not e.exp.is_Integer, lambda e: Pow(e.base, Float(e.exp)))
    return repr(float(expression)) if expression.is_number else KERNEL_PRINTER.doprint(roots)
