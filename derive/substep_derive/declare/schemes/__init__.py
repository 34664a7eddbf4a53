"""The catalogue: declarations only. A new scheme is one declaration here and one entry in ALL."""

from . import alpha, composite, designed, explicit, multi_step, newmark, one_step

ALL = (*explicit.ALL, *newmark.ALL, *one_step.ALL, *alpha.ALL, *multi_step.ALL, *composite.ALL, *designed.ALL)
