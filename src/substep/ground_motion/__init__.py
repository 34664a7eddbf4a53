"""Ground motions from files, and their response spectra."""
