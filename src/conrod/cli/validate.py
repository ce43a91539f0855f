"""`conrod validate`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import click

from conrod.cli import options
from conrod.cli.options import RunOptions, refuse
from conrod.cli.validate_request import FMUS, MODELS, TABLES, ModelOptions, MotionOptions, Request, TableOptions
from conrod.errors import InvalidInput
from conrod.own.files import check_readable

MECHANISMS = ".toml"
FILES = MODELS + TABLES + FMUS


@options.verb()
@click.argument("subjects", nargs=-1, metavar="[SCENE | FILE]...")
@options.gathered("asked", Request)
def validate(asked: Request) -> None:
    """Compare engines with the exact motion of SCENEs, or judge a FILE.

    All scenes that have a closed form are compared where none is named. A SCENE is one that `conrod show` lists, or a
    mechanism file of one's own (.toml); the word `catalogue` stands for all machines of the catalogue. Results are kept
    in the ledger: the same command goes on where it stopped, and asked again it runs nothing.

    A FILE is judged instead, against the machine that --scene names: a MuJoCo model (.xml, .mjb), an FMU, which is run
    (.fmu), or a table of any tool (.csv, .npz and the like). A MuJoCo model with closed loops needs no --scene: with
    --drive its own exact motion is what it is held to. So are machines in space, by name, or all as `spatial`.

    Exit status 0: all judged results are within tolerance; 1: something is not; 2: bad usage.
    """
    if asked.motion is not None or asked.quantity is not None:
        refuse(asked, "--motion and --quantity: it is on the motion at constant speed", "report")
    if asked.invariances:
        from conrod.cli.validate_invariances import validate_invariances

        validate_invariances(asked)
        return
    if _is_spatial(asked):
        from conrod.cli.validate_loops import validate_loops

        validate_loops(asked)
        return
    files = [name for name in asked.subjects if name.lower().endswith(FILES)]
    if files:
        _validate_file(files[0], asked)
        return
    _check_endings(asked.subjects, asked.scene)
    refuse(asked, "a scene: it is for a file", ModelOptions, *(() if asked.measured else (TableOptions,)))
    if asked.scene is not None:
        name = asked.scene
        raise InvalidInput(f"--scene {name} is for a file; a scene is named as it is: conrod validate {name}")
    if asked.motion is None:
        refuse(asked, "a crank at constant speed: it is for --motion free and --motion torque", MotionOptions)
    else:
        refuse(asked, "--motion: it is for a crank at constant speed", "qualify")
        refuse(asked, "--motion: forces are compared at constant crank speed", "quantity")
    from conrod.cli.validate_scenes import validate_scenes

    validate_scenes(asked)


def _validate_file(file: str, asked: Request) -> None:
    """Judge a user's own model or table.

    Raises:
        InvalidInput: also where options were given that are not for it.
    """
    check_readable(Path(file))
    if len(asked.subjects) > 1:
        others = [name for name in asked.subjects if name != file]
        said = f"without {others[0]}" if others else "but it is named twice"
        raise InvalidInput(f"{file}: a file is judged on its own, {said}")
    if asked.scene is None:
        raise InvalidInput(f"{file}: say with --scene what machine it is; `conrod show` lists them")
    refuse(asked, "--scene: it is for a model that is its own reference", "drives")
    limited = ("ledger", "fresh", "jobs", "cluster", "cell_memory") if file.lower().endswith(FMUS) else (RunOptions,)
    refuse(asked, "a file: it is for scenes", MotionOptions, *limited, "quantity")
    from conrod.cli.validate_file import validate_file

    validate_file(Path(file), asked.scene, asked)


def _is_spatial(asked: Request) -> bool:
    """True if spatial machines are named, or MuJoCo models that are their own reference or to be one in space."""
    from conrod.scenes.space import MACHINES, SPATIAL

    names = [name for name in asked.subjects if name in (*MACHINES, SPATIAL)]
    models = bool(asked.subjects) and all(name.lower().endswith(MODELS) for name in asked.subjects)
    scene = asked.scene
    if names and len(names) < len(asked.subjects):
        other = next(name for name in asked.subjects if name not in names)
        raise InvalidInput(f"{names[0]} is a machine in space, {other} is not: they are validated one after the other")
    return bool(names) or (models and (scene is None or scene in MACHINES or scene.lower().endswith(MODELS)))


def _check_endings(subjects: Sequence[str], scene: str | None) -> None:
    """Refuse a file of no kind that can be judged, which is no scene either."""
    for name in subjects:
        if name.lower().endswith(MECHANISMS):
            continue
        if Path(name).is_file() or (scene is not None and Path(name).suffix):
            raise _unknown_ending(name)


def _unknown_ending(name: str) -> InvalidInput:
    return InvalidInput(f"{name}: a file is known by its ending, one of {', '.join(FILES)}; save a sheet as CSV")


def check_file(path: Path) -> None:
    """Refuse what is no file that can be judged; raises InvalidInput, which says why."""
    check_readable(path)
    if not path.name.lower().endswith(FILES):
        raise _unknown_ending(str(path))
