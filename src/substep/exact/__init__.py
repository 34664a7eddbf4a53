"""Exact motions that schemes are held against."""
