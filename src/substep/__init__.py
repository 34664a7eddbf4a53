"""Direct time integration schemes for structural dynamics: declared once, derived, compiled.

import substep as ss
s = ss.scheme("newmark_bdf2", gamma_t=0.2, beta=0.3025, gamma=0.6)
s.spectral_radius([0.1, 10.0])
r = ss.march(ss.scene("linear_oscillator", omega=6.28), s, dt=0.01, t_end=10.0)
"""

from typing import TYPE_CHECKING, Any

from .core import extras
from .core.exports import load
from .core.independent import Independent, independent
from .core.laws import Law, law, laws
from .core.loads import HalfSine, Harmonic, Record, Step
from .core.response import Response
from .core.scene_by_name import scene
from .core.scene_catalogue import scenes
from .core.scenes import Scene
from .core.schemes import Scheme, scheme, schemes
from .ground_motion.design_spectrum import design_spectrum
from .ground_motion.incremental import incremental_dynamic_analysis
from .ground_motion.inelastic import inelastic_spectrum
from .ground_motion.intensity import intensity
from .ground_motion.modal_combination import response_spectrum_analysis, spectrum_beside_history
from .ground_motion.records import read_record
from .ground_motion.rotated import response_spectrum_rotated
from .ground_motion.spectrum import response_spectrum
from .marching.run import march
from .structures.model.rayleigh import Rayleigh, rayleigh
from .structures.model.redistributed_mass import redistributed_mass
from .structures.modes.modal_damping import ModalDamping, modal_damping
from .structures.shear_building import shear_building
from .structures.structure import Modes, Structure, structure
from .studies.choosing import choose
from .studies.energy_drift import EnergyDrift, energy_drift
from .studies.own_energy import OwnEnergy, own_energy
from .sweeps import sweep
from .sweeps.uncertain import sobol_indices, uncertainty

if TYPE_CHECKING:  # what extras/ brings; here for type checkers alone
    from substep_audit.claims import Claims
    from substep_audit.dialects import dialect
    from substep_audit.instrument import audit
    from substep_audit.named_integrators import scheme_of
    from substep_audit.program import Program
    from substep_audit.programs.adapter import Integrator
    from substep_audit.stepper import Stepper
    from substep_languages.emission import emit

    __version__: str
else:

    def __getattr__(name: str) -> Any:
        """The version; else what an installed package brings under that name: see `core.extras`."""
        if name == "__version__":
            from importlib.metadata import version  # noqa: PLC0415 (on first use, as in `core.extras`)

            return version("substep")
        found = None if name.startswith("_") else extras.brought(extras.NAMES, name)
        if found is None:
            raise AttributeError(f"module 'substep' has no attribute '{name}'")
        return found

    def __dir__() -> list[str]:
        """The public names: those of `__all__`, which a star imports, and those that installed packages bring."""
        return sorted([*__all__, *extras.installed(extras.NAMES)])


__all__ = [
    "EnergyDrift",
    "HalfSine",
    "Harmonic",
    "Independent",
    "Law",
    "ModalDamping",
    "Modes",
    "OwnEnergy",
    "Rayleigh",
    "Record",
    "Response",
    "Scene",
    "Scheme",
    "Step",
    "Structure",
    "choose",
    "design_spectrum",
    "energy_drift",
    "incremental_dynamic_analysis",
    "independent",
    "inelastic_spectrum",
    "intensity",
    "law",
    "laws",
    "load",
    "march",
    "modal_damping",
    "own_energy",
    "rayleigh",
    "read_record",
    "redistributed_mass",
    "response_spectrum",
    "response_spectrum_analysis",
    "response_spectrum_rotated",
    "scene",
    "scenes",
    "scheme",
    "schemes",
    "shear_building",
    "sobol_indices",
    "spectrum_beside_history",
    "structure",
    "sweep",
    "uncertainty",
]
if TYPE_CHECKING:
    __all__ += ["Claims", "Integrator", "Program", "Stepper", "audit", "dialect", "emit", "scheme_of"]
