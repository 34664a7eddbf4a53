"""Speed against accuracy: what a run costs, how large its error is, and what to choose for a wished accuracy."""

from .scene_choice import Choice, choose

__all__ = ["Choice", "choose"]
