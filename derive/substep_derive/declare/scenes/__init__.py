"""Declarations of scenes, one system a file; ALL holds them in the order in which they are listed."""

from . import contact, hysteretic, lagrange, nonlinear, oscillator, pendulum

ALL = (*oscillator.ALL, *pendulum.ALL, *nonlinear.ALL, *contact.ALL, *hysteretic.ALL, *lagrange.ALL)
