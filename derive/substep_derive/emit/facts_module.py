"""Derived facts -> text of the module that holds them as plain data."""

from collections.abc import Mapping
from typing import Any

from .printing import fill, with_banner
from .templates.facts import ESTIMATORS, FACTS


def facts_module(facts: Mapping[str, Any]) -> str:
    """Text of generated/substep_kernels/facts.py: values of numbers and texts alone, a table's row on each line."""
    return with_banner("substep_derive.study.facts", fill(FACTS, values=_literals(facts)))


def estimators_module(estimates: Mapping[str, Any]) -> str:
    """Text of generated/substep_kernels/estimators.py: the catalogue's estimators as plain data."""
    return with_banner("substep_derive.study.estimates", fill(ESTIMATORS, values=_literals(estimates)))


def _literals(values: Mapping[str, Any]) -> str:
    return "\n".join(f"{name} = {_literal(value)}" for name, value in values.items())


def _literal(value: Any) -> str:
    if not isinstance(value, Mapping):
        return repr(value)
    return "\n".join(["{", *(f"    {key!r}: {entry!r}," for key, entry in value.items()), "}"])
