"""What a user asks of runs, checked once: the steps of one run, and the axes of many."""
