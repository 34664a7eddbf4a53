"""Checks of a scene's declaration, made when it is built: what is declared has to define a motion.

Every check raises `DeclarationError`, which names the scene, the expression at fault, and the cure.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Protocol

from sympy import Expr, Interval, Matrix, Max, Min, Piecewise, Rational, Symbol, eye

from .branches import larger, smaller, where_at_least
from .errors import DeclarationError
from .expressions import require_known
from .law import Element
from .names import check_scene
from .parameter import NOT_NEGATIVE, REAL, Parameter, require_assumptions, signed
from .potentials import may_jump
from .reactions import Constraint, Contact, Friction
from .symbols import sampled, t

TINY = Rational(1, 10**20)
TRIED = (Rational(2, 3), Rational(-5, 7), Rational(9, 4))  # values of rates at which a dissipation is looked at


class _Declared(Protocol):
    """A scene's declaration, as far as it is checked."""

    @property
    def name(self) -> str: ...
    @property
    def coordinates(self) -> Mapping[Symbol, str]: ...
    @property
    def kinetic(self) -> Expr: ...
    @property
    def potential(self) -> Expr: ...
    @property
    def parameters(self) -> tuple[Parameter, ...]: ...
    @property
    def start(self) -> Mapping[Symbol, Any]: ...
    @property
    def length(self) -> Any: ...
    @property
    def invariants(self) -> Mapping[Symbol, Expr]: ...
    @property
    def dissipation(self) -> Expr: ...
    @property
    def forces(self) -> Mapping[Symbol, Expr]: ...
    @property
    def load(self) -> Mapping[Symbol, Expr]: ...
    @property
    def laws(self) -> Mapping[str, Element]: ...
    @property
    def constraints(self) -> Mapping[str, Constraint]: ...
    @property
    def contacts(self) -> Mapping[str, Contact]: ...
    @property
    def frictions(self) -> Mapping[str, Friction]: ...
    @property
    def multipliers(self) -> tuple[Symbol, ...]: ...
    @property
    def impulsive(self) -> bool: ...
    @property
    def outputs(self) -> Mapping[str, Expr]: ...
    @property
    def energy_scale(self) -> Expr | None: ...
    @property
    def output_of(self) -> Mapping[str, str]: ...
    @property
    def memory_of(self) -> Mapping[str, Mapping[Symbol, Symbol]]: ...
    @property
    def rates(self) -> tuple[Symbol, ...]: ...
    @property
    def accelerations(self) -> tuple[Symbol, ...]: ...


def check(scene: _Declared) -> None:
    """All checks, in the order in which their messages help most."""
    of_laws = (s for names in scene.memory_of.values() for s in names.values())
    derived = (*scene.rates, *scene.accelerations, *scene.invariants, *of_laws, *scene.multipliers)
    named = {"law": scene.laws, "constraint": scene.constraints, "contact": scene.contacts, "friction": scene.frictions}
    named |= {"output": scene.outputs}
    check_scene(scene.name, [p.symbol for p in scene.parameters], tuple(scene.coordinates), derived, named)
    _symbols(scene)
    _kinetic(scene)
    _invariants(scene)
    _mass(scene)
    _dissipation(scene)


def _symbols(scene: _Declared) -> None:
    values = {p.symbol for p in scene.parameters}
    q, v = set(scene.coordinates), set(scene.rates)
    for x in scene.coordinates:
        require_assumptions(scene.name, "a coordinate, any real number", x, REAL)
    for symbol, e in scene.invariants.items():
        require_known(scene.name, f"invariant {symbol}", e, values | q | {t})
    require_known(scene.name, "kinetic energy", scene.kinetic, values | q | v | {t})
    require_known(scene.name, "potential", scene.potential, values | q | set(scene.invariants) | {t})
    require_known(scene.name, "dissipation", scene.dissipation, values | q | v)
    for name, element in scene.laws.items():
        require_known(scene.name, f"elongation of {name}", element.elongation, values | q)
        for what, value in element.values.items():
            require_known(scene.name, f"{what} of {name}", value, values)
    _reactions(scene, values, q, v)
    _bounded(scene, values)
    for what, given in (("forces", scene.forces), ("load", scene.load)):
        if unknown := sorted((s for s in given if s not in q), key=str):
            raise DeclarationError(
                f"{scene.name}: {what} are given on '{unknown[0]}', expected one of the coordinates "
                f"{', '.join(sorted(map(str, q)))}; correct the name"
            )
    for symbol, force in scene.forces.items():
        if moved := sorted(force.free_symbols & set(scene.accelerations), key=str):
            raise DeclarationError(
                f"{scene.name}: the force on {symbol} holds the acceleration '{moved[0]}', expected coordinates, rates "
                "and t alone; write a mass that moves with them into the kinetic energy"
            )
        require_known(scene.name, f"force on {symbol}", force, values | q | v | {t})
    for symbol, force in scene.load.items():
        require_known(scene.name, f"load on {symbol}", force, values | {t, sampled})
    _start(scene, values)
    if twice := [name for name in scene.output_of.values() if name in scene.outputs]:
        raise DeclarationError(
            f"{scene.name}: expected names of outputs that are not those of the forces of laws, got '{twice[0]}' "
            "twice; rename one"
        )
    for name, e in scene.outputs.items():
        require_known(scene.name, f"output {name}", e, values | q | v | set(scene.invariants) | {t})


def _start(scene: _Declared, values: set[Symbol]) -> None:
    """That the start says everything, and nothing of what there is not, and numbers that depend on parameters alone."""
    for symbol, e in scene.start.items():
        require_known(scene.name, f"start of {symbol}", e, values)
    for name, e in (("length", scene.length), ("energy scale", scene.energy_scale)):
        if e is not None:
            require_known(scene.name, name, e, values)
    if missing := [s for s in (*scene.coordinates, *scene.rates) if s not in scene.start]:
        raise DeclarationError(f"{scene.name}: start says nothing of {missing[0]}; give start={{{missing[0]}: ...}}")
    some = {*scene.coordinates, *scene.rates, *scene.accelerations}
    if unknown := [s for s in scene.start if s not in some]:
        raise DeclarationError(
            f"{scene.name}: start is given of '{unknown[0]}', expected only coordinates, rates and accelerations, "
            f"{', '.join(sorted(map(str, some)))}; correct the name"
        )


def _reactions(scene: _Declared, values: set[Symbol], q: set[Symbol], v: set[Symbol]) -> None:
    """What constraints, contacts and frictions hold."""
    held = [(f"constraint {name}", x.expression, "0", v) for name, x in scene.constraints.items()]
    none = set[Symbol]()
    held += [(f"contact {name}", x.gap, "0 at contact and positive before", none) for name, x in scene.contacts.items()]
    held += [(f"friction {name}", x.along, "what slides", none) for name, x in scene.frictions.items()]
    for what, g, value, rates in held:
        require_known(scene.name, what, g, values | q | set(scene.invariants) | {t} | rates)
        if not _linear(g, rates):
            raise DeclarationError(
                f"{scene.name}: expected {what} to be linear in {', '.join(sorted(map(str, v)))}, got {g}; a reaction "
                "has no direction otherwise"
            )
        if not g.subs(scene.invariants).free_symbols & (q | rates):
            raise DeclarationError(
                f"{scene.name}: expected {what} to depend on coordinates, got {g}; write what is to be {value}"
            )


def _linear(e: Expr, symbols: set[Symbol]) -> bool:
    """Whether an expression is linear in symbols, and the same on all branches."""
    symbols = symbols & e.free_symbols
    bends = any(may_jump(e.diff(a), symbols) or e.diff(a, b).expand() != 0 for a in symbols for b in symbols)
    return not (bends or may_jump(e, symbols))


def _bounded(scene: _Declared, values: set[Symbol]) -> None:
    """What bounds the reactions of contacts and frictions."""
    pressures = set(map(Symbol, scene.contacts))
    for name, friction in scene.frictions.items():
        allowed = values | pressures | set(scene.coordinates) | set(scene.invariants) | {t}
        require_known(scene.name, f"limit of friction {name}", friction.limit, allowed)
        if friction.limit != 0 and signed(friction.limit, scene.parameters).is_nonpositive:
            raise DeclarationError(
                f"{scene.name}: expected a limit of friction {name} that is not negative, got {friction.limit}; it is "
                "the largest force against sliding"
            )
        if not _linear(friction.limit, pressures):
            raise DeclarationError(
                f"{scene.name}: expected a limit of friction {name} that is linear in pressures, got {friction.limit}; "
                "write a coefficient times the pressure"
            )
    for name, contact in scene.contacts.items():
        e = contact.restitution
        if e is not None:
            require_known(scene.name, f"restitution of contact {name}", e, values)
        if e is not None and contact.remembered:
            raise DeclarationError(
                f"{scene.name}: expected contact {name} to have a restitution or to be remembered, got both; an "
                "impact acts once, so leave out remembered=True"
            )
        if e is not None and not _is_share(scene, e):
            raise DeclarationError(
                f"{scene.name}: expected a restitution from 0 to 1 for contact {name}, got {e}; it is the share of the "
                "velocity that an impact leaves, a parameter as optional(e, Rational(1, 2), Interval(0, 1))"
            )
    if (kept := [name for name, x in scene.contacts.items() if x.remembered]) and scene.impulsive:
        raise DeclarationError(
            f"{scene.name}: expected contacts that are all remembered, without friction, or none that is, got "
            f"{kept[0]} beside others; leave out remembered=True"
        )


def _is_share(scene: _Declared, e: Expr) -> bool:
    """Whether it lies from 0 to 1, as far as its parameters' intervals or defaults tell."""
    share = Interval(0, 1)
    of = {p.symbol: p for p in scene.parameters}
    if isinstance(e, Symbol) and e in of:
        return of[e].domain.is_subset(share) is True
    at = e.subs({s: p.default for s, p in of.items() if isinstance(p.default, Expr)})
    return not at.is_number or share.contains(at) == True  # noqa: E712 (of SymPy)


def _kinetic(scene: _Declared) -> None:
    v = scene.rates
    slope = hessian(scene.kinetic, v)
    if slope.free_symbols & set(v) or _rest(scene.kinetic, v) != 0:
        raise DeclarationError(
            f"{scene.name}: expected a kinetic energy quadratic in {', '.join(map(str, v))}, with coefficients in "
            f"coordinates and t, got {scene.kinetic}; write what is of another degree into forces"
        )


def _rest(energy: Expr, v: Iterable[Symbol]) -> Expr:
    """What of an energy is not of second degree in the rates."""
    at_rest = dict.fromkeys(v, 0)
    linear = sum((energy.diff(s).subs(at_rest) * s for s in v), energy.subs(at_rest))
    half = (Matrix([list(v)]) * hessian(energy, v) * Matrix(list(v)))[0] / 2
    return (energy - half - linear).expand()


def hessian(energy: Expr, v: Iterable[Symbol]) -> Matrix:
    """The second derivatives of an energy by the rates."""
    return Matrix([energy]).jacobian(list(v)).jacobian(list(v))


def _invariants(scene: _Declared) -> None:
    q = tuple(scene.coordinates)
    for symbol, e in scene.invariants.items():
        own = [a for a in q if a in e.free_symbols]
        third = [e.diff(a, b, c) for a in own for b in own for c in own]
        if any(d != 0 for d in third) or may_jump(e, q):
            raise DeclarationError(
                f"{scene.name}: expected invariant {symbol} at most quadratic in the coordinates, got {e}"
            )


def _mass(scene: _Declared) -> None:
    """That no mass is negative, and that the mass matrix is regular, tried at numbers for all parameters."""
    mass, q = hessian(scene.kinetic, scene.rates), tuple(scene.coordinates)
    if negative := [
        q[i] for i in range(len(q)) if mass[i, i] != 0 and signed(mass[i, i], scene.parameters).is_nonpositive
    ]:
        raise DeclarationError(
            f"{scene.name}: expected a kinetic energy that is not negative, got {scene.kinetic}, in which "
            f"{negative[0]} has the mass {mass[q.index(negative[0]), q.index(negative[0])]}; correct the sign"
        )
    if scene.constraints and not scene.impulsive:  # which may hold what has no mass, and need no inverse
        return
    values = {p.symbol: p.inside(Rational(3 + k, 7 + k)) for k, p in enumerate(scene.parameters)}
    anywhere = {x: Rational(3, 5 + k) for k, x in enumerate((*q, t))}
    at_start = {x: scene.start[x] for x in q} | {t: 0}
    for where, place in (("", anywhere), (" at the start", at_start)):
        numbers = mass.subs(place, simultaneous=True).subs(values).evalf(30)
        if singular(numbers):
            without = [str(x) for x, m in zip(q, numbers.diagonal(), strict=True) if m == 0]
            raise DeclarationError(
                f"{scene.name}: expected a kinetic energy in which every coordinate has a mass, got a singular mass "
                f"matrix{where}, {mass.tolist()}{', without one of ' * bool(without)}{', '.join(without)}; leave out "
                "the coordinate without one, choose others, or start elsewhere"
            )


def singular(numbers: Matrix) -> bool:
    """Whether a mass matrix of numbers is singular, but for rounding.

    Of many coordinates, or of masses of several sizes, a small determinant says nothing: what is left of each mass once
    those before it are eliminated does.
    """
    if abs(numbers.det()) > TINY * max(abs(x) for x in numbers) ** numbers.rows:
        return False
    left = numbers.as_mutable()
    for k, mass in enumerate(numbers.diagonal()):
        if abs(left[k, k]) <= TINY * abs(mass):
            return True
        for i in range(k + 1, left.rows):
            left[i, :] -= left[i, k] / left[k, k] * left[k, :]
    return False


def _decided(e: Expr) -> Expr:
    """The expression with functions that SymPy evaluates at numbers."""
    parts = [_decided(x) for x in e.args]
    if isinstance(e, where_at_least):
        a, b, x, y = parts
        return Piecewise((x, a >= b), (y, True))
    return {larger: Max, smaller: Min}.get(e.func, e.func)(*parts) if parts else e


def _dissipation(scene: _Declared) -> None:
    """That a dissipation is convex in the rates, tried where all its parameters are known not to be negative."""
    e, q, v = scene.dissipation, tuple(scene.coordinates), scene.rates
    held = [p for p in scene.parameters if p.symbol in e.free_symbols]
    if e == 0 or not all(p.domain.is_subset(NOT_NEGATIVE) for p in held):
        return
    values = {p.symbol: p.inside(Rational(3, 7)) for p in held}
    values |= {x: Rational(3, 5 + k) for k, x in enumerate(q)}
    second = Matrix([[_decided(e.diff(a).diff(b)) for b in v] for a in v]).subs(values)
    for shift in range(len(TRIED)):
        rates = {x: TRIED[(k + shift) % len(TRIED)] for k, x in enumerate(v)}
        numbers = second.subs(rates).evalf(30) + TINY * eye(len(v))
        if not numbers.is_positive_semidefinite:
            raise DeclarationError(
                f"{scene.name}: expected a dissipation that is convex in {', '.join(map(str, v))}, so that it takes "
                f"energy, got {e}; write a force that gives energy into forces"
            )
