"""Handles of schemes and scenes, loads, responses, and the errors that all of them raise."""
