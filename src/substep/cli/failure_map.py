"""The command `substep failure-map`: a page of the outcomes of schemes on the stiff pendulum, to pan and to zoom."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from .arguments import known_schemes, refuse, scheme_of

Plane = Literal["h-EA", "h-v0", "v0-EA"]


def failure_map(
    context: typer.Context,
    names: Annotated[
        list[str] | None,
        typer.Argument(help="schemes such as bathe, newmark:beta=1/4 or file.py:mine", autocompletion=known_schemes),
    ] = None,
    port: Annotated[int, typer.Option(help="of the server; 0 takes a free one")] = 0,
    show: Annotated[bool, typer.Option("--open", help="open the page in the browser")] = False,
    device: Annotated[Literal["cpu", "cuda", "auto"], typer.Option(help="where tiles are run")] = "auto",
    out: Annotated[Path | None, typer.Option("--out", "-o", help="write the page here, and start no server")] = None,
    pixels: Annotated[int, typer.Option(help="with --out: along each side, 256 times a power of two")] = 4096,
    plane: Annotated[Plane, typer.Option(help="with --out: the two axes")] = "h-EA",
) -> None:
    """Serve a page of which runs of the stiff pendulum survive, over step, stiffness and speed, at any depth.

    Each pixel is one run, made when the page asks for it, until neighbouring doubles run out. The page has every scheme
    and those named, the first of which it shows first. Ctrl-C ends it. With --out the page and its tiles of the schemes
    named go into a folder, where they need no server.
    """
    from ..core.device import found  # noqa: PLC0415
    from ..core.progress import shown  # noqa: PLC0415
    from ..core.schemes import scheme, schemes  # noqa: PLC0415
    from ..studies.failures import tiles  # noqa: PLC0415

    try:
        server_alone, files_alone = ("port", "show"), ("pixels", "plane")
        refuse(context, files_alone if out is None else server_alone, "with" + "out" * (out is None) + " --out")
        own = {name: scheme_of(name) for name in names or ["average_acceleration"]}
        found(device)
        if out is not None:
            with shown(len(own) * pixels**2, 0, True, "failure map") as advance:
                tiles.write(out, own, plane, pixels, device, advance)
            print(f"open {(out / 'index.html').resolve()} in a browser")
            return
        server = tiles.server({**own, **{name: scheme(name) for name in schemes() if name not in own}}, device, port)
    except (ValueError, ImportError, RuntimeError, OSError) as error:
        raise typer.BadParameter(str(error)) from error
    address = f"http://127.0.0.1:{server.server_port}/"
    print(f"open {address} in a browser; Ctrl-C ends the server", flush=True)
    if show:
        import webbrowser  # noqa: PLC0415 (on first use)

        webbrowser.open(address)
    with server:
        server.serve_forever()
