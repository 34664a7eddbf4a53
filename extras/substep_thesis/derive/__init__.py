"""What algebra alone says of the thesis: printed formulas, regions of parameters, and the claims that it decides."""
