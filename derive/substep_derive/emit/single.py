"""Text of a module of kernels -> the same text in single precision, which has twice the lanes in a vector register.

numba computes float32 with a float64, or with a whole number, in float64. So every number in the text becomes single,
and so does what is whole where it meets what is not. What is whole by itself, as an index or a count, stays as it is.
The lines by which a block computes once what its lanes need of their parameters stay in double precision, and are
rounded where they are stored.
"""

import ast
import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

EPS = 2.0**29  # the rounding of single precision over that of double
ROUNDING = 1e-20, 1e-11  # numbers in the text between these are what rounding of double precision is compared with
# arguments that are whole numbers, or arrays of them, of functions that march
WHOLE = {
    "lane0", "lane1", "begin", "end", "n", "first", "stride", "start", "place", "at", "size", "i", "of_lane", "runs",
    "n_done", "status", "iterations", "newton", "common",
}  # fmt: skip
MARCHES = {"s", "rows", "values", "state", "f", "C", "system"}  # arguments, one of which each of these functions has
# counts over the lanes of a loop, of 32 bits: LLVM takes as many lanes at once as the widest of their numbers allow
COUNTS = {"left", "bad"}
WHOLE_OF = {"shape", "size", "data"}  # attributes of arrays
# a block begins where a register of 32 bytes is loaded at once
BYTES = {"room.ctypes.data >> 3": "room.ctypes.data >> 2", "data // 8": "data // 4"}
FOR_THE_COMPILER = {"intrinsic", "overload"}  # decorators of functions that compute nothing
IMPORTED = {"store"}  # functions whose numbers are those of their arrays, and whose other arguments are whole


def in_single(text: str) -> str:
    """The text with the same calls, with arrays of float64 too, but for loads, and C and x of a lane alone: float32.

    Numbers between those of ROUNDING are multiplied by EPS.
    """
    for double, single in BYTES.items():
        text = text.replace(double, single)
    tree = ast.parse(text)
    whole = {name for line in tree.body for name, _ in _assigned(line)}
    functions = [f for f in tree.body if isinstance(f, ast.FunctionDef)]
    given = {f.name: [x.arg for x in f.args.args] for f in functions}
    for f in functions:
        decorators = {x.id for d in f.decorator_list for x in ast.walk(d) if isinstance(x, ast.Name)}
        if not decorators & FOR_THE_COMPILER:
            _Single(f, whole, given).rewrite()
    after = 1 + max(k for k, line in enumerate(tree.body) if isinstance(line, ast.ImportFrom))
    tree.body[after:after] = ast.parse("from numpy import float32 as _f").body
    return ast.unparse(ast.fix_missing_locations(tree)) + "\n"


def _assigned(line: ast.AST) -> Iterator[tuple[str, ast.expr]]:
    """Names that a line gives a value, each with that."""
    match line:
        case ast.Assign(targets=targets, value=value):
            pairs = [(target, value) for target in targets]
        case ast.AugAssign(target=target, op=op, value=value):
            pairs = [(target, ast.BinOp(target, op, value))]
        case ast.For(target=target, iter=value):
            pairs = [(target, value)]
        case _:
            pairs = []
    for target, value in pairs:
        if isinstance(target, ast.Name):
            yield target.id, value
        elif isinstance(target, ast.Tuple):
            own = value.elts if isinstance(value, ast.Tuple) else [value] * len(target.elts)
            yield from ((t.id, v) for t, v in zip(target.elts, own, strict=True) if isinstance(t, ast.Name))


def _number(e: ast.AST) -> float | None:
    """The value of an expression of numbers alone, None for any other."""
    inside = list(ast.walk(e))
    names = {x.id for x in inside if isinstance(x, ast.Name)}
    functions = {x.attr for x in inside if isinstance(x, ast.Attribute)}
    if names - {"np", "math"} or functions - set(dir(math)) or not isinstance(e, ast.expr):
        return None
    if not functions and not any(isinstance(x, ast.Constant) for x in inside):
        return None
    value: Any = eval(ast.unparse(e), {"np": math, "math": math})
    return float(value) if isinstance(value, int | float) else None


def _f(e: ast.expr) -> ast.expr:
    return ast.Call(ast.Name("_f"), [e], [])


def _i(e: ast.expr) -> ast.expr:
    if isinstance(e, ast.IfExp):
        return ast.IfExp(e.test, _i(e.body), _i(e.orelse))
    return ast.Call(ast.Attribute(ast.Name("np"), "int32"), [e], [])


class _Single(ast.NodeTransformer):
    """Rewrites one function. whole: names of whole numbers of the module; given: arguments of its functions by name."""

    def __init__(self, function: ast.FunctionDef, whole: set[str], given: Mapping[str, Sequence[str]]) -> None:
        self.function, self.given, own = function, given, set(given[function.name])
        pairs = [pair for x in ast.walk(function) for pair in _assigned(x)]
        local = {name for name, _ in pairs} - own
        self.whole = (whole - own) | local | self.whole_of(function.name)
        while single := {name for name, value in pairs if name in self.whole & local and not self.is_whole(value)}:
            self.whole -= single
        returned = [x.value for x in ast.walk(function) if isinstance(x, ast.Return)]
        self.returns_whole = all(map(self.is_whole, returned))

    def whole_of(self, function: str) -> set[str]:
        """The arguments of a function that are whole."""
        own = set(self.given[function])
        return WHOLE & own if MARCHES & own else set()

    def rewrite(self) -> None:
        """Change the function in place, but for the second loop of a block, over what its lanes need."""
        loops = [line for line in self.function.body if isinstance(line, ast.For)]
        once = loops[1] if self.function.name == "_block" and len(loops) > 1 else None
        other = _Parameters(self.given[self.function.name])
        self.function.body = [other.visit(x) if x is once else self.visit(x) for x in self.function.body]

    def is_whole(self, e: ast.expr | None) -> bool:  # noqa: PLR0911 (a line for each kind)
        """Whether an expression is whole, or logical, or none."""
        match e:
            case ast.Constant(value=value):
                return not isinstance(value, float)
            case ast.Name(id=name):
                return name in self.whole
            case ast.Attribute(attr=name):
                return name in WHOLE_OF
            case ast.Subscript(value=value) | ast.UnaryOp(operand=value):
                return self.is_whole(value)
            case ast.BinOp(left=left, op=op, right=right):
                return not isinstance(op, ast.Div) and self.is_whole(left) and self.is_whole(right)
            case ast.IfExp(body=body, orelse=other):
                return self.is_whole(body) and self.is_whole(other)
            case ast.Tuple(elts=elements) | ast.Call(func=ast.Name(id="max" | "min" | "abs"), args=elements):
                return all(map(self.is_whole, elements))
            case ast.Call(func=ast.Attribute(attr="max" | "min", value=value)):
                return self.is_whole(value)
            case ast.Call(func=ast.Name(id=name)):
                return name in {"range", "int", "_leave", *IMPORTED}
            case (
                ast.Call(func=ast.Attribute(attr="int32" | "grid"))
                | ast.Call(keywords=[ast.keyword(arg="dtype")])
                | ast.Compare()
                | ast.BoolOp()
                | None
            ):
                return True
            case _:
                return False

    def single(self, e: ast.expr) -> ast.expr:
        """An expression rewritten, and single where it was whole."""
        if isinstance(e, ast.Tuple):
            return ast.Tuple([self.single(x) for x in e.elts])
        logical = isinstance(e, ast.Compare | ast.BoolOp) or (isinstance(e, ast.UnaryOp) and isinstance(e.op, ast.Not))
        return _f(e) if self.is_whole(e) and not logical else self.visit(e)

    def visit(self, node: ast.AST) -> Any:
        """A node rewritten; numbers alone, as 1/2, are computed here."""
        if isinstance(node, ast.expr) and not self.is_whole(node) and (number := _number(node)) is not None:
            alone = node.operand if isinstance(node, ast.UnaryOp) else node
            scale = EPS if isinstance(alone, ast.Constant) and ROUNDING[0] < abs(number) < ROUNDING[1] else 1.0
            return _f(ast.Constant(scale * number) if math.isfinite(number) else node)
        return super().visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> ast.expr:
        """A sum or product of what is whole and what is not."""
        if not self.is_whole(node):
            power = isinstance(node.op, ast.Pow) and self.is_whole(node.right)
            node.left, node.right = self.single(node.left), node.right if power else self.single(node.right)
        return node

    def visit_Compare(self, node: ast.Compare) -> ast.expr:
        """The same of a comparison."""
        if not all(map(self.is_whole, sides := [node.left, *node.comparators])):
            node.left, *node.comparators = map(self.single, sides)
        return node

    def visit_IfExp(self, node: ast.IfExp) -> ast.expr:
        """The same of a selection."""
        node.test = self.visit(node.test)
        if not self.is_whole(node):
            node.body, node.orelse = self.single(node.body), self.single(node.orelse)
        return node

    def visit_Call(self, node: ast.Call) -> ast.expr:
        """The same of arguments; new arrays are single."""
        match node.func:
            case ast.Attribute(attr="zeros" | "empty"):
                node.keywords = node.keywords or [ast.keyword("dtype", ast.Attribute(ast.Name("np"), "float32"))]
            case ast.Name(id=name) if name in self.given:
                whole = self.whole_of(name)
                node.args = [
                    x if parameter in whole else self.single(x) if _number(x) is not None else self.visit(x)
                    for parameter, x in zip(self.given[name], node.args, strict=True)
                ]
            case ast.Name() | ast.Attribute(value=ast.Name(id="np" | "math")) if not self.is_whole(node):
                node.args = [self.single(x) for x in node.args]
            case _:
                pass
        return node

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """A place in an array, which is whole."""
        node.value = self.visit(node.value)
        return node

    def visit_Return(self, node: ast.Return) -> ast.stmt:
        """The same of results; counts among several stay whole."""
        if isinstance(node.value, ast.Tuple):
            counts = [isinstance(x, ast.Name) and self.is_whole(x) for x in node.value.elts]
            node.value.elts = [x if c else self.single(x) for x, c in zip(node.value.elts, counts, strict=True)]
        elif node.value is not None:
            node.value = self.visit(node.value) if self.returns_whole else self.single(node.value)
        return node

    def visit_Assign(self, node: ast.Assign) -> ast.stmt:
        """The same of a name that is whole here and not elsewhere."""
        (target,), value = node.targets[:1], node.value
        if isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple):
            value.elts = [self._given(x, y) for x, y in zip(target.elts, value.elts, strict=True)]
        else:
            node.value = self._given(target, value)
        return node

    def _given(self, target: ast.expr, value: ast.expr) -> ast.expr:
        """A value as its target is: a count, whole, or single."""
        if isinstance(target, ast.Name) and target.id in COUNTS:
            return _i(value)
        whole_elsewhere = not isinstance(target, ast.Name) or target.id in self.whole
        return self.visit(value) if whole_elsewhere else self.single(value)

    def visit_AugAssign(self, node: ast.AugAssign) -> ast.stmt:
        """The same of what is added."""
        if isinstance(node.target, ast.Name) and node.target.id in COUNTS:
            return ast.Assign([node.target], _i(ast.BinOp(node.target, node.op, self.visit(node.value))), lineno=0)
        node.value = self.visit(node.value) if self.is_whole(node.target) else self.single(node.value)
        return node


class _Parameters(ast.NodeTransformer):
    """Takes parameters from the arguments of a block, in double precision, in place of its rows."""

    def __init__(self, given: Sequence[str]) -> None:
        self.given = given

    def visit_Subscript(self, node: ast.Subscript) -> ast.expr:
        """A row at j, as `scalar_rows` of blocks has it."""
        if isinstance(node.value, ast.Name):
            row = node.value.id
            name = f"{row[4:]}_" if row.startswith("row_") else row.removesuffix("_row")
            if name != row and name in self.given:
                return ast.Subscript(ast.Name(name), ast.Subscript(ast.Name("of_lane"), node.slice))
        return node
