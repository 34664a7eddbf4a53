"""Matrices of structures: sums, low rank, factorizations."""
