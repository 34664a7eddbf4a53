"""The only package that imports `substep_derive` and so SymPy, and only when one of its functions is called."""
