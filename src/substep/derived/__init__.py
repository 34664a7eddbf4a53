"""The one door back to the derivation: SymPy is imported here and nowhere else, when a function is called."""
