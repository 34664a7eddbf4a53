"""Law -> text of its module: a kernel over springs, which structures call and in which a declaration is tried."""

from collections.abc import Collection, Iterable

from sympy import Expr, Symbol

from ..declare.digest import law_digest
from ..declare.law import Law, e, e_dot, elapsed
from ..declare.names import printed
from .index import domain_text, number
from .law_functions import law_functions
from .printing import KernelPrinter, block, docstring, fill, literal_tuple, placed, with_banner
from .templates.decorators import INNER
from .templates.law import EVALUATE, LAW, LAWS, UNSTRAINED
from .templates.scheme import BANNER

DISSIPATED = Symbol("dissipated")
CALLED = "# called by kernels alone: not from Python, and so without the code for that\n"


def law_module(law: Law) -> str:
    """Text of generated/substep_kernels/laws/<name>.py."""
    parameters = {p.symbol: printed(p.symbol) for p in law.parameters}
    keeps = [*law.memory, *([DISSIPATED] if law.dissipated != 0 else [])]
    values, kept, new = _places("parameters", parameters), _places("memory", keeps), _places("new", keeps)
    outputs: list[tuple[str, Expr]] = [
        ("force[i]", law.trial),
        ("tangent[i]", law.trial.diff(e)),
        ("damping[i]", law.trial.diff(e_dot)),
        *((place, law.update[s]) for place, s in zip(new, law.memory, strict=False)),
    ]
    if law.dissipated != 0:
        outputs.append((new[-1], DISSIPATED + law.lost))
    outputs.append(("stored[i]", law.stored.xreplace(dict(law.update))))
    used = {s for _, x in outputs for s in x.free_symbols}
    names = {
        s.name: printed(s).name for s in (*parameters, *keeps, e, e_dot, elapsed)
    }  # as no name of the kernel's own
    w = KernelPrinter(names)
    places = [*zip(parameters, values, strict=True), *zip(keeps, kept, strict=True)]
    places += [(e, "e[i]"), (e_dot, "e_dot[i]"), (elapsed, "elapsed[0]")]
    body = fill(
        EVALUATE,
        read=placed((f"{names[s.name]} = {place}" for s, place in places if s in used), 2),
        body=block(outputs, 2, w)[0],
    )
    start = fill(
        UNSTRAINED,
        arguments=", ".join(x.name for x in parameters.values()),
        values=literal_tuple(number(x) for x in _start(law, parameters)),
    )
    text = "".join([start, body])
    header = fill(
        LAW,
        name=law.name,
        reference=docstring(law.reference + "."),
        equations=docstring(_equations(law)),
        parameters=literal_tuple(
            f'("{p.name}", {domain_text(p)}, {None if p.default is None else float(p.default)})' for p in law.parameters
        ),
        memory=literal_tuple(f'"{s}"' for s in keeps),
        of_rate=law.of_rate,
    )
    banner = fill(
        BANNER, source=f"the declaration of {law.name} in substep_derive.declare.laws", digest=law_digest(law)
    )
    return "".join([banner, header, CALLED, INNER, *law_functions(text, "@_inner\n"), text])


def _places(array: str, of: Collection[Symbol]) -> list[str]:
    """Where the numbers of the spring i are in an array that has the first of all springs, then the next."""
    return [f"{array}[{before}i]" for before in ("", "count + ", *(f"{k}*count + " for k in range(2, len(of))))][
        : len(of)
    ]


def _start(law: Law, parameters: dict[Symbol, Symbol]) -> list[Expr]:
    found = [x.subs(parameters, simultaneous=True) for x in law.start.values()]
    return [*found, *([0 * e] if law.dissipated != 0 else [])]


def _equations(law: Law) -> str:
    """The declaration, for the module's docstring."""
    rows = [f"    force: {law.force}"]
    rows += [f"    memory {s}: {law.start[s]}, then {law.update[s]}" for s in law.memory]
    rows += [f"    stored energy: {law.stored}"] + (
        [f"    dissipated: {law.dissipated}"] if law.dissipated != 0 else []
    )
    return "\n".join(rows)


def laws_index(laws: Iterable[Law]) -> str:
    """Text of generated/substep_kernels/law_index.py."""
    return with_banner("substep_derive.declare.laws", fill(LAWS, laws=literal_tuple(f'"{law.name}"' for law in laws)))
