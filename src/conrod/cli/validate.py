"""`conrod validate`."""

from __future__ import annotations

import shlex
import sys
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.cli import FAILED, options
from conrod.cli.options import refuse
from conrod.cli.validate_request import FMUS, MODELS, PAGES, TABLES, Judging, Request
from conrod.errors import InvalidInput
from conrod.own.files import check_readable

if TYPE_CHECKING:
    from conrod.cli.baseline import Holding

MECHANISMS = ".toml"
FILES = MODELS + TABLES + FMUS


@options.verb(Request)
@click.argument("subjects", nargs=-1, metavar="[SCENE | FILE]...")
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
    from conrod.cli.outputs import outputs
    from conrod.report.terminal import tell

    work, dossier = judging_of(asked), None
    holding = holding_of(asked, work)
    files = outputs(work.kind, work.parts, asked, work.inputs)
    if asked.report is None:
        refuse(asked, "no --report", PAGES)
    else:
        from conrod.cli.verification import Dossier

        dossier = Dossier.of(asked, work)
    own = replace(asked, fresh=True) if holding else asked
    (found,) = work.judge(own, [work.scenes])
    held = holding.held(work.judge, own, found) if holding else None
    files.answer(dict(zip(work.parts, found, strict=True)), work.told(found), "validate", work.typed)
    if dossier:
        dossier.write(found[0], work.verdict(found[0]))
    if held:
        accept = [] if held.passed or held.written else [shlex.join(["conrod", *sys.argv[1:], "--accept"])]
        tell([*held.text.splitlines(), *(f"accept it: {line}" for line in accept)])
    if any(one.passed is False for one in found) or (held and not held.passed):
        sys.exit(FAILED)


def holding_of(asked: Request, work: Judging) -> Holding | None:
    """The baseline that is asked for; raises InvalidInput where it cannot be read or written, or is of others."""
    if asked.baseline is None:
        if asked.accept:
            raise InvalidInput("--accept: it is for a baseline, name its file with --baseline")
        return None
    from conrod.cli.baseline import Holding

    return Holding.of(Path(asked.baseline), asked, work.scenes)


def judging_of(asked: Request) -> Judging:
    """What is to be judged.

    Raises:
        InvalidInput: it cannot be, or an option does not go with it.
    """
    if asked.motion is not None or asked.quantity is not None:
        refuse(asked, "--motion and --quantity: it is on the motion at constant speed", "report")
    if asked.invariances:
        from conrod.cli.validate_invariances import judging
    elif _is_spatial(asked):
        from conrod.cli.validate_loops import judging
    elif any(name.lower().endswith(FILES) for name in asked.subjects):
        from conrod.cli.validate_file import judging
    else:
        _check_endings(asked)
        from conrod.cli.validate_scenes import judging
    return judging(asked)


def _is_spatial(asked: Request) -> bool:
    """True if spatial machines are named, or MuJoCo models that are their own reference or to be one in space."""
    from conrod.scenes.space import MACHINES, SPATIAL

    names = [name for name in asked.subjects if name in (*MACHINES, SPATIAL)]
    models = bool(asked.subjects) and all(name.lower().endswith(MODELS) for name in asked.subjects)
    if names and len(names) < len(asked.subjects):
        other = next(name for name in asked.subjects if name not in names)
        raise InvalidInput(f"{names[0]} is a machine in space, {other} is not: they are validated one after the other")
    scene = asked.scene
    return bool(names) or (models and (scene is None or scene in MACHINES or scene.lower().endswith(MODELS)))


def _check_endings(asked: Request) -> None:
    """Refuse a file of no kind that can be judged, which is no scene either, and what is for a file."""
    for name in asked.subjects:
        if name.lower().endswith(MECHANISMS):
            continue
        if Path(name).is_file() or (asked.scene is not None and (Path(name).suffix or Path(name).is_dir())):
            check_readable(Path(name))
            known = ", ".join(FILES)
            raise InvalidInput(f"{name}: a file is known by its ending, one of {known}; save a sheet as CSV")
    if asked.scene is not None:
        raise InvalidInput(f"--scene {asked.scene} is for a file; a scene is named as it is")
