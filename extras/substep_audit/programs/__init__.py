"""Adapters of programs, each a script of its own; see `adapter`."""
