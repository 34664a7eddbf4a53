"""Declarations of laws with memory, one kind a file; ALL holds them in the order in which they are listed."""

from . import plastic

ALL = (*plastic.ALL,)
