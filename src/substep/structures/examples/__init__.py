"""Models to try schemes on, each one call: beams and frames, a bar, and, by scikit-fem, a plate and a solid.

Degrees of freedom are named by component and place, such as "uy at 10" or "uz at 1 0.2 0.2".
"""

from .bars import bar
from .continua import plate, solid
from .frames import Section, cantilever, frame, simple_beam
from .rotating import rotating_bar

__all__ = ["Section", "bar", "cantilever", "frame", "plate", "rotating_bar", "simple_beam", "solid"]
