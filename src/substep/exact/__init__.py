"""Exact motions and periods, with which the results of schemes are compared."""
