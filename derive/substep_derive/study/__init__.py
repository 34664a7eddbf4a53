"""Questions about a scheme: its whole derivation, its profile, and equivalent schemes."""
