"""Schemes on nonlinear equations: the series of a step, its order, symmetry and symplecticity, exactly."""
