"""Scheme -> one self-contained file in another language: a step, stability functions, and a test of itself.

A template holds what every scheme's file has in a language; here stands what is put into it, as text of that language.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache
from textwrap import wrap
from typing import Any

from substep_derive.algebra import rational
from substep_derive.declare.catalogue import find
from substep_derive.declare.digest import scheme_digest
from substep_derive.declare.errors import DeclarationError
from substep_derive.declare.parameter import Family, Parameter, Root
from substep_derive.declare.parameter_set import ParameterSet
from substep_derive.declare.scheme import Scheme
from substep_derive.declare.symbols import Omega, h, knot_of, lattice, state_label, t, xi
from substep_derive.emit.plan_module import equation
from substep_derive.emit.scheme_module import relations
from substep_derive.kernels.eigenvalue_defect import about_one
from substep_derive.kernels.exact_case import LOAD, OMEGA, STEPS, U0, V0, ExactCase, H, near_values
from substep_derive.kernels.exact_case import MASS as TEST_MASS
from substep_derive.kernels.kernel import Kernel, entries, polynomial_kernel
from substep_derive.kernels.scalar_step import DAMPING, MASS, STIFFNESS, ScalarBalance, ScalarStep
from substep_derive.kernels.stability_polynomials import live_coefficients
from substep_derive.motion.effective import effective_systems
from substep_derive.motion.plan import Plan
from substep_derive.oscillator.amplification import Amplification
from sympy import Expr, Float, Rational, Symbol, eye

from .languages import LANGUAGES, Language

Text = Callable[[Expr], str]


def standalone(scheme: str | Scheme, language: str, /, **parameters: Any) -> str:
    """The text of one file that needs nothing besides the language itself: see docs/emit.md.

    scheme: a name of the catalogue, or a declaration. language: a key of `LANGUAGES`. parameters: exact values, as
    `certify` takes them, which the file has as its defaults; the others keep their own.

    Raises ValueError for an unknown language, DeclarationError for an unknown scheme or parameter, a value outside its
    interval, and names that are not ASCII, which not every language has.
    """
    printed_in = language_of(language)
    declared = find(scheme)
    exact = ParameterSet.of(declared, None, parameters)
    return printed_in.file(_fields(declared, printed_in, exact, set(parameters)))


def language_of(name: str) -> Language:
    """The language of that name. Raises ValueError for one that is not there."""
    if name not in LANGUAGES:
        raise ValueError(f"expected a language out of {', '.join(LANGUAGES)}, got '{name}'; choose one of them")
    return LANGUAGES[name]


def _fields(scheme: Scheme, language: Language, parameters: ParameterSet, given: set[str]) -> dict[str, Any]:
    """Everything that a template refers to. given: names of the parameters that were not left to their default."""
    steps = _steps(scheme)
    kernels = stability_kernels(scheme)
    read = {s for step in steps.values() for b in step.balances for e in b.expressions for s in e.free_symbols}
    read |= {s for step in steps.values() for e in step.assigned for s in e.free_symbols}
    read |= {s for kernel in kernels for _, e in kernel.outputs for s in e.free_symbols}
    own = [p for p in scheme.parameters if p.symbol in read]
    vectors = {s for step in steps.values() for s in read | set(step.given) if knot_of(s) is not None}
    names = [s.name for s in {*vectors, *(p.symbol for p in own)}] + [f.argument.name for f in scheme.families]
    if strange := sorted(name for name in names if not name.isascii()):
        raise DeclarationError(
            f"{scheme.name}: expected names of ASCII letters, digits and underscores, got '{strange[0]}', which not "
            "every language has; rename it"
        )
    text = language.text(names)
    values = near_values(parameters)
    return {
        "name": scheme.name,
        "banner": [f"{language.comment} {line}".rstrip() for line in _banner(scheme, parameters)],
        **stability_fields(scheme, own, values, given, text),
        "damped": scheme.takes_damping,
        "discrete": any(b.system.differences for step in steps.values() for b in step.balances),
        "steps": [_step(name, step, own, text) for name, step in steps.items()],
        "state": [place(s) for s in scheme.state],
        "lag": lag(scheme),
        "test": _test(ExactCase.of(scheme, values), text),
    }


def stability_fields(
    scheme: Scheme, own: Sequence[Parameter], values: Mapping[Symbol, Rational], given: set[str], text: Text
) -> dict[str, Any]:
    """What the stability functions are printed from. own: the parameters that a program has, with their values."""
    return {
        "parameters": [_parameter(p, values[p.symbol], text) for p in own],
        "valid": [text(condition) for p in own for condition in _inside(p)],
        "families": [
            {
                "argument": text(f.argument.symbol),
                "interval": str(f.argument.domain),
                "values": [(text(s), text(e)) for s, e in found.items()],
            }
            for f in scheme.families
            if (found := _of_family(f, [p for p in own if p.name not in given]))
        ],
        "labels": [state_label(s) for s in scheme.state],
        **{kernel.name: _function(kernel, own, text) for kernel in stability_kernels(scheme)},
    }


@cache
def stability_kernels(scheme: Scheme) -> tuple[Kernel, Kernel]:
    """A - I, as `den` and numerators, and the polynomial in lambda - 1 of the live eigenvalues, lowest power first."""
    amplification = Amplification.of(scheme)
    arguments, step = (Omega, xi, *scheme.values), amplification.step
    increment = [("den", step.den), *entries("D_", step.N - step.den * eye(step.N.rows))]
    about = about_one(live_coefficients(amplification))
    return (
        polynomial_kernel("increment", arguments, increment, "Denominator and numerators of A - I."),
        polynomial_kernel("polynomial", arguments, [(f"b_{k}", e) for k, e in enumerate(about)], "In lambda - 1."),
    )


def _steps(scheme: Scheme) -> dict[str, ScalarStep]:
    """The step; where the state at t = 0 is not u_0, v_0, a_0, the start, or the step of the scheme that starts."""
    found = {"step": ScalarStep.of(Plan.of(scheme))}
    if (other := scheme.start_scheme) is not None:
        if other.start:
            raise DeclarationError(f"{scheme.name}: expected {other.name} to start from u_0, v_0, a_0; start otherwise")
        found["first_step"] = ScalarStep.of(Plan.of(other))
    elif (start := Plan.of_start(scheme)) is not None:
        found["start"] = ScalarStep.of(start)
    return found


def _banner(scheme: Scheme, parameters: ParameterSet) -> list[str]:
    lines = [
        f"{scheme.name}: {scheme.reference}" if scheme.reference else scheme.name,
        "",
        "Printed by `substep emit` from the scheme's declaration; change that and print again rather than this file.",
        f"Declaration digest: {scheme_digest(scheme)}",
        f"Parameters: {parameters.title}",
        "",
        *relations(scheme, effective_systems(scheme)),
    ]
    return [part for line in lines for part in wrap(line, 110, subsequent_indent=" " * 8) or [""]]


def _parameter(parameter: Parameter, value: Expr, text: Text) -> dict[str, str]:
    return {
        "name": text(parameter.symbol),
        "default": text(Float(value, 17)),
        "comment": f"in {parameter.domain}; by default {_default(parameter)}",
    }


def _default(parameter: Parameter) -> str:
    default = parameter.default
    return f"the root of {default.equation}" if isinstance(default, Root) else str(default)


def _inside(parameter: Parameter) -> list[Expr]:
    """Conditions that hold inside the interval, and not for NaN."""
    s, domain = parameter.symbol, parameter.domain
    low = [s > domain.start if domain.left_open else s >= domain.start] if domain.start.is_finite else []
    high = [s < domain.end if domain.right_open else s <= domain.end] if domain.end.is_finite else []
    return low + high


def _of_family(family: Family, free: Sequence[Parameter]) -> dict[Symbol, Expr]:
    """The parameters as functions of the family's argument, also those whose default reads them.

    Empty where one of the family's is not free, and where an implicit default reads one.
    """
    found: dict[Symbol, Expr] = dict(family.values)
    for p in free:
        if p.symbol not in found and p.default_symbols & found.keys():
            if isinstance(p.default, Root):
                return {}
            found[p.symbol] = p.default.subs(found)
    return found if found.keys() <= {p.symbol for p in free} else {}


def _step(name: str, step: ScalarStep, parameters: Sequence[Parameter], text: Text) -> dict[str, Any]:
    prefix = "" if name == "step" else f"{name}_"
    read = {s for b in step.balances for s in b.known} | {s for e in step.assigned for s in e.free_symbols}
    balances: dict[int, str] = {id(b): f"{prefix}balance_{k}" for k, b in enumerate(step.balances, start=1)}
    return {
        "name": name,
        "given": [(k, text(s)) for k, s in enumerate(step.given) if s in read],
        "parameters": _read(step.assigned, parameters, text),
        "operations": [
            {"balance": balances[id(o)], "unknown": text(o.unknown), "known": [text(s) for s in o.known]}
            if isinstance(o, ScalarBalance)
            else {"balance": "", "unknown": text(o[0]), "value": text(o[1])}
            for o in step.operations
        ],
        "balances": [_balance(balances[id(b)], b, parameters, text) for b in step.balances],
        "out": [text(e) for e in step.out],
        "report": [text(e) for e in step.report],
    }


def _balance(name: str, b: ScalarBalance, parameters: Sequence[Parameter], text: Text) -> dict[str, Any]:
    return {
        "name": name,
        "equation": equation(b.system),
        "unknown": text(b.unknown),
        "known": [text(s) for s in b.known],
        "parameters": _read(b.expressions, parameters, text),
        "matrices": [s.name for s in (MASS, DAMPING, STIFFNESS) if (b.residual + b.effective_mass).has(s)],
        "lines": [(text(s), text(e)) for s, e in b.lines],
        "forces": [
            {
                "value": text(f.value),
                "slope": text(f.slope) if f.slope else "",
                "at": text(f.displacement),
                "before": text(f.before) if f.before is not None else "",
            }
            for f in b.forces
        ],
        "loads": [(text(s), text(t + tau * h)) for s, tau in b.loads],
        "residual": text(b.residual),
        "effective_mass": text(b.effective_mass),
        "displacement": text(b.displacement) if b.displacement else "",
        "reach": text(b.reach),
    }


def _function(kernel: Kernel, parameters: Sequence[Parameter], text: Text) -> dict[str, Any]:
    subexpressions, expressions = rational.cse([e for _, e in kernel.outputs])
    names = [Symbol(name) for name, _ in kernel.outputs]
    return {
        "parameters": _read([e for _, e in kernel.outputs], parameters, text),
        "lines": [(text(s), text(e)) for s, e in subexpressions],
        "outputs": [(text(s), text(e)) for s, e in zip(names, expressions, strict=True)],
    }


def _read(expressions: Iterable[Expr], parameters: Sequence[Parameter], text: Text) -> list[str]:
    """The parameters that the expressions read."""
    found = {s for e in expressions for s in e.free_symbols}
    return [text(p.symbol) for p in parameters if p.symbol in found]


def place(symbol: Symbol) -> tuple[int, int]:
    """0, 1, 2 for u, v, a, and how many whole steps before t_n it stands."""
    kind, label = knot_of(symbol) or ("u", "0")
    return "uva".index(kind), -int(lattice(label) or 0)


def lag(scheme: Scheme) -> int:
    """How many steps another scheme marches first; 0 where none does."""
    return max(back for _, back in map(place, scheme.state)) if scheme.start_scheme else 0


def _test(case: ExactCase, text: Text) -> dict[str, Any]:
    def number(e: Expr) -> str:
        return text(Float(e, 17))

    numbers: Mapping[str, Expr | None] = {
        "spectral radius": case.radius,
        "numerical damping": case.numerical_damping,
        "period error": case.period_error,
    }
    return {
        "Omega": number(case.Omega),
        "xi": number(case.xi),
        "mass": number(TEST_MASS),
        "damping": number(2 * case.xi * OMEGA * TEST_MASS),
        "stiffness": number(TEST_MASS * OMEGA**2),
        "h": number(H),
        "u0": number(U0),
        "v0": number(V0),
        "steps": STEPS,
        "load": text(LOAD),
        "rows": [[number(x) for x in row] for row in case.rows],
        "matrix": [[number(x) for x in row] for row in case.amplification.tolist()],
        "spectrum": [number(e) if e is not None else "" for e in numbers.values()],
    }
