"""Declarations of scenes, one system a file; ALL holds them in the order in which they are listed."""

from . import constrained, contact, hysteretic, nonlinear, oscillator, pendulum

ALL = (*oscillator.ALL, *pendulum.ALL, *nonlinear.ALL, *contact.ALL, *hysteretic.ALL, *constrained.ALL)
