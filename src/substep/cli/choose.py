"""The command `substep choose`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, cast

import numpy as np
import typer
from rich.console import Console

from ..core import errors
from ..core.schemes import schemes
from .arguments import (
    SceneArgument,
    StartOption,
    StrainOption,
    given_of,
    integers,
    numbers,
    require_files,
    require_folders,
    scene_of,
    schemes_of,
    working,
)

if TYPE_CHECKING:
    from collections.abc import Sequence

    from ..core.loads import Record
    from ..core.schemes import Scheme
    from ..structures.structure import Structure
    from ..studies.structures.structure_choice import Model

PANEL = "Structures"
OF_SCENES = ("chosen", "a0", "strain", "file")
OF_STRUCTURES = ("mass", "stiffness", "load", "at", "ground", "fixed", "damping_ratio", "modes", "model")


def choose(
    context: typer.Context,
    accuracy: Annotated[float, typer.Option(help="largest error allowed: relative, or in rad of the angle")],
    scene_name: SceneArgument = "",
    quantity: Annotated[
        str,
        typer.Option(
            help="u, v, a, energy, angle, multipliers, a coordinate or an output; of a structure a dof, from 0"
        ),
    ] = "u",
    t_end: Annotated[
        float | None, typer.Option(help="span in s; by default that of the scene's chart, or of a structure's load")
    ] = None,
    among: Annotated[
        str, typer.Option(help="schemes to choose from, as bathe,newmark:beta=1/4,rk4; by default all")
    ] = "",
    chosen: Annotated[str, typer.Option(help="schemes to try at tolerances too; by default the cheapest")] = "",
    a0: StartOption = "",
    strain: StrainOption = "",
    file: Annotated[
        Path | None, typer.Option("--file", "--out", "-o", help="draw why: where the chart goes, without suffix")
    ] = None,
    mass: Annotated[
        Path | None, typer.Option(rich_help_panel=PANEL, help="matrix M: Matrix Market, Abaqus' coordinates, OP4, ...")
    ] = None,
    stiffness: Annotated[Path | None, typer.Option(rich_help_panel=PANEL, help="matrix K, likewise")] = None,
    load: Annotated[
        Path | None, typer.Option(rich_help_panel=PANEL, help="two columns, time (s) and load, or a record")
    ] = None,
    at: Annotated[str, typer.Option(rich_help_panel=PANEL, help="degrees of freedom with that load, as 0,3")] = "",
    ground: Annotated[
        bool,
        typer.Option("--ground", rich_help_panel=PANEL, help="the load is an acceleration of the ground, along --at"),
    ] = False,
    fixed: Annotated[str, typer.Option(rich_help_panel=PANEL, help="degrees of freedom held at 0, as 0,1,2")] = "",
    damping_ratio: Annotated[
        float, typer.Option(rich_help_panel=PANEL, help="of the modes, all others undamped")
    ] = 0.0,
    modes: Annotated[int | None, typer.Option(rich_help_panel=PANEL, help="to predict from; by default 60")] = None,
    model: Annotated[str, typer.Option(rich_help_panel=PANEL, help="any, direct (all of it) or modal")] = "any",
) -> None:
    """Recommend scheme, step or tolerance, and model for a wished accuracy: of a scene, or of a structure M, K.

    A scene's parameters follow: --EA 1e10. Tolerances, of steps that choose themselves, are tried for the scheme
    that needs the least work in constant steps among those that can change theirs, or for those of --chosen.

    A structure's matrices are read from files, its degrees of freedom counted from 0: substep choose --mass M.mtx
    --stiffness K.mtx --load force.txt --at 41 --quantity 41 --accuracy 1e-3
    """
    from ..studies.precision import scene_choice  # noqa: PLC0415 (Matplotlib only when asked for)
    from ..studies.precision.cases import span  # noqa: PLC0415
    from ..studies.structures.structure_choice import choose as choose_for_structure  # noqa: PLC0415
    from ..studies.structures.structure_choice import known_modes  # noqa: PLC0415

    try:
        _require_one(context, scene_name, mass, stiffness)
        require_files(mass, stiffness, load)
        candidates = schemes_of(among)
        _announce(candidates)
        if mass is not None and stiffness is not None:
            record = _record(load, ground)
            end = record.dt * (len(record.samples) - 1) if t_end is None else t_end
            here = _structure(mass, stiffness, record, integers("--at", at), ground, integers("--fixed", fixed))
            if not quantity.isdecimal():
                raise ValueError(f"expected --quantity as the number of a degree of freedom, from 0, got '{quantity}'")
            with working(f"choosing for {stiffness.name}"):
                ratio = errors.damping_ratio("--damping-ratio", damping_ratio)
                known = known_modes(here, modes).damped(ratio)
                answer = choose_for_structure(
                    known, accuracy, t_end=end, quantity=int(quantity), among=candidates, model=cast("Model", model)
                )
            Console().print(answer.text, highlight=False)
            return
        require_folders(file)
        scene = scene_of(scene_name, a0, strain, numbers(context.args))
        end = span(scene) if t_end is None else t_end
        with working(f"choosing for {scene_name}"):
            found = scene_choice.choose(
                scene, accuracy, t_end=end, quantity=quantity, among=candidates, chosen=schemes_of(chosen)
            )
    except (ValueError, OSError, ImportError) as error:
        raise typer.BadParameter(str(error)) from error
    Console().print(found.text, highlight=False)
    if file is not None:
        scene_choice.chart(found, file)
    if found.interrupted:
        raise KeyboardInterrupt


def _announce(candidates: "Sequence[Scheme] | None") -> None:
    """Say on stderr how many schemes are marched, before it begins, and what makes them fewer."""
    n = len(schemes() if candidates is None else candidates)
    fewer = "; --among bathe,noh_bathe,rk4 takes fewer, and less time" if candidates is None else ""
    Console(stderr=True).print(
        f"marching {n} scheme{'s' * (n > 1)}, each in finer and finer steps{fewer}", soft_wrap=True
    )


def _require_one(context: typer.Context, scene_name: str, mass: Path | None, stiffness: Path | None) -> None:
    """Raise ValueError unless there is a scene or both matrices, with options of that kind alone."""
    given = given_of(context, (*OF_SCENES, *OF_STRUCTURES))
    if scene_name and mass is None and stiffness is None:
        kind, others = "a scene", [name for name in given if name in OF_STRUCTURES]
    elif mass is not None and stiffness is not None:
        kind, others = "a structure", [name for name in given if name in OF_SCENES]
        others += [scene_name] * bool(scene_name) + context.args
    else:
        got = " and ".join(f"--{name}" for name in ("mass", "stiffness") if name in given) or "neither"
        raise ValueError(f"expected a scene, or both --mass and --stiffness of a structure, got {got}; complete it")
    if others:
        options = ", ".join(f"--{name.replace('_', '-')}" if name in given else name for name in others)
        raise ValueError(f"expected options of {kind}, got {options}; leave that out")


def _record(load: Path | None, ground: bool) -> "Record":
    from ..ground_motion.records import read_record  # noqa: PLC0415

    if load is None:
        raise ValueError("expected --load, a file of two columns, time (s) and load, got none; give it")
    return read_record(load, unit=None if ground else 1.0)  # a load at degrees of freedom has units of its own


def _structure(
    mass: Path, stiffness: Path, record: "Record", at: list[int], ground: bool, fixed: list[int]
) -> "Structure":
    """The structure of two files under a load at some degrees of freedom, or on a ground that moves them along."""
    from ..structures.readers import read_matrix  # noqa: PLC0415 (SciPy)
    from ..structures.structure import structure  # noqa: PLC0415

    if not at:
        raise ValueError("expected --at, the degrees of freedom of the load, as 0,3, counted from 0, got none")
    K = read_matrix(stiffness)
    M = read_matrix(mass, size=K.shape[0])
    if not ground:
        return structure(M, K, fixed=fixed, load=({dof: 1.0 for dof in at}, record))
    base = structure(M, K, fixed=fixed)
    direction = np.zeros(M.shape[0])
    direction[[base.place(dof) for dof in at]] = 1.0
    return base.ground_motion(record, direction)
