"""Declarations of laws, one kind a file; ALL holds them in the order in which they are listed."""

from . import elastic, plastic, smooth, viscous

ALL = (*elastic.ALL, *plastic.ALL, *smooth.ALL, *viscous.ALL)
