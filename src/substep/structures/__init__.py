"""Structures: M, C, K of a finite element model, marched by the plan that is derived from a scheme."""
