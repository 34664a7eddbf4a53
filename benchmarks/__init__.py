"""Speed with its error beside it: substep, the machine's limit in C, and peers on the same work."""
