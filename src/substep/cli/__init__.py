"""The command line `substep`."""
