"""What a generated module is printed from: frozen objects, no text."""
