"""Exact algebra that knows nothing of schemes: rational functions, algebraic numbers, real points, power series."""
