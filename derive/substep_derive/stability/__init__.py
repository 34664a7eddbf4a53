"""Stability, proved: Hurwitz polynomials, certificates, conditions on parameters, critical curves."""
