"""Estimators of the local error."""
