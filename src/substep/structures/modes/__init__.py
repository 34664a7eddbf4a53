"""Natural modes of a structure, damping by modes, superposition."""
