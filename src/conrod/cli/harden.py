"""`conrod harden`."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.cli import options as exit_status
from conrod.errors import InvalidInput, unknown_choice

if TYPE_CHECKING:
    from conrod.mjcf.harden.results import HardenedModel
    from conrod.studies.frame.files import Batch

BINARY = ".mjb"
MODELS = (".xml", ".mjcf", ".urdf", BINARY)
SECONDS = 1.0
AUTO, KEEP = "auto", "keep"
INTEGRATORS = ("RK4", KEEP)


@click.command()
@click.argument("model", metavar="MODEL.xml")
@click.option("-o", "--output", metavar="FILE.mjb", help="Write the hardened model there [not written].")
@click.option("--keyframe", metavar="KEY", help="Start from it, by name or number; qpos0 for none [the first].")
@click.option("--seconds", type=float, default=SECONDS, show_default=True, metavar="S", help="How long the runs are.")
@click.option(
    "--solref",
    default=AUTO,
    metavar="SECONDS|keep",
    help="Time constant of the closures [the model's own, at least ten steps].",
)
@click.option("--integrator", default="RK4", show_default=True, metavar="RK4|keep", help="Of the hardened model.")
@click.option("--force", is_flag=True, help="Harden what seems to be soft on purpose, or breaks off when hard.")
@click.option("--json", "document", metavar="FILE", help="Write the figures as JSON.")
def harden(
    model: str,
    output: str | None,
    keyframe: str | None,
    seconds: float,
    solref: str,
    integrator: str,
    force: bool,
    document: str | None,
) -> None:
    """Make the closed loops of a MuJoCo model stay closed, and show what that changes.

    Takes the regularisation out of the equality constraints of a compiled model, which MJCF cannot express: prints the
    lines of Python that do it, and writes a binary model. Runs the model as it is, with the weights scaled alone, and
    hardened; nothing drives it, controls are 0. MODEL.xml itself is only read.

    Exit status 0: hardened; 1: it is not, for the reason told (nothing to harden, soft on purpose, it would break);
    2: bad usage.
    """
    from conrod.studies.frame.files import naming, write_together

    path = Path(model)
    file, results = _checked_outputs(path, output, document)
    found = _found(path, keyframe, seconds, solref, integrator, force, content=file is not None)
    with naming("standard output"):
        from conrod.cli.harden_console import print_hardened

        print_hardened(found, file)
    write_together(_batches(found, file, results))
    if found.refusals:
        sys.exit(exit_status.FAILED)


def _found(
    path: Path, keyframe: str | None, seconds: float, solref: str, integrator: str, force: bool, *, content: bool
) -> HardenedModel:
    from conrod.mjcf.harden.results import Request

    if integrator not in INTEGRATORS:
        raise unknown_choice("--integrator", integrator, INTEGRATORS)
    if not (math.isfinite(seconds) and seconds > 0.0):
        raise InvalidInput(f"--seconds {seconds:g}: give a finite number above 0")
    constant = solref if solref in (AUTO, KEEP) else _seconds(solref)

    from conrod.mjcf.harden.study import harden_file
    from conrod.studies.execution.confined import confined

    return confined(harden_file, path, Request(keyframe, seconds, constant, integrator, force, content))


def _seconds(text: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not (math.isfinite(value) and value > 0.0):
        raise InvalidInput(f"--solref {text!r}: give a time constant in seconds above 0, or {KEEP}")
    return value


def _checked_outputs(path: Path, output: str | None, document: str | None) -> tuple[Path | None, Path | None]:
    """The files to write, refused before any work where one would be lost by another."""
    from conrod.own.models.model_files import as_outputs_must_not_be
    from conrod.studies.frame.files import check_apart, file_to_write

    file = None if output is None else file_to_write(output, "-o")
    results = None if document is None else file_to_write(document, "--json")
    if file and file.suffix.lower() != BINARY:
        raise InvalidInput(f"-o {file}: a hardened model can only be binary, e.g. {file.with_suffix(BINARY)}")
    if results and results.suffix.lower() in MODELS:
        raise InvalidInput(f"--json {results}: this is the name of a model, e.g. {results.with_suffix('.json')}")
    written = {name: given for name, given in (("-o", file), ("--json", results)) if given is not None}
    check_apart(as_outputs_must_not_be(path) | written)
    return file, results


def _batches(found: HardenedModel, file: Path | None, results: Path | None) -> list[Batch]:
    import json

    from conrod.studies.frame.files import single

    batches = []
    if file and found.content is not None:
        batches.append(single(file, found.content))
    if results:
        batches.append(single(results, json.dumps(found.document(), indent=1, allow_nan=False) + "\n"))
    return batches
