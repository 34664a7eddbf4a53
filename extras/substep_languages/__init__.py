"""A scheme as one self-contained file in another language: C, Fortran, JavaScript, Julia, MATLAB or Python."""
