"""Errors: a wrong declaration, and a scheme that is declared correctly but is not consistent."""


class DeclarationError(ValueError):
    """A wrong declaration or request; the message says what was expected, what came, and the cure."""


class InconsistentScheme(ValueError):
    """A scheme whose solution does not tend to the exact one as the step h tends to 0."""
