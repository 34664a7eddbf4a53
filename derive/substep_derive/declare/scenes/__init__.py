"""Declarations of scenes, one system a file; ALL holds them in the order in which they are listed."""

from . import constrained, contact, hysteretic, impact, lagrange, mechanisms, nonlinear, oscillator, pendulum

ALL = (
    *oscillator.ALL,
    *pendulum.ALL,
    *nonlinear.ALL,
    *contact.ALL,
    *hysteretic.ALL,
    *lagrange.ALL,
    *constrained.ALL,
    *mechanisms.ALL,
    *impact.ALL,
)
