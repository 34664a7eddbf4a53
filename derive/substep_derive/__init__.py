"""From a declared scheme to its closed forms, exactly: `derive`, and the nouns of a declaration."""

from .derivation import Derivation, derive
from .scheme import Balance, DeclarationError, Parameter, Scheme

__all__ = ["Balance", "DeclarationError", "Derivation", "Parameter", "Scheme", "derive"]
