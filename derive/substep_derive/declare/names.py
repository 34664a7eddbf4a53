"""Names of symbols and matrix entries in generated Python, and the check that declared names do not collide with them.

Every knot's symbol becomes a Python name of its own. The part of it that stands for the label holds no underscore, so
that a coordinate's name appended after an underscore cannot be read as part of the label.
"""

import builtins
import keyword
import re
import unicodedata
from collections.abc import Iterable, Mapping

from sympy import Symbol

from .errors import DeclarationError
from .symbols import knot, knot_of, lattice

# A label that begins with a star is a kernel's own: the acceleration that a balance without one of its own is solved
# for (*1, *2, ...), predictors (*star), mixed displacements (*mix0), what is reported (*reported), estimated errors
# (*error), the arguments of a function (*now), and what an estimate needs besides a step: accelerations at its ends
# from the equation of motion (*start, *end), the end after two half steps (*halved), the step before (*before0, ...);
# the displacement at the start of the first run, where a tangent is taken (*began); where a balance takes an equation
# of motion whose mass moves (*at) or holds a velocity (*held), and their values at z = 0 (*atstar, *heldstar); and what
# reactions do to an acceleration (*push0, ...), and one that is kept without it (*free1, ...).
_OWN_LABELS = re.compile(
    r"s\d+|star\d*|mix\d+|reported|error|now|start|end|halved|before\d+|began|(at|held)(star)?\d*|free\w*|push\d+"
)
_NUMBERS = re.compile(r"m?\d+(o\d+)?")  # names of labels that are numbers

# names of the derivation's symbols, which a scheme's parameter would be taken for
_DERIVATION = {"h", "omega", "Omega", "xi", "lambda", "mu", "z", "M", "C", "K", "K0", "K_t", "t", "f"}
# keyword arguments of functions that take parameters by name
_CALLS = {
    *("name", "scene", "scheme", "dt", "t_end", "keep", "samples", "energy_bound", "a0", "load", "save", "client"),
    *("progress", "device", "dtype", "workers", "seed", "tol", "rtol", "atol", "dt_first", "dt_min", "dt_max", "grid"),
    *("rung", "held_only", "damped", "changing", "structures", "remembered"),
}
# functions of a scene's module, and what these use, beside functions for its outputs
_SCENE_FUNCTIONS = {
    "energy",
    "acceleration",
    "angular_momentum",
    "commit",
    "momenta",
    "force",
    "limits",
    "powers",
    "np",
}
# what laws speak of, which coordinates and reactions of their scene would be taken for
_OF_LAWS = {"e_dot", "elapsed", "dissipated"}


def python_name(symbol: Symbol) -> str:
    """A symbol's name in Python; a knot's has its label rewritten: u_-1 is u_m1, v_1/2 is v_1o2, a_*1 is a_s1.

    A label of letters and digits stays as it is. One that would collide with another label's name, or that holds other
    characters, is escaped: it begins with Z, and each such character becomes its hexadecimal code between two Zs.
    """
    at = knot_of(symbol)
    return f"{at[0]}_{label_name(at[1])}" if at else symbol.name


def label_name(label: str) -> str:
    """A knot's label as `python_name` writes it."""
    number = lattice(label)
    if number is not None and str(number) == label:
        return label.replace("-", "m").replace("/", "o")
    if label.startswith("*"):
        own = label[1:]
        return f"s{own}" if own.isdigit() else own
    taken = _OWN_LABELS.fullmatch(label) or _NUMBERS.fullmatch(label)
    if re.fullmatch("[A-Za-z0-9]+", label) and not taken and not label.startswith("Z"):
        return label
    return "Z" + "".join(c if re.match("[A-Ya-z0-9]", c) else f"Z{ord(c):x}Z" for c in label)


def printed(parameter: Symbol) -> Symbol:
    """A parameter as kernels print it: with an underscore at its end, with which no name of a kernel's own ends.

    So a user may give a parameter any name; the order of names, and with it that of sums, stays the same.
    """
    return Symbol(f"{parameter.name}_")


def entry_name(name: str, *place: int) -> str:
    """The name of a matrix entry: D01 for (0, 1) of D; with an index beyond 9, D_1_11 for (1, 11)."""
    return name + ("".join(map(str, place)) if max(place) < 10 else "".join(f"_{i}" for i in place))


def check_scheme(
    scheme: str, parameters: Iterable[Symbol], family_arguments: Iterable[Symbol], mentioned: Iterable[Symbol]
) -> None:
    """Raises DeclarationError where names of a scheme, its parameters and its knots would collide in generated code.

    family_arguments: the arguments of its families, such as rho_inf. mentioned: symbols of relations and balances.
    """
    _check_identifier(scheme, "scheme", scheme)
    names = [p.name for p in parameters]
    for name in names:
        _check_identifier(scheme, "parameter", name)
        if name in _DERIVATION | _CALLS or knot_of(Symbol(name)):
            raise _taken(scheme, "parameter", name)
    arguments = [a.name for a in family_arguments]
    for name in arguments:
        _check_identifier(scheme, "family's argument", name)
        if name in _CALLS:
            raise _taken(scheme, "family's argument", name)
    _check_distinct(scheme, [*names, *arguments])
    for symbol in sorted(mentioned, key=str):
        kind, label = knot_of(symbol) or ("", "")
        if label.startswith("*"):
            raise DeclarationError(
                f"{scheme}: expected knots whose labels do not begin with '*', which kernels keep for themselves, got "
                f"'{symbol}'; rename the knot"
            )
        if label and symbol != getattr(knot(label), kind):
            raise DeclarationError(
                f"{scheme}: expected '{symbol}' as knot({label!r}) makes it, got a symbol of that name with other "
                f"assumptions; take it from knot({label!r})"
            )


def check_scene(
    scene: str,
    parameters: Iterable[Symbol],
    coordinates: Iterable[Symbol],
    derived: Iterable[Symbol],
    named: Mapping[str, Iterable[str]],
) -> None:
    """Raises DeclarationError where names of a scene would collide in generated code.

    derived: symbols of rates, accelerations, invariants and reactions. named: names of laws, constraints, contacts,
    frictions and outputs, by what they are.
    """
    _check_identifier(scene, "scene", scene)
    values, q = [p.name for p in parameters], [s.name for s in coordinates]
    for name in values:
        _check_identifier(scene, "parameter", name)
        if name in _CALLS or knot_of(Symbol(name)):
            raise _taken(scene, "parameter", name)
    for name in q:
        _check_identifier(scene, "coordinate", name)
        if name in _OF_LAWS:
            raise _taken(scene, "coordinate", name)
        if name.endswith("_"):  # it stands at the end of names in kernels: see `printed`
            raise DeclarationError(
                f"{scene}: expected a coordinate whose name does not end with an underscore, got '{name}'; rename it"
            )
    _check_distinct(scene, [*values, *q, *(s.name for s in derived), "t", "f", "h"])
    for what, names in named.items():
        for name in names:
            _check_identifier(scene, what, name)
            if name in _SCENE_FUNCTIONS or (name in _OF_LAWS and what in ("constraint", "contact", "friction")):
                raise _taken(scene, what, name)


def check_law(law: str, parameters: Iterable[Symbol], memory: Iterable[Symbol]) -> None:
    """Raises DeclarationError where names of a law, its parameters and its memory would collide."""
    _check_identifier(law, "law", law)
    values, kept = [p.name for p in parameters], [m.name for m in memory]
    for what, names in (("parameter", values), ("memory", kept)):
        for name in names:
            _check_identifier(law, what, name)
            of_scenes = name in _SCENE_FUNCTIONS | set("uva") or name.endswith("_")
            if name in _CALLS | {"law"} or (what == "memory" and of_scenes):
                raise _taken(law, what, name)
    _check_distinct(law, [*values, *kept, "e", "e_dot", "elapsed", "dissipated"])


def check_pair(scheme: str, scene: str, of_scheme: Iterable[Symbol], of_scene: Iterable[Symbol]) -> None:
    """Raises DeclarationError where a scheme and a scene both have a parameter of one name."""
    if both := sorted({p.name for p in of_scheme} & {p.name for p in of_scene}):
        raise DeclarationError(f"{scheme} and {scene} both have a parameter '{both[0]}'; rename the scene's")


def _check_identifier(owner: str, what: str, name: str) -> None:
    plain = name.isidentifier() and not keyword.iskeyword(name) and unicodedata.normalize("NFKC", name) == name
    if not plain:
        raise DeclarationError(
            f"{owner}: expected a {what} whose name is an identifier of Python, got '{name}'; rename the {what}"
        )
    if name.startswith("_") or hasattr(builtins, name):
        raise _taken(owner, what, name)


def _check_distinct(owner: str, names: list[str]) -> None:
    if twice := sorted({name for name in names if names.count(name) > 1}):
        raise DeclarationError(
            f"{owner}: expected a name of its own for each parameter, family's argument, coordinate, rate, invariant "
            "and memory, and none of them t, f or h of a scene, or e, e_dot, elapsed or dissipated of a law, got "
            f"'{twice[0]}' twice; rename one"
        )


def _taken(owner: str, what: str, name: str) -> DeclarationError:
    return DeclarationError(
        f"{owner}: expected a {what} whose name is free, got '{name}', which means something else here; "
        f"rename the {what}"
    )
