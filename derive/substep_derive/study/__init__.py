"""What is asked of a scheme: everything derived behind one name, profiles, equivalences, design, the thesis."""
