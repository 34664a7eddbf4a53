"""Estimators of the local error: which combination of what a step holds equals the leading term of its error."""
