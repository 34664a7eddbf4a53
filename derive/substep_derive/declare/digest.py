"""Digests that distinguish one declaration from another: the sha256 of everything declared."""

import hashlib
from collections.abc import Mapping

from sympy import srepr, sympify

from .law import Law
from .parameter import Root
from .scene import Scene
from .scheme import Scheme


def scheme_digest(scheme: Scheme) -> str:
    """sha256 of everything declared about the scheme."""
    declared = [scheme.name, scheme.reference, *(f"{k}={v}" for k, v in scheme.fixed.items())]
    for p in (*scheme.parameters, *(family.argument for family in scheme.families)):
        default = p.default.equation if isinstance(p.default, Root) else p.default
        declared += [srepr(part) for part in (p.symbol, p.domain, default)]
    started = [*scheme.start.items()] if isinstance(scheme.start, Mapping) else []
    declared += [] if scheme.start_scheme is None else [scheme_digest(scheme.start_scheme)]
    declared += [srepr(part) for value in (*started, *scheme.report.items()) for part in value]
    declared += [f"embedded {srepr(symbol)} {srepr(e)}" for symbol, e in scheme.embedded.items()]
    declared += [srepr(part) for family in scheme.families for value in family.values.items() for part in value]
    declared += [srepr(part) for relation in scheme.relations.items() for part in relation]
    declared += [srepr(slot) for b in scheme.balances for slot in (b.inertia, b.damping, b.force, b.load)]
    return hashlib.sha256("\n".join(declared).encode()).hexdigest()


def law_digest(law: Law) -> str:
    """sha256 of everything declared about the law."""
    parts: list[object] = [law.name, law.reference]
    for p in law.parameters:
        parts += [srepr(p.symbol), srepr(p.domain), srepr(sympify(p.default))]
    for mapping in (law.memory, law.update):
        parts += [srepr(sympify(x)) for both in mapping.items() for x in both]
    parts += [srepr(x) for x in (law.force, law.stored, law.dissipated)]
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()


def scene_digest(scene: Scene) -> str:
    """sha256 of everything declared about the scene."""
    parts: list[object] = [scene.name, scene.reference]
    for mapping in (scene.coordinates, scene.start, scene.invariants, scene.load, scene.outputs):
        parts += [x if isinstance(x, str) else srepr(sympify(x)) for both in mapping.items() for x in both]
    for p in scene.parameters:
        parts += [srepr(p.symbol), srepr(p.domain), srepr(sympify(p.default))]
    for name, element in scene.laws.items():
        parts += [name, law_digest(element.law), srepr(element.elongation)]
        parts += [f"{k}={srepr(x)}" for k, x in element.values.items()]
    for name, x in scene.constraints.items():
        read = f" {x.level} {x.projected}" if x.projected or x.level != "position" else ""
        parts.append(f"constraint {name} {srepr(x.expression)}{read}")
    for name, x in scene.contacts.items():
        parts.append(f"contact {name} {srepr(x.gap)} {srepr(x.restitution)} {x.remembered}")
    parts += [f"friction {name} {srepr(x.along)} {srepr(x.limit)}" for name, x in scene.frictions.items()]
    parts += [f"force {q.name} {srepr(e)}" for q, e in scene.forces.items()]
    energies = (scene.kinetic, scene.potential, scene.dissipation, scene.length, scene.energy_scale)
    parts += [srepr(sympify(e)) for e in energies]
    return hashlib.sha256("\n".join(map(str, parts)).encode()).hexdigest()
