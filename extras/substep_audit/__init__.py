"""Read an integrator from outside: which scheme it is, what its order, limits and stability are, where it departs."""
