"""The command `substep design`."""

from typing import Annotated

import typer

from substep.cli.arguments import declared, known_schemes, refuse, working
from substep.cli.command import Command
from substep.cli.lines import folded


def design(
    context: typer.Context,
    name: Annotated[
        str | None,
        typer.Argument(
            help="a scheme whose parameters are sought, by name or as file.py:name; else give --sub-steps",
            autocompletion=known_schemes,
        ),
    ] = None,
    sub_steps: Annotated[int | None, typer.Option(help="compose a scheme of so many sub-steps")] = None,
    order: Annotated[int, typer.Option(help="order of accuracy")] = 2,
    rho_inf: Annotated[str, typer.Option(help="spectral radius as h grows: 1/2, free (all of [0, 1]) or any")] = "any",
    one_stiffness: Annotated[
        bool, typer.Option("--one-stiffness/--several-stiffnesses", help="one effective stiffness for all sub-steps")
    ] = True,
    l_stable: Annotated[bool, typer.Option("--l-stable", help="the same as --rho-inf 0")] = False,
    least: Annotated[str, typer.Option(help="error_constant, period_error or damping")] = "error_constant",
    cpu_seconds: Annotated[float, typer.Option(help="CPU time after which the answer is 'undecided'")] = 60.0,
) -> None:
    """Find exact parameters from requirements, with proof; or prove that there are none.

    substep design --sub-steps 3 --order 3 --rho-inf free; substep design generalized_alpha --rho-inf 1/2
    """
    from .design import design as of  # noqa: PLC0415 (SymPy only when asked for)

    radius = None if rho_inf == "any" or (name is not None and rho_inf == "free") else rho_inf
    try:
        refuse(context, () if name is None else ("one_stiffness", "least", "cpu_seconds"), "with a scheme")
        if name is not None and l_stable:
            if rho_inf not in ("any", "0"):
                raise ValueError(f"expected --l-stable, or --rho-inf, got both, {rho_inf}; the first is --rho-inf 0")
            radius = "0"
        if name is not None and sub_steps is not None:
            raise ValueError("expected a scheme or --sub-steps, got both; leave one of them out")
        if name is not None:
            with working(f"designing {name}"):
                found = of(declared(name), rho_inf=radius, order=order)
            print(
                "\n".join(folded(one.text) for one in found)
                or f"{name}: no parameters give order {order} and that rho_inf"
            )
            return
        if sub_steps is None:
            raise ValueError(
                "expected a scheme or --sub-steps, got neither; write substep design --sub-steps 3 --order 3"
            )
        with working(f"designing a scheme of {sub_steps} sub-steps, for at most {cpu_seconds:g} s"):
            answer = of(
                sub_steps=sub_steps,
                order=order,
                rho_inf=radius,
                one_stiffness=one_stiffness,
                l_stable=l_stable,
                least=least,
                cpu_seconds=cpu_seconds,
            )
    except (ValueError, TypeError) as error:
        raise typer.BadParameter(str(error)) from error
    print(folded(answer.text))
    if answer.found is not None:
        print(folded(f"\nCertificate at the default parameters:\n{answer.found.certificate.text}"))


COMMAND = Command("Proofs", "substep design --sub-steps 3 --order 3 --rho-inf free", design)
