"""March scenes with schemes: one run, or many lanes at once."""
