"""`conrod lint`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.commands import exit_status, options
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.engines.mujoco.lint.finding import Report
    from conrod.engines.mujoco.lint.request import Request
    from conrod.files import Batch
    from conrod.scenes import Scene

REVOLUTIONS = 2  # of a crank that a scene tells the speed of


@click.command()
@click.argument("model", metavar="MODEL.xml")
@click.option("--scene", metavar="SCENE", help="Drive the crank at the speed that this machine has.")
@options.assignments
@click.option("--crank", metavar="JOINT", help="With --scene: the hinge that is driven [the only one on the frame].")
@click.option(
    "--point", "points", multiple=True, metavar="NAME=site:SITE", help="Observe this, e.g. C=body:slider [every body]."
)
@click.option("--keyframe", metavar="KEY", help="Start from it, by name or number; qpos0 for none [the first].")
@click.option("--seconds", type=float, metavar="T", help="How long to run [2000 steps; 2 turns of the crank].")
@click.option("--ignore", "ignored", multiple=True, metavar="RULE", help="Leave a rule out.")
@click.option("--json", "document", metavar="FILE", help="Write what was found as JSON.")
@click.option("--fix", "fixed", metavar="OUT.xml", help="Write the model with the safe fixes made.")
def lint(
    model: str,
    scene: str | None,
    assignments: tuple[str, ...],
    crank: str | None,
    points: tuple[str, ...],
    keyframe: str | None,
    seconds: float | None,
    ignored: tuple[str, ...],
    document: str | None,
    fixed: str | None,
) -> None:
    """What a MuJoCo model carries that its motion does not need, and what will bite.

    The model is run, and run again without what is looked at; the file is only read.

    Exit status 0: no findings; 1: findings; 2: bad usage.
    """
    from conrod.confined import confined
    from conrod.engines.mujoco.lint.linting import lint as look
    from conrod.files import naming, write_together
    from conrod.lint_console import print_report

    path = Path(model)
    json_file, out = _outputs(path, document, fixed)
    machine = _machine(scene, assignments)
    folder = None if out is None else str(_folder(out))
    request = _request(machine, crank, points, keyframe, seconds, ignored, folder)
    report = confined(look, path, request)
    with naming("standard output"):
        print_report(report, out)
    write_together(_batches(report, json_file, out))
    if report.findings:
        sys.exit(exit_status.FAILED)


def _outputs(model: Path, document: str | None, fixed: str | None) -> tuple[Path | None, Path | None]:
    """Files to write, refused before any work where something would be lost by them."""
    from conrod.files import check_apart, file_to_write
    from conrod.model_files import as_outputs_must_not_be

    json_file = None if document is None else file_to_write(document, "--json")
    out = None if fixed is None else file_to_write(fixed, "--fix")
    files = as_outputs_must_not_be(model)
    check_apart(files | {name: file for name, file in (("--json", json_file), ("--fix", out)) if file is not None})
    return json_file, out


def _folder(file: Path) -> Path:
    from conrod.files import real_path

    return real_path(file).parent


def _machine(name: str | None, assignments: tuple[str, ...]) -> Scene | None:
    from conrod.selection import select_scene

    if name is None:
        if assignments:
            raise InvalidInput(f"--set {assignments[0]}: it is a parameter of what --scene names")
        return None
    return select_scene(name, assignments)[1]


def _request(
    machine: Scene | None,
    crank: str | None,
    points: tuple[str, ...],
    keyframe: str | None,
    seconds: float | None,
    ignored: tuple[str, ...],
    folder: str | None,
) -> Request:
    from conrod.commands.places import places_of
    from conrod.engines.mujoco.lint.request import Request
    from conrod.ranges import check_number

    if seconds is not None:
        check_number("--seconds", seconds, 1e-9, 1e9, "s")
    speed = None
    if machine is not None:
        speed = machine.speed
        seconds = seconds or REVOLUTIONS * 2.0 * math.pi / abs(speed)
    elif crank is not None:
        raise InvalidInput(f"--crank {crank}: say with --scene how fast it turns")
    observed = [] if machine is None else [point.name for point in machine.kinematics.mechanism.observed]
    return Request(keyframe, seconds, crank, speed, places_of(points, observed), ignored, folder)


def _batches(report: Report, document: Path | None, out: Path | None) -> list[Batch]:
    import json

    from conrod.files import single

    batches = []
    if document is not None:
        batches.append(single(document, json.dumps(report.as_dict(), indent=1, allow_nan=False) + "\n"))
    if out is not None and report.fixed is not None and report.fixed.text:
        batches.append(single(out, report.fixed.text))
    return batches
