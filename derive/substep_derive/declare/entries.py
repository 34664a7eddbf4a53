"""Entries of tables that declare schemes: read exactly, checked, and given as numbers of one field."""

from collections.abc import Iterable, Sequence
from typing import Any

from sympy import Expr, Integer, Rational, Symbol, cancel, preorder_traversal

from ..algebra.algebraic import Field, generator
from ..algebra.constant import Constant, constant_of, reduced
from ..algebra.rational import RationalFunctions
from .checks import expression, is_rational
from .errors import DeclarationError
from .parameter import Parameter, Root

Row = Sequence[Any]
_LETTERS = "pqrstuvwxyz"
LABELS = tuple("z" * z + letter for z in range(4) for letter in _LETTERS[:-1])  # of knots, in alphabetical order


class Entries:
    """Reads the entries of a table of this name, and gives them as numbers of one field."""

    def __init__(self, name: str, parameters: Sequence[Parameter], tables: Iterable[Sequence[Row]] = ()) -> None:
        """tables: all that are read, of which the constant is known."""
        self.name = name
        self.symbols = {p.symbol for p in parameters}
        entries = [e for table in tables for row in table for e in row if isinstance(e, Expr)]
        try:
            self.values, self.field = _general(parameters, constant_of(entries))
        except ValueError as error:
            raise DeclarationError(f"{name}: {error}") from error

    @property
    def one(self) -> Any:
        """The field's 1."""
        return self.field.domain.one

    def numbers(self, rows: Sequence[Sequence[Expr]]) -> list[list[Any]]:
        """The entries as numbers of the field."""
        return [[self.field.number(e.subs(self.values, simultaneous=True)) for e in row] for row in rows]

    def vector(self, what: str, given: Row, length: int | None = None) -> list[Expr]:
        """Its entries. Raises DeclarationError for another length, or an entry that is not exact."""
        entries = list(given)
        if len(entries) > len(LABELS):
            raise DeclarationError(
                f"{self.name}: expected at most {len(LABELS)} stages or steps, got {len(entries)}; split the scheme"
            )
        if not entries or (length is not None and len(entries) != length):
            raise DeclarationError(
                f"{self.name}: expected {length or 'at least one'} entries in {what}, as in c, got {len(entries)}; "
                "a table has one for each stage"
            )
        return [self._entry(what, e) for e in entries]

    def square(self, what: str, given: Sequence[Row], size: int) -> list[list[Expr]]:
        """The square matrix. Raises DeclarationError for another shape; rows may end at the diagonal or beyond it."""
        rows = [[self._entry(what, e) for e in row] for row in given]
        if len(rows) != size or any(not i <= len(row) <= size for i, row in enumerate(rows)):
            shape = ", ".join(str(len(row)) for row in rows)
            raise DeclarationError(
                f"{self.name}: expected {size} rows in {what}, as many as c has entries, each of {size} entries or of "
                f"those up to the diagonal, got {len(rows)} rows of {shape or 'no'} entries; fill up with zeros"
            )
        return [[*row, *[Integer(0)] * (size - len(row))] for row in rows]

    def sums(self, what: str, rows: Sequence[Sequence[Expr]], expected: Sequence[Expr]) -> list[list[Expr]]:
        """The rows, so that each has the expected sum whatever the parameters are.

        Where it has that sum only at the root that a default is, an entry unlike the others is made the rest to it.

        Raises DeclarationError for a row whose sum is not the expected one.
        """
        evened: list[list[Expr]] = []
        for k, (row, total) in enumerate(zip(rows, expected, strict=True), start=1):
            found = sum(row, Integer(0))
            if self.numbers([[found - total]])[0][0]:
                raise DeclarationError(
                    f"{self.name}: expected {what.format(k=k)} to sum to {total}, got {cancel(found)}; correct them"
                )
            missing = cancel(total - found)
            by_rarity = sorted((list(row).count(e), j) for j, e in enumerate(row) if e != 0)
            rest = by_rarity[0][1] if by_rarity and missing != 0 else None
            evened.append([cancel(e + missing) if j == rest else e for j, e in enumerate(row)])
        return evened

    def _entry(self, what: str, value: Any) -> Expr:
        e = expression(f"{self.name}: {what}", value)
        if any(part.is_Float for part in e.atoms()):
            raise DeclarationError(
                f"{self.name}: expected exact entries in {what}, got the float {e}; write Rational(1, 4), or "
                "Fraction('0.25')"
            )
        if unknown := {s for s in e.free_symbols if not isinstance(s, Constant)} - self.symbols:
            raise DeclarationError(
                f"{self.name}: the entry {e} of {what} holds {', '.join(sorted(map(str, unknown)))}; declare "
                "parameters=(Parameter(...),)"
            )
        if not all(map(is_rational, preorder_traversal(e))):
            raise DeclarationError(
                f"{self.name}: expected entries of {what} that are rational in the parameters, got {e}; let an "
                "irrational number be the default Root(...) of a parameter, and all entries rational in that"
            )
        return reduced(e)


def _general(
    parameters: Sequence[Parameter], constant: Constant | None
) -> tuple[dict[Symbol, Expr], Field | RationalFunctions]:
    """Values in no special relation for parameters, the exact root for an implicit one; and the field of them all."""
    if constant is None and not any(isinstance(p.default, Root) for p in parameters):
        return {}, RationalFunctions([p.symbol for p in parameters])
    values: dict[Symbol, Expr] = {} if constant is None else {constant: generator}
    found = None if constant is None else constant.number
    for i, p in enumerate(parameters):
        if not isinstance(p.default, Root):
            values[p.symbol] = p.inside(Rational(31 + 7 * i, 97 + 12 * i))
            continue
        root = p.root(values)
        if isinstance(root, Rational):
            values[p.symbol] = root
        elif found is not None:
            raise DeclarationError(
                f"a table holds two irrational numbers, {found} and {root}; let one number be the default Root(...) of "
                "a parameter, and write the other as a rational function of it"
            )
        else:
            found, values[p.symbol] = root, generator
    return values, Field(found)
