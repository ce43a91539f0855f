"""`conrod harden`."""

from __future__ import annotations

import math
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import click

from conrod.cli import FAILED, completion, options, waiting
from conrod.cli.options import controls_in, option
from conrod.comparison.plain_values import json_document
from conrod.errors import InvalidInput
from conrod.execution.files import files_to_write
from conrod.execution.writing import single_file, write_together
from conrod.mechanism.units import MM
from conrod.models.harden.results import HardenedModel, in_mm
from conrod.report.table import Verbatim
from conrod.report.terminal import PrintedPart, print_parts
from conrod.user_files import MODELS
from conrod.user_files.files import check_model_readable, protected_model_files

BINARY = ".mjb"
ALWAYS = (
    "run the lines again after mj_setConst, which makes the weights anew",
    "for double precision only; docs/hardening.md says why, and what hardens with the loops",
)


@dataclass(frozen=True)
class HardenOptions:
    """Options of `conrod harden`, as typed; None or empty where nothing was given."""

    output: str | None = option("-o --output", metavar="FILE.mjb", help="Write the hardened model there [not written].")
    keyframe: str | None = option("--keyframe")
    seconds: float | None = option("--seconds", type=float, metavar="S", help="Duration of the runs [1].")
    controls: tuple[str, ...] = option("--ctrl")
    unit: str | None = option("--unit", metavar="UNIT", help="Of the model's lengths: m, cm, mm or inch [m].")
    force: bool = option(
        "--force", is_flag=True, help="Harden what seems to be soft on purpose, or breaks off when hard."
    )
    document: str | None = option("--json")


@options.verb(HardenOptions)
@click.argument("model", metavar="MODEL.xml", shell_complete=completion.files_with(MODELS))
def harden(model: str, asked: HardenOptions) -> None:
    """Make the closed loops of a MuJoCo model stay closed, and show what that changes.

    Takes the regularisation out of the equality constraints of a compiled model, which MJCF cannot express: prints the
    lines of Python that do it, and writes a binary model. Runs the model as it is and hardened, from its first keyframe
    or the one given, with its controls or those given. MODEL.xml itself is only read.

    Exit status 0: hardened; 1: it is not, for the reason given (nothing to harden, soft on purpose, it would break);
    2: bad usage.
    """
    path = Path(model)
    check_model_readable(path, "harden")
    files = files_to_write({"-o": asked.output, "--json": asked.document}, protected_model_files(path))
    if (file := files.get("-o")) and file.suffix.lower() != BINARY:
        raise InvalidInput(f"-o {file}: a hardened model can only be binary, e.g. {file.with_suffix(BINARY)}")
    if asked.seconds is not None and not (math.isfinite(asked.seconds) and asked.seconds > 0.0):
        raise InvalidInput(f"--seconds {asked.seconds:g}: give a finite number above 0")
    controls = controls_in(asked.controls)

    from conrod.execution.local import FILE_TIMEOUT
    from conrod.models.harden.api import harden

    with waiting(path, FILE_TIMEOUT):
        found = harden(
            path,
            keyframe=asked.keyframe,
            controls=controls,
            seconds=asked.seconds,
            force=asked.force,
            write="-o" in files,
            unit=asked.unit,
        )
    print_parts(hardening_to_print(found, files.get("-o")))
    contents: dict[str, str | bytes | None] = {"-o": found.content, "--json": json_document(found.document())}
    write_together(
        [single_file(file, text) for option, file in files.items() if (text := contents[option]) is not None]
    )
    if found.refusals:
        sys.exit(FAILED)


# -- printing ----------------------------------------------------------------------------------------------------------


def hardening_to_print(found: HardenedModel, file: Path | None) -> Iterator[PrintedPart]:
    """Figures before and after hardening, lines to paste and notes; or why nothing was hardened."""
    if found.variants:
        begin = "the runs start with them closed" if found.start_closed else "and so the runs start"
        run = f"{found.seconds:.4g} s in steps of {found.timestep:g} s from {found.start}"
        yield f"{found.path}: MuJoCo {found.mujoco}, {run}; size {MM * found.size:.4g} mm"
        yield from (f"its loops are open by {in_mm(found.start_opening)} mm there; {begin}", "")
        yield from found.tables()
        yield from _reading_words(found)
    if found.lines and not found.refusals:
        yield from ("", "in Python:", "", Verbatim(found.lines))
    yield from (f"not hardened: {refusal}" for refusal in found.refusals)
    yield from (f"note: {note}" for note in (*found.warnings, *(() if found.refusals else ALWAYS)))
    if not found.refusals:
        yield f"the hardened model: {file}" if file else "nothing written: -o FILE.mjb writes the model"


def _reading_words(found: HardenedModel) -> Iterator[str]:
    """Explanation of the figures."""
    if found.reference_known_to is None or found.travel is None:
        yield "drift: none, the reference (hardened, RK4, a sixteenth of the step) breaks off"
    else:
        known = f"which is known to {in_mm(found.reference_known_to)} mm (-: less than that)"
        at = "extrapolated to a step of zero" if found.reference_extrapolated else "at a sixteenth of the step"
        reference = f"from the hardened model under RK4 {at}"
        yield f"drift: of any body's centre of gravity, {reference}, {known}; travel {MM * found.travel:.3g} mm"
    if cost := found.cost:
        size = f"{cost.ratio:.2f} ({cost.low:.2f} to {cost.high:.2f}), {1e6 * cost.seconds:.3g} µs on this machine"
        yield f"cost of a step, hardened over as it is: {size}"
