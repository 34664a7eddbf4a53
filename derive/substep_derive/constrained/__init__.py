"""Step -> what a scheme makes of a motion that is constrained."""
