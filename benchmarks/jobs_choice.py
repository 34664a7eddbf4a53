"""What `choose` takes for a structure whose modes are known, and whether direct steps have the errors it predicts."""

from importlib.util import find_spec

import numpy as np

import substep as ss
from substep.structures.examples import solid
from substep.studies.structures.prediction import Prediction
from substep.studies.structures.structure_choice import known_modes

from .job import Job, Table
from .timing import Alternative, cores, measure

NAME = "choice"
RAYLEIGH = ss.Rayleigh(1.0, 1e-6)
T_END, PULSE = 8e-3, 1.6e-3  # s: some periods of the first mode, and nearly one
ACCURACY = 1e-2
MARCHED = (("average_acceleration", 100), ("bathe", 100), ("generalized_alpha", 100), ("houbolt", 200))
REFERENCE = ("four_substep", 300)  # whose own error is a hundredth of theirs


def job(quick: bool) -> Job:
    """One core; 3-D elasticity of 3630 degrees of freedom, in full 98304, loaded at a corner, classical damping."""
    found = Job(NAME, "Choosing for a structure: predicted errors beside those of direct steps, one core")
    if not (find_spec("skfem") and find_spec("pypardiso")):
        found.skipped["all"] = "scikit-fem or pypardiso is not installed; pip install 'substep[structures,fem]'"
        return found
    cells = (10, 10, 10) if quick else (32, 31, 31)
    with cores(1):
        model = solid(cells, load=ss.HalfSine(1.0, PULSE), C=RAYLEIGH)
        dof = next(x for x, loaded in zip(model.names, model.T @ model.force(0.5 * PULSE), strict=True) if loaded)
        modes = known_modes(model)
        schemes = [s for s in map(ss.scheme, ss.schemes()) if s.info.damping]

        def predict() -> object:
            prediction = Prediction(modes, dof, T_END, ACCURACY)
            return [prediction.errors(s, 2 * prediction.rows) for s in schemes]

        def choose() -> object:
            return ss.choose(modes, ACCURACY, t_end=T_END, quantity=dof)

        ways = [
            Alternative(f"errors of {len(schemes)} schemes", "substep", predict, 1),
            Alternative("choose", "substep", choose, 1),
        ]
        table = Table(f"solid, {model.size} degrees of freedom, {len(modes)} modes known", "call", measure(ways, 5))
        found.tables.append(table)
        for row in table.rows:
            found.below(f"{row.name}, solid of {model.size}, modes known", 1.0, [row.seconds], "s")
        _beside_direct_steps(found, Prediction(modes, dof, T_END, ACCURACY), dof)
    return found


def _beside_direct_steps(found: Job, prediction: Prediction, dof: str) -> None:
    """The error of direct steps against the reference, which are direct steps too, and what was predicted of it."""
    model, rows = prediction.modes.structure, prediction.rows

    def marched(scheme: str, n: int) -> np.ndarray:
        return ss.march(model, scheme, dt=T_END / n, t_end=T_END, dofs=[dof], account=False).u[:: n // rows, 0]

    found.notes.append(f"Modes that are not known may add up to about {prediction.unforeseen:.1e}.")
    true = marched(*REFERENCE)
    for name, n in MARCHED:
        predicted = float(prediction.errors(ss.scheme(name), n)[-1])
        own = float(np.abs(marched(name, n) - true).max() / np.abs(true).max())
        found.notes.append(f"{name}, {n} steps of {model.size}: predicted {predicted:.3e}, direct steps {own:.3e}.")
        found.below(f"{name}: error predicted against that of direct steps", 0.05, [abs(predicted / own - 1.0)])
