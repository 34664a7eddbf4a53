"""LocalError -> text of the module that says how a scheme's local error is estimated."""

from ..declare.names import printed
from ..estimate.estimator import acceleration_lag
from ..kernels.local_error import LocalError
from .printing import KernelPrinter, fill, literal_tuple
from .templates.adaptive import LOCAL_ERROR


def local_error_module(found: LocalError) -> str:
    """Text of a module that holds the terms of an estimate of the local error, and their weights as a function."""
    names = {s.name: printed(s).name for s in found.parameters}
    w = KernelPrinter(names)
    return fill(
        LOCAL_ERROR,
        scheme=found.scheme.name,
        terms=found.terms,
        always=found.always,
        sources=found.sources,
        order=found.order,
        lag=acceleration_lag(found.scheme),
        parameters=literal_tuple(f'"{s.name}"' for s in found.parameters),
        arguments=", ".join(names.values()),
        weights=literal_tuple(w.doprint(e) for e in found.weights),
    )
