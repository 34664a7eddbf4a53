"""What is wrong with a declaration."""


class DeclarationError(ValueError):
    """A scheme's declaration does not define the new state; the message names what is wrong."""
