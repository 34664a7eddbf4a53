"""Direct time integration schemes for structural dynamics: declared once, derived, compiled.

import substep as ss
s = ss.scheme("newmark_bdf2", gamma_t=0.2, beta=0.3025, gamma=0.6)
s.spectral_radius([0.1, 10.0])
r = ss.march(ss.scene("linear_oscillator", omega=6.28), s, dt=0.01, t_end=10.0)
"""

from .auditing.claims import Claims
from .auditing.dialects import dialect
from .auditing.instrument import audit
from .auditing.program import Program
from .auditing.programs.adapter import Integrator
from .auditing.stepper import Stepper
from .core.emission import emit
from .core.exports import load
from .core.loads import HalfSine, Harmonic, Record, Step
from .core.response import Response
from .core.scenes import Scene, scene, scenes
from .core.schemes import Scheme, scheme, schemes
from .ground_motion.design_spectrum import design_spectrum
from .ground_motion.intensity import intensity
from .ground_motion.modal_combination import response_spectrum_analysis, spectrum_beside_history
from .ground_motion.records import read_record
from .ground_motion.rotated import response_spectrum_rotated
from .ground_motion.spectrum import response_spectrum
from .marching.run import march
from .structures.model.rayleigh import Rayleigh, rayleigh
from .structures.modes.modal_damping import ModalDamping, modal_damping
from .structures.structure import Modes, Structure, structure
from .studies.choosing import choose
from .sweeps import sweep


def __getattr__(name: str) -> str:
    if name != "__version__":
        raise AttributeError(f"module 'substep' has no attribute '{name}'")
    from importlib.metadata import version  # noqa: PLC0415 (on first use: it takes a tenth of the import of substep)

    return version("substep")


__all__ = [
    "Claims",
    "HalfSine",
    "Harmonic",
    "Integrator",
    "ModalDamping",
    "Modes",
    "Program",
    "Rayleigh",
    "Record",
    "Response",
    "Scene",
    "Scheme",
    "Step",
    "Stepper",
    "Structure",
    "audit",
    "choose",
    "design_spectrum",
    "dialect",
    "emit",
    "intensity",
    "load",
    "march",
    "modal_damping",
    "rayleigh",
    "read_record",
    "response_spectrum",
    "response_spectrum_analysis",
    "response_spectrum_rotated",
    "scene",
    "scenes",
    "scheme",
    "schemes",
    "spectrum_beside_history",
    "structure",
    "sweep",
]
