"""Speed charted against accuracy: what a run costs, how far it is off, and what to choose for a wished accuracy."""

from .choice import Choice, choose

__all__ = ["Choice", "choose"]
