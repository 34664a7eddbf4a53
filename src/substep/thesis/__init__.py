"""The thesis: its figures drawn anew, its claims judged."""
