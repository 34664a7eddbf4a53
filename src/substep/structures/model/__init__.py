"""What is given of a structure."""
