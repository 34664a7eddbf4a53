"""The fixed text of generated modules; every {field} is filled by the emitters, and unused fields are errors."""
