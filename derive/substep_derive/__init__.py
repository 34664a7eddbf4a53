"""From a declared scheme to its closed forms and its stability proof, exactly; and a declaration's nouns."""

from .algebraic import Algebraic
from .derivation import Derivation, derive
from .scene import Scene
from .scheme import Balance, DeclarationError, Family, Parameter, Root, Scheme
from .stability import Certificate, certify

__all__ = [
    "Algebraic",
    "Balance",
    "Certificate",
    "DeclarationError",
    "Derivation",
    "Family",
    "Parameter",
    "Root",
    "Scene",
    "Scheme",
    "certify",
    "derive",
]
