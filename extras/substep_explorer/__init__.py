"""`substep explorer`: one page with every scheme, to be opened in any browser."""
