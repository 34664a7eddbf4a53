"""Texts of generated modules -> the table of what their functions cost, so that a change of cost is seen in review.

Operations are those written in a function's text, each once, also those in a loop: sums, differences, products,
quotients and powers, and changes of sign. Indices of arrays and arithmetic between numbers do not count. Calls are
those of other functions, but for range.
"""

import ast
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from .printing import fill
from .templates.operations import OPERATIONS


@dataclass(frozen=True)
class Cost:
    """Operations and calls of one function of a module; text: the function's source, by which equal ones are found."""

    name: str
    operations: int
    calls: int
    text: str


def operations_table(files: Mapping[str, str]) -> str:
    """Text of generated/substep_kernels/operations.md, from file name -> text of all modules."""
    costs = [(name.removesuffix(".py"), cost) for name, text in sorted(files.items()) for cost in function_costs(text)]
    modules = Counter(cost.text for _, cost in costs)
    rows: dict[str, str] = {}
    for module, cost in costs:
        others = modules[cost.text] - 1
        rows.setdefault(cost.text, f"| {module} | {cost.name} | {cost.operations} | {cost.calls} | {others or ''} |")
    sizes = {name.removesuffix(".py"): (text.count("\n"), len(text.encode())) for name, text in sorted(files.items())}
    return fill(
        OPERATIONS,
        modules=len(files),
        lines=sum(lines for lines, _ in sizes.values()),
        size=f"{sum(size for _, size in sizes.values()) / 1000:.0f}",
        functions="\n".join(rows.values()),
        sizes="\n".join(f"| {name} | {lines} | {size / 1000:.1f} |" for name, (lines, size) in sizes.items()),
    )


def function_costs(text: str) -> Iterator[Cost]:
    """The cost of every function of a module that computes anything, in the order of the text."""
    lines = text.splitlines()
    for function in ast.parse(text).body:
        if isinstance(function, ast.FunctionDef):
            operations, calls = _count(function)
            if operations:
                first = min((d.lineno for d in function.decorator_list), default=function.lineno)
                yield Cost(function.name, operations, calls, "\n".join(lines[first - 1 : function.end_lineno]))


def _count(function: ast.FunctionDef) -> tuple[int, int]:
    operations = calls = 0
    left: list[ast.AST] = list(function.body)
    while left:
        node = left.pop()
        if isinstance(node, ast.Subscript):
            left.append(node.value)
            continue
        if isinstance(node, ast.BinOp | ast.AugAssign) or (
            isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub)
        ):
            operations += not _is_number(node)
        elif isinstance(node, ast.Call):
            calls += not (isinstance(node.func, ast.Name) and node.func.id == "range")
        left.extend(ast.iter_child_nodes(node))
    return operations, calls


def _is_number(node: ast.AST) -> bool:
    """Whether it is arithmetic between numbers, which is done when the module is compiled."""
    return not any(isinstance(part, ast.Name | ast.Attribute | ast.Call | ast.Subscript) for part in ast.walk(node))
