"""The march of a structure in time, and its largest stable step."""
