"""What is declared: symbols, schemes, scenes and their parameters. Nothing is derived here."""
