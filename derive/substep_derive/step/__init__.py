"""Scheme -> Step: the equations of a step and their order, from which all else about a scheme is derived."""
