"""Exact algebra: rational functions, algebraic numbers, signs at real points, power series. It knows no scheme."""
