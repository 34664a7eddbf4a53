"""Design: from requirements to exact parameters of a declared scheme, or to a composite scheme that meets them."""

from .answer import Answer, Found
from .design import design
from .parameters import Design, Least, least_period_error, limit, order_equations, rho
from .second_order import Region, region, second_order_region
from .wish import Wish

__all__ = [
    "Answer",
    "Design",
    "Found",
    "Least",
    "Region",
    "Wish",
    "design",
    "least_period_error",
    "limit",
    "order_equations",
    "region",
    "rho",
    "second_order_region",
]
