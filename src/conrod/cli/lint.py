"""What `conrod lint` prints.

`conrod lint`.
"""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click
from rich.console import Console

from conrod.cli import options
from conrod.cli import options as exit_status
from conrod.cli.console import console
from conrod.errors import InvalidInput
from conrod.mjcf.lint.findings import Finding, Fixed, Harm, Report, Value
from conrod.studies.frame.paired_timing import PairedCost

if TYPE_CHECKING:
    from conrod.mjcf.lint.findings import Report, Request
    from conrod.scenes import Scene
    from conrod.studies.frame.files import Batch

COLOURS = {Harm.WRONG: "red", Harm.LATENT: "yellow", Harm.WASTE: "cyan"}


def print_report(report: Report, out_file: Path | None) -> None:
    """A block for each finding, the most harmful first, then what is good to know."""
    out = console()
    out.print(f"{report.model}: {report.run}", markup=False, soft_wrap=True)
    for finding in report.findings:
        _print_finding(out, finding)
    if report.notes:
        out.print("\nnoted, no findings:")
    for note in report.notes:
        cost = "" if note.cost is None else f"; {_cost(note.cost)}"
        out.print(f"  {note.rule}: {note.what}{cost}", markup=False, soft_wrap=True)
    number = len(report.findings)
    out.print(f"\n{number or 'no'} finding{'' if number == 1 else 's'}")
    if report.fixed is not None:
        _print_fixed(out, report.fixed, out_file)


def _print_finding(out: Console, finding: Finding) -> None:
    out.print(f"\n[{COLOURS[finding.harm]}]{finding.rule}[/] ({finding.harm.meaning})", soft_wrap=True)
    lines = [
        finding.what,
        "evidence: " + "; ".join(f"{name} {_value(value)}" for name, value in finding.evidence.items()),
    ]
    if finding.cost is not None:
        lines.append(f"cost: {_cost(finding.cost)}")
    lines += [f"why: {finding.why}", f"fix: {finding.fix}"]
    lines += [f"     {edit.words}" for edit in finding.edits]
    if finding.edits:
        lines.append("safe: --fix makes it" if finding.safe else "not made by --fix: say yourself which was meant")
    for line in lines:
        out.print(f"  {line}", markup=False, soft_wrap=True)


def _print_fixed(out: Console, fixed: Fixed, file: Path | None) -> None:
    if not fixed.text:
        out.print(f"nothing can be fixed safely; {file} is not written", markup=False, soft_wrap=True)
        return
    number = len(fixed.edits)
    moved = "did not change" if fixed.change == 0.0 else f"changed by {_value(fixed.change)} of its travel"
    cost = "" if fixed.cost is None else f"; the original takes {_cost(fixed.cost)} of it"
    out.print(
        f"{file}: {number} edit{'' if number == 1 else 's'}; the motion {moved}{cost}", markup=False, soft_wrap=True
    )


def _cost(cost: PairedCost) -> str:
    seen = "" if not cost.low <= 1.0 <= cost.high else ", no difference seen"
    return f"{cost.ratio:.2f} x a step ({cost.low:.2f} to {cost.high:.2f}{seen})"


def _value(value: Value) -> str:
    if isinstance(value, float):
        return "beyond all bounds" if value >= 1e300 else f"{value:.4g}"
    return str(value)


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
    from conrod.mjcf.lint.linting import lint as look
    from conrod.studies.execution.confined import confined
    from conrod.studies.frame.files import naming, write_together

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
    from conrod.own.models.model_files import as_outputs_must_not_be
    from conrod.studies.frame.files import check_apart, file_to_write

    json_file = None if document is None else file_to_write(document, "--json")
    out = None if fixed is None else file_to_write(fixed, "--fix")
    files = as_outputs_must_not_be(model)
    check_apart(files | {name: file for name, file in (("--json", json_file), ("--fix", out)) if file is not None})
    return json_file, out


def _folder(file: Path) -> Path:
    from conrod.studies.frame.files import real_path

    return real_path(file).parent


def _machine(name: str | None, assignments: tuple[str, ...]) -> Scene | None:
    from conrod.studies.frame.resolve_arguments import select_scene

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
    from conrod.cli.model_request import places_of
    from conrod.mechanism.units import check_number
    from conrod.mjcf.lint.findings import Request

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

    from conrod.studies.frame.files import single

    batches = []
    if document is not None:
        batches.append(single(document, json.dumps(report.document(), indent=1, allow_nan=False) + "\n"))
    if out is not None and report.fixed is not None and report.fixed.text:
        batches.append(single(out, report.fixed.text))
    return batches
