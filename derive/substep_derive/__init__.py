"""From a declared scheme to its closed forms and its stability proof, exactly; and a declaration's nouns."""

from .algebra.algebraic import Algebraic
from .declare.errors import DeclarationError, InconsistentScheme
from .declare.parameter import Family, Parameter, Root
from .declare.scene import Scene
from .declare.scheme import Balance, Scheme
from .stability.certificate import Certificate, certify
from .study.derivation import Derivation, derive

__all__ = [
    "Algebraic",
    "Balance",
    "Certificate",
    "DeclarationError",
    "Derivation",
    "Family",
    "InconsistentScheme",
    "Parameter",
    "Root",
    "Scene",
    "Scheme",
    "certify",
    "derive",
]
