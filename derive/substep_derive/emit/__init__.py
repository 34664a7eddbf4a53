"""Text of generated modules, printed from kernels. Nothing is analysed here."""
