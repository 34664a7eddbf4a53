"""Scene -> text of its module: energies, invariants and accelerations in NumPy; and its entry in the index."""

import json
from collections.abc import Iterable

from sympy import Expr, Matrix, Symbol, sympify

from ..declare.digest import scene_digest
from ..declare.law import elapsed
from ..declare.names import printed
from ..declare.parameter import Parameter
from ..declare.scene import Scene
from ..declare.symbols import sampled, t
from ..motion.equations import EquationsOfMotion, inverted
from ..motion.jumps import jumps
from ..motion.powers import powers
from .index import domain_text, number, numpy_for
from .law_functions import law_functions
from .printing import ArrayPrinter, block, docstring, fill, literal_tuple, with_banner
from .templates.scene import LOG_COSH, SCENE_FUNCTION, SCENE_HEADER, SCENES
from .templates.scheme import BANNER

CONSTRAINED = "Matrix, row by row, and right side of the equations for acceleration and multipliers."
DRIFT = "What constraints keep at 0, minus gaps, what slides; first derivatives; second without accelerations."
DIRECTIONS = "Their derivatives by the coordinates, row by row."
MOMENTA = "Noether's momenta, under the names and in the units of the catalogue."
POWERS = "The powers of these, W, and where it is there what the energy of the frame is, J."
LIMITS = "Of each friction its limit without pressures, and by how much it grows with each of these, in turn."
COMMIT = "What laws remember once it is committed at a displacement, `elapsed` s after that given."


def energies_and_forces(motion: EquationsOfMotion) -> str:
    """Energies, equations of motion, tangent and invariants, for the module's docstring."""
    q = list(motion.coordinates)
    forms: dict[str, object] = {
        "kinetic energy": motion.scene.kinetic,
        "potential": motion.scene.potential,
        **{f"{s}": e for s, e in motion.scene.invariants.items()},
        "mass": motion.mass.tolist(),
        "damping": motion.damping.tolist() if any(motion.damping) else None,
        "force of the rate": list(motion.rate_force) if any(motion.rate_force) else None,
        "internal force": list(motion.force(q)),
        "tangent stiffness": motion.tangent(q).tolist(),
        "load": list(motion.load) if any(motion.load) else None,
        **{f"momentum of {p.name}, {p.unit}": p.expression for p in motion.momenta},
        **{f"constraint {name}": f"{x.expression} = 0" for name, x in motion.scene.constraints.items()},
        **{f"contact {name}": f"{contact.gap} >= 0" for name, contact in motion.scene.contacts.items()},
        **{f"friction {name}": f"along {x.along}, at most {x.limit}" for name, x in motion.scene.frictions.items()},
        **{f"memory {s}": f"{e}, then {motion.commit[s]}" for s, e in motion.memory.items()},
    }
    return "\n".join(f"    {name}: {form}" for name, form in forms.items() if form is not None)


def scene_module(motion: EquationsOfMotion) -> str:
    """Text of generated/substep_kernels/scenes/<name>.py."""
    scene = motion.scene
    declared, motion = motion, motion.in_kernels
    values = tuple(p.symbol for p in motion.scene.parameters)
    functions = [
        _function("energy", values, "Kinetic energy and potential, in J for units of kg, m, s.", motion, motion.energy)
    ]
    written = inverted(motion.mass)
    if scene.multipliers or not written:
        matrix, right = motion.constrained
        functions.append(_function("constrained", values, CONSTRAINED, motion, [*matrix, *right]))
    if scene.multipliers:
        drift = [*motion.held.expressions, *motion.held.drift[0], *motion.held.drift[1]]
        functions.append(_function("drift", values, DRIFT, motion, drift))
        functions.append(_function("directions", values, DIRECTIONS, motion, list(motion.held.directions)))
    if scene.frictions:
        functions.append(_function("limits", values, LIMITS, motion, _limits(motion.scene)))
    if not scene.constraints and written:
        acceleration = motion.consistent_acceleration
        functions.append(
            _function("acceleration", values, "Acceleration from the equation of motion.", motion, acceleration)
        )
    if given := powers(motion):
        function = _function("powers", values, POWERS, motion, list(given.values()))
        functions.append(f"\n\nPOWERS = {literal_tuple(map(repr, given))}\n{function}")
    if motion.momenta:
        found = [p.expression for p in motion.momenta]
        functions.append(_function("momenta", values, MOMENTA, motion, found))
    for name, e in motion.outputs.items():
        functions.append(_function(name, values, f"{name.capitalize()}.", motion, e))
    if motion.memory:
        functions.append(_function("commit", values, COMMIT, motion, list(motion.commit.values())))
    body = "".join(functions)
    helper = fill(LOG_COSH, decorator="") if "_log_cosh(" in body else ""
    return "".join(
        [
            fill(
                BANNER,
                source=f"the declaration of {scene.name} in substep_derive.declare.scenes",
                digest=scene_digest(scene),
            ),
            fill(
                SCENE_HEADER,
                name=scene.name,
                reference=docstring(scene.reference + "."),
                equations=docstring(energies_and_forces(declared)),
            ),
            helper,
            *law_functions(body, ""),
            body,
        ]
    )


def _limits(scene: Scene) -> list[Expr]:
    """The limit of each friction without pressures, and by how much it grows with each of these."""
    pressures = dict.fromkeys(map(Symbol, scene.contacts), 0)
    limits = [friction.limit.subs(scene.invariants) for friction in scene.frictions.values()]
    return [e for limit in limits for e in (limit.subs(pressures), *(limit.diff(p) for p in pressures))]


def _function(
    name: str, values: tuple[Symbol, ...], doc: str, motion: EquationsOfMotion, value: Expr | Matrix | list[Expr]
) -> str:
    """A function of the parameters, the time, u and v (..., d), what laws remember (..., k), if there are any, the time
    since then in `commit`, and, where the user gives one, of the load f (...).
    """
    rows = [value] if isinstance(value, Expr) else list(value)
    commits = name == "commit"
    rows = [e if commits else e.subs(elapsed, 0) for e in rows]
    given = [*([elapsed] if commits else []), *([sampled] if motion.is_sampled and not commits else [])]
    read = {s for e in rows for s in e.free_symbols}
    places = [(q, f"displacement[..., {k}]") for k, q in enumerate(motion.coordinates)]
    places += [(r, f"velocity[..., {k}]") for k, r in enumerate(motion.scene.rates)]
    pressures = motion.scene.multipliers[len(motion.scene.constraints) :]
    places += [(s, f"memory[..., {k}]") for k, s in enumerate(motion.memory)]
    places += [(s, f"memory[..., {k - len(pressures)}]") for k, s in enumerate(pressures)]
    w = ArrayPrinter({s.name: printed(s).name for s, _ in places})  # as with parameters, no other name is like these
    taken = "".join(f"    {w.doprint(s)} = {text}\n" for s, text in places if s in read)
    names = [f"value_{k}" for k in range(len(rows))] if len(rows) > 1 else ["value"]
    plain = {k: w.doprint(e) for k, e in enumerate(rows) if len(rows) > 1 and (e.is_number or e.is_Symbol)}
    body, _ = block([(names[k], e) for k, e in enumerate(rows) if k not in plain], printer=w)
    of_all = ", ".join(plain.get(k, name) for k, name in enumerate(names))
    memory = ["memory"] if motion.memory or read & set(pressures) else []
    vector = f"np.stack(np.broadcast_arrays({of_all}, displacement[..., 0])[:-1], axis=-1)"
    return fill(
        SCENE_FUNCTION,
        name=name,
        arguments=", ".join(
            [*(s.name for s in values), t.name, "displacement", "velocity", *memory, *(s.name for s in given)]
        ),
        docstring=doc,
        body=taken + body,
        value="value" if isinstance(value, Expr) else vector,
    )


def scenes_index(motions: Iterable[EquationsOfMotion]) -> str:
    """Text of generated/substep_kernels/scene_index.py."""
    body = ["{", *(f'    "{m.scene.name}": {scene_entry(m)},' for m in motions), "}"]
    text = fill(SCENES, imports=numpy_for("\n".join(body)), scenes="\n".join(body))
    return with_banner("substep_derive.declare.scenes", text)


def scene_entry(motion: EquationsOfMotion) -> str:
    """Plain data about one scene, as text."""
    scene = motion.scene
    inside = scene.in_kernels
    arguments = ", ".join(p.name for p in inside.parameters)

    def function(text: str) -> str:
        return f"lambda {arguments}: {text}".replace("lambda :", "lambda:")

    u, v = ([sympify(inside.start[s]) for s in symbols] for symbols in (motion.coordinates, scene.rates))
    given = [sympify(inside.start[a]) for a in scene.accelerations if a in scene.start]
    oscillator = motion.in_kernels.oscillator
    start = [literal_tuple(number(e) for e in vector) if vector else "None" for vector in (u, v, given)]
    entry = {
        "coordinates": literal_tuple(
            f'("{q}", {json.dumps(unit, ensure_ascii=False)})' for q, unit in scene.coordinates.items()
        ),
        "parameters": literal_tuple(_parameter(p) for p in scene.parameters),
        "start": function(f"({', '.join(start)})"),
        "length": function(number(sympify(inside.length))),
    }
    some = {
        "energy_scale": None if inside.energy_scale is None else function(number(inside.energy_scale)),
        "outputs": literal_tuple(f'"{name}"' for name in motion.outputs) if motion.outputs else None,
        "momenta": literal_tuple(f'("{p.name}", "{p.unit}")' for p in motion.momenta) if motion.momenta else None,
        "sampled": "True" if motion.is_sampled else None,
        "damped": "True" if motion.damped or scene.frictions else None,
        "conserves": "True" if motion.of_rates and motion.conserves else None,
        "oscillator": None if oscillator is None else function(literal_tuple(number(e) for e in oscillator)),
    }
    entry |= {key: text for key, text in some.items() if text is not None} | {"reference": repr(scene.reference)}
    if motion.memory:
        entry["memory"] = literal_tuple(f'"{s}"' for s in motion.memory)
        entry["unstrained"] = function(literal_tuple(number(e) for e in motion.in_kernels.memory.values()))
    if scene.constraints:
        entry["multipliers"] = literal_tuple(f'"{name}"' for name in scene.constraints)
    if scene.contacts:
        entry["contacts"] = literal_tuple(f'"{name}"' for name in scene.contacts)
    if scene.frictions:
        entry["frictions"] = literal_tuple(f'"{name}"' for name in scene.frictions)
    if held := [name for name, contact in scene.contacts.items() if contact.restitution is None]:
        entry["held_gaps"] = literal_tuple(f'"{name}"' for name in held)
    if scene.impulsive:
        entry["impulsive"] = "True"
    if found := jumps(motion):
        entry["jumps"] = literal_tuple(f'("{q}", "sign({of})")' for q, of in found)
    return "{" + ",\n        ".join(f'"{key}": {value}' for key, value in entry.items()) + "}"


def _parameter(p: Parameter) -> str:
    return f'("{p.name}", {domain_text(p)}, {None if p.default is None else float(p.default)})'
