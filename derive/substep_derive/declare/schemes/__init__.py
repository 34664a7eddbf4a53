"""The catalogue: declarations only. A new scheme is one declaration here and one entry in ALL."""

from . import (
    alpha,
    composite,
    composition,
    designed,
    diagonally_implicit,
    explicit,
    multi_step,
    newmark,
    nystrom,
    one_step,
    runge_kutta,
)

ALL = (
    *explicit.ALL, *newmark.ALL, *one_step.ALL, *alpha.ALL, *multi_step.ALL, *composite.ALL,
    *runge_kutta.ALL, *diagonally_implicit.ALL, *nystrom.ALL, *composition.ALL, *designed.ALL,
)  # fmt: skip
