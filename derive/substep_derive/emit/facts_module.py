"""Derived facts -> text of the module that holds them as plain data."""

import hashlib
from collections.abc import Mapping
from typing import Any

from .printing import fill
from .templates.facts import ESTIMATORS, FACTS
from .templates.scheme import BANNER


def facts_module(facts: Mapping[str, Any]) -> str:
    """Text of generated/substep_kernels/facts.py: values of numbers and texts alone, a table's row on each line."""
    text = fill(FACTS, values="\n".join(f"{name} = {literal(value)}" for name, value in facts.items()))
    return fill(BANNER, source="substep_derive.study.facts", digest=hashlib.sha256(text.encode()).hexdigest()) + text


def estimators_module(estimates: Mapping[str, Any]) -> str:
    """Text of generated/substep_kernels/estimators.py: the catalogue's estimators as plain data."""
    text = fill(ESTIMATORS, values="\n".join(f"{name} = {literal(value)}" for name, value in estimates.items()))
    digest = hashlib.sha256(text.encode()).hexdigest()
    return fill(BANNER, source="substep_derive.study.estimates", digest=digest) + text


def literal(value: Any) -> str:
    """The text of a value; of a mapping, with an entry on each line."""
    if not isinstance(value, Mapping):
        return repr(value)
    return "\n".join(["{", *(f"    {key!r}: {entry!r}," for key, entry in value.items()), "}"])
