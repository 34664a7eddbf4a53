"""What to choose for a structure: the error of schemes, steps and numbers of modes, known before a direct step."""

from .structure_choice import StructureChoice, choose

__all__ = ["StructureChoice", "choose"]
