"""What the explorer's page knows of schemes, derived from their declarations and printed as JavaScript."""
