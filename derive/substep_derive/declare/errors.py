"""What is wrong with a declaration, and with a scheme that is declared as it should be."""


class DeclarationError(ValueError):
    """A scheme's declaration does not define the new state; the message names what is wrong."""


class InconsistentScheme(ValueError):
    """A scheme whose solution does not tend to the exact one as the step h tends to 0."""
