"""The fixed text of the modules of derived facts; every {field} is filled."""

FACTS = '''"""Derived facts about the catalogue, as plain data, so that no run has to derive them.

CATALOGUE: scheme -> its properties at its default parameters, exact values as text; order is that of u, v and a,
damping and period are the first terms, undamped, as (power of Omega, coefficient), None for an error that is 0, and
values holds numbers. FORMS: scheme with parameters -> what decides properties at any of them, see
substep_derive.study.forms.
"""

from math import inf

{values}
'''

ESTIMATORS = '''"""Estimators of the local error at default parameters, as plain data.

ESTIMATORS: scheme -> u, v: the estimates, with r for an irrational parameter; order: p of u and v; extra: symbol of
what is needed besides the step -> what it is; growth: the power of Omega with which each grows on stiff components;
filter: (numerator, denominator) of the filter on the oscillator, None for an explicit scheme; filters: how often it has
to be applied for each to vanish. On the oscillator, over the state: estimates, rows of those of u and h*v, over dens;
back, whether each row is over the state one step earlier; reported, rows of u and h*v at t_n + h, over den. A row is a
tuple of polynomials, and these of (power of Omega, power of xi, factor). Or reason: why there is no estimator.
"""
{values}
'''
