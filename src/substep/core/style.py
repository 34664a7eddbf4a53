"""Colours and line styles of every chart.

Colours are Okabe and Ito's, which the colour-blind can tell apart; line styles differ too, for print in black.
"""

COLOURS = ("#0072B2", "#E69F00", "#009E73", "#D55E00", "#CC79A7")
REFERENCE = "#000000"
STYLES = ("-", "--", "-.", (0, (1, 1)), (0, (8, 2)))


def look(i: int) -> tuple[str, str | tuple[int, tuple[int, ...]]]:
    """Colour and line style of the i-th curve; no two of the first 25 share both."""
    return COLOURS[i % 5], STYLES[(i + i // 5) % 5]
