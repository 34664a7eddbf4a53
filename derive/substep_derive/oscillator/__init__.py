"""A scheme on the linear oscillator: its amplification matrix, and what follows from it."""
