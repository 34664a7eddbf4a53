"""Questions about a scheme: its whole derivation, its profile, equivalent schemes, design, claims of the thesis."""
