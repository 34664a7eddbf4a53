"""Studies of the catalogue: speed against accuracy, where schemes fail, charts of all schemes."""
