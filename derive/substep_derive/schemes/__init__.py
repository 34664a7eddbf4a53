"""The catalogue: declarations only. A new scheme is one declaration here and one entry in ALL."""

from . import composite, newmark

ALL = (*newmark.ALL, *composite.ALL)
