"""Every transient integrator that a program's manual or source names, a file of TOML for each program."""
