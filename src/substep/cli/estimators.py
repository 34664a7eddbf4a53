"""The command `substep estimator`: estimates of the local error, and what they need."""

from typing import Annotated

import typer

from .arguments import SchemeArgument, exact_options, source_of, working
from .lines import wrapped


def estimator(
    context: typer.Context,
    name: SchemeArgument,
    held_only: Annotated[bool, typer.Option("--held-only", help="only what the step itself holds")] = False,
    undamped: Annotated[bool, typer.Option("--undamped", help="for motions without damping alone")] = False,
) -> None:
    """Derive estimates of the local error. Parameters follow as exact numbers: --beta 1/4; others stay free."""
    from ..derived.facade import estimator as derived  # noqa: PLC0415
    from ..derived.facade import estimator_filter, in_paper  # noqa: PLC0415

    try:
        source, parameters = source_of(name, exact_options(context.args))
        with working(f"deriving estimators of {name}"):
            found = derived(source, held_only=held_only, damped=not undamped, **parameters)
    except ValueError as error:
        raise typer.BadParameter(str(error)) from error
    for one, quantity in ((found.displacement, "u"), (found.velocity, "v")):
        error, leading = (in_paper(e, found.scheme) for e in (one.error, one.leading))
        print(wrapped(f"error of {one.of}, order {one.order}: ", error, ""))
        print(wrapped("equals ", f"{leading} to leading order, where {quantity} is numerical minus exact", "    "))
        print(f"    grows like Omega^{one.growth} as Omega -> oo")
        for symbol, text in one.extra.items():
            print(wrapped(f"{symbol}: ", text.replace("**", "^"), "    "))
    damped_by = estimator_filter(source, **parameters)
    said = wrapped("filter for stiff components: ", damped_by, "")
    print(said if damped_by else "no filter: the scheme is explicit")
