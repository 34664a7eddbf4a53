"""The fixed text of the module of derived facts; every {field} is filled."""

FACTS = '''"""Derived facts about the catalogue and the thesis, as plain data, so that no run has to derive them.

CATALOGUE: scheme -> its properties at its default parameters, exact values as text; order is that of u, v and a.
SPLITS, NEWMARK_SETS: gamma_t of the thesis's figures 4.1 to 4.5, and (beta, gamma) of its Table 4.1. PROPERTIES: these
sets and Bathe's scheme, as (scheme, "parameter=value", ...), sorted -> rho_inf, order, and the first term of numerical
damping and of period error at small Omega as (power, coefficient), undamped; None for an error that is 0. FINDINGS: id
of a claim of the thesis that algebra alone judges -> whether each part of it holds, and the evidence.
"""
{values}
'''
