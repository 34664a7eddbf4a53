"""From a declared scheme to its closed forms and its stability proof, exactly; and a declaration's nouns."""

from .algebra.algebraic import Algebraic
from .algebra.constant import Constant
from .constrained.impact import Impact, impact
from .constrained.prescribed import ErrorTerm, Prescribed, prescribed
from .declare.composition import composition
from .declare.errors import DeclarationError, InconsistentScheme
from .declare.law import Element, Law, before, e, e_dot, elapsed
from .declare.parameter import Family, Parameter, Root
from .declare.published import Published
from .declare.reactions import Constraint, Contact, Friction
from .declare.scene import Scene, optional, required
from .declare.scenes.rods import four_bars, rod_chain
from .declare.scheme import Balance, Scheme
from .declare.symbols import K0, C, K_t, M, N, N_discrete, Omega, acceleration, f, h, knot, rate, sampled, t, xi
from .declare.tableau import nystrom, tableau
from .estimate.analysis import NoEstimator
from .estimate.estimator import Estimate, Estimator, estimator
from .motion.turning import Turning, turning
from .motion.turning_threshold import TurningThreshold, turning_threshold
from .nonlinear.modified import ModifiedEquation
from .nonlinear.modified_energy import ModifiedEnergy
from .nonlinear.modified_motion import ModifiedMotion
from .nonlinear.order import order_of_rates
from .oscillator.energy import Energy, NoEnergy
from .stability.certificate import Certificate
from .stability.structures import StructuresCertificate, certify
from .study.derivation import Derivation, derive

__all__ = [
    "K0",
    "Algebraic",
    "Balance",
    "C",
    "Certificate",
    "Constant",
    "Constraint",
    "Contact",
    "DeclarationError",
    "Derivation",
    "Element",
    "Energy",
    "ErrorTerm",
    "Estimate",
    "Estimator",
    "Family",
    "Friction",
    "Impact",
    "InconsistentScheme",
    "K_t",
    "Law",
    "M",
    "ModifiedEnergy",
    "ModifiedEquation",
    "ModifiedMotion",
    "N",
    "N_discrete",
    "NoEnergy",
    "NoEstimator",
    "Omega",
    "Parameter",
    "Prescribed",
    "Published",
    "Root",
    "Scene",
    "Scheme",
    "StructuresCertificate",
    "Turning",
    "TurningThreshold",
    "acceleration",
    "before",
    "certify",
    "composition",
    "derive",
    "e",
    "e_dot",
    "elapsed",
    "estimator",
    "f",
    "four_bars",
    "h",
    "impact",
    "knot",
    "nystrom",
    "optional",
    "order_of_rates",
    "prescribed",
    "rate",
    "required",
    "rod_chain",
    "sampled",
    "t",
    "tableau",
    "turning",
    "turning_threshold",
    "xi",
]
