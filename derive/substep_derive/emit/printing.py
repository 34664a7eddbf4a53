"""Small printing tools of the emitters."""

import hashlib
from collections.abc import Iterable, Mapping, Sequence
from string import Formatter
from textwrap import indent, wrap
from typing import Any

from sympy import Expr, Float, Rational, Symbol, count_ops
from sympy.printing.pycode import PythonCodePrinter

from ..algebra import rational
from ..declare.expressions import FUNCTIONS
from ..kernels.linear_system import first_of
from .templates.scheme import BANNER

WHOLE = 2**53  # whole numbers up to this one are doubles


class FractionPrinter(PythonCodePrinter):
    """Prints whole numbers and fractions of such that are too large for doubles as the doubles nearest to them."""

    def _print_Integer(self, expr: Any) -> str:
        return repr(float(expr)) if abs(expr.p) > WHOLE else super()._print_Integer(expr)

    def _print_Rational(self, expr: Any) -> str:
        return repr(float(expr)) if max(abs(expr.p), expr.q) > WHOLE else super()._print_Rational(expr)


class PointPrinter(FractionPrinter):
    """Prints -4*c*d - a*b for -a*b - 4*c*d, of which LLVM fuses one product at one point, and the other at several."""

    def _as_ordered_terms(self, expr: Any, order: Any = None) -> list[Expr]:
        terms = list(super()._as_ordered_terms(expr, order=order))
        (one, product), (factor, _) = (term.as_coeff_Mul() for term in terms[:2])
        return (
            terms if one != -1 or product.is_Symbol or factor in (-1, abs(factor)) else [terms[1], terms[0], *terms[2:]]
        )


class Code(str):
    """Text of Python that stands in a literal as it is, not as a string."""

    __slots__ = ()

    def __repr__(self) -> str:
        return str(self)


PRINTER = FractionPrinter({"fully_qualified_modules": False})

_NUMPY = (*FUNCTIONS, "sqrt")


class KernelPrinter(FractionPrinter):
    """Prints NumPy's functions, which give NaN where math's raise, and calls of the helpers of a scene's kernels.

    names: symbol -> its text, where that is not its name; terms are ordered by the symbols, not by these texts.
    """

    def __init__(self, names: Mapping[str, str] | None = None) -> None:
        functions = {name: f"np.{name}" for name in _NUMPY} | {"Abs": "abs"}
        super().__init__({"user_functions": functions})
        self.names = names or {}

    def _print_Symbol(self, expr: Any) -> str:
        return self.names.get(expr.name, expr.name)

    def _print_Infinity(self, expr: Any) -> Any:
        return "np.inf"

    def _print_Pow(self, expr: Any, rational: bool = False) -> str:
        return self._hprint_Pow(expr, rational=rational, sqrt="np.sqrt")

    def _print_Pi(self, expr: Any) -> str:
        return "np.pi"

    def _print_Exp1(self, expr: Any) -> str:
        return "np.e"

    def _helper(self, expr: Any) -> str:
        return f"_{type(expr).__name__}({', '.join(self._print(a) for a in expr.args)})"

    _print_log_cosh = _print_sinc = _print_sinc_slope = _print_first_of = _helper
    _print_phi_1 = _print_phi_2 = _print_bouc_wen = _print_bouc_wen_work = _print_bouc_wen_slope = _helper

    def _print_sign(self, expr: Any) -> str:
        return f"np.sign({self._print(expr.args[0])})"

    _print_sign_of = _print_sign

    def _print_absolute(self, expr: Any) -> str:
        return f"abs({self._print(expr.args[0])})"

    def _print_NaN(self, expr: Any) -> str:
        return "np.nan"

    def _print_signed_power(self, expr: Any) -> str:
        x, a = (self._print(e) for e in expr.args)
        return f"np.sign({x})*abs({x})**({a})"

    def _print_abs_power(self, expr: Any) -> str:
        x, a = (self._print(e) for e in expr.args)
        return f"max(abs({x}), 1e-30)**({a})"

    def _print_larger(self, expr: Any) -> str:
        return f"max({', '.join(map(self._print, expr.args))})"

    def _print_smaller(self, expr: Any) -> str:
        return f"min({', '.join(map(self._print, expr.args))})"

    def _print_where_at_least(self, expr: Any) -> str:
        a, b, x, y = (self._print(e) for e in expr.args)
        return f"({x} if {a} >= {b} else {y})"

    def _print_negative_part(self, expr: Any) -> str:
        return f"np.minimum({self._print(expr.args[0])}, 0.0)"

    def _print_is_negative(self, expr: Any) -> str:
        return f"1.0*({self._print(expr.args[0])} < 0.0)"

    def _print_Difference(self, expr: Any, suffix: str = "difference") -> str:
        return f"_{expr.args[0]}_{suffix}({self._print(expr.args[1])}, {self._print(expr.args[2])})"

    def _print_DifferenceSlope(self, expr: Any) -> str:
        return self._print_Difference(expr, "difference_slope")


KERNEL_PRINTER = KernelPrinter()


class ArrayPrinter(KernelPrinter):
    """Prints what chooses between branches for arrays."""

    def _print_larger(self, expr: Any) -> str:
        return f"np.maximum({', '.join(map(self._print, expr.args))})"

    def _print_smaller(self, expr: Any) -> str:
        return f"np.minimum({', '.join(map(self._print, expr.args))})"

    def _print_abs_power(self, expr: Any) -> str:
        x, a = (self._print(e) for e in expr.args)
        return f"np.maximum(abs({x}), 1e-30)**({a})"

    def _print_where_at_least(self, expr: Any) -> str:
        a, b, x, y = (self._print(e) for e in expr.args)
        return f"np.where({a} >= {b}, {x}, {y})"

    def _print_Piecewise(self, expr: Any) -> str:
        *cases, (last, _) = expr.args
        text = self._print(last)
        for value, condition in reversed(cases):
            text = f"np.where({self._print(condition)}, {self._print(value)}, {text})"
        return text

    def _print_And(self, expr: Any) -> str:
        return " & ".join(f"({self._print(e)})" for e in sorted(expr.args, key=str))

    def _print_Or(self, expr: Any) -> str:
        return " | ".join(f"({self._print(e)})" for e in sorted(expr.args, key=str))


def block(
    outputs: Sequence[tuple[Symbol | str, Expr]], depth: int = 1, printer: KernelPrinter = KERNEL_PRINTER
) -> tuple[str, int]:
    """Lines that assign common subexpressions and then the outputs, indented; and their operations."""
    subexpressions, expressions = rational.cse([e for _, e in outputs])
    assigned = [*subexpressions, *zip((name for name, _ in outputs), expressions, strict=True)]
    return lines(assigned, depth, printer), operations(assigned)


def lines(assigned: Iterable[tuple[Any, Expr]], depth: int = 1, printer: KernelPrinter = KERNEL_PRINTER) -> str:
    """One line an assignment, in the order given."""
    named = ((name if isinstance(name, str) else printer.doprint(name), e) for name, e in assigned)
    return placed((f"{name} = {printer.doprint(e)}" for name, e in named), depth)


def placed(texts: Iterable[str], depth: int) -> str:
    """Lines at that depth of indentation."""
    return indent("\n".join(texts), "    " * depth)


def operations(assigned: Iterable[tuple[Any, Expr]]) -> int:
    """Arithmetic operations and function calls of assignments as they are printed."""
    return sum(int(count_ops(e)) + sum(_of_elimination(int(a.args[1])) for a in e.atoms(first_of)) for _, e in assigned)


def _of_elimination(n: int) -> int:
    """Arithmetic operations of an elimination in loops of so many unknowns, if no entry is 0."""
    return n * (n - 1) * (4 * n + 13) // 6 + 2 * n


def fill(template: str, **fields: object) -> str:
    """str.format that raises KeyError also for fields which the template does not use."""
    wanted = {name for _, name, _, _ in Formatter().parse(template) if name}
    if wanted != set(fields):
        raise KeyError(f"template wants {sorted(wanted)}, got {sorted(fields)}")
    return template.format(**fields)


def with_banner(source: str, text: str) -> str:
    """The text of a module below a banner with its own digest; source: what it is generated from."""
    return fill(BANNER, source=source, digest=hashlib.sha256(text.encode()).hexdigest()) + text


def decimal(e: Expr) -> Expr:
    """The expression with 17 digits of fractions that are too long to be read, those near an irrational number."""
    long = {x: Float(x, 17) for x in e.atoms(Rational) if max(abs(x.p), x.q) > WHOLE}
    return e.xreplace(long)


def docstring(text: str) -> str:
    """The text escaped so that it can stand between three double quotes, whatever a declaration holds."""
    return text.replace("\\", "\\\\").replace('"""', '\\"\\"\\"')


def literal_tuple(items: Iterable[str]) -> str:
    """Text of a tuple whose items have these texts."""
    return "(" + "".join(f"{item}, " for item in items).rstrip() + ")"


def wrapped(names: Sequence[str]) -> str:
    """Text of the names as a tuple on one line, or between brackets on several."""
    rows = wrap(", ".join(names) + ("," if len(names) == 1 else ""), 100)
    return rows[0] if len(rows) == 1 else "(\n        " + "\n        ".join(rows) + "\n    )"
