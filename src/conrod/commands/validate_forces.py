"""`conrod validate --quantity`: forces in scenes by engines' accounts."""

from __future__ import annotations

import sys
from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import click

from conrod.commands import exit_status
from conrod.errors import InvalidInput, unknown_choice

if TYPE_CHECKING:
    from conrod.scenes import Scene

DEFAULT_REVOLUTIONS = 2


def validate_forces(
    scenes: tuple[str, ...],
    quantity: str,
    *,
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int | None,
    assignments: tuple[str, ...],
    jobs: int | None,
    tolerance: str | None,
    out: str | None,
    document: str | None,
    figures: str | None,
) -> None:
    """Compare drive torque, reactions and contact forces of engines with the exact ones."""
    from conrod.commands.reproduction import reproduction
    from conrod.commands.runner import available_cores
    from conrod.execution.local import LocalProcesses
    from conrod.files import file_to_write, folder_to_write, naming, single, write_together
    from conrod.force_console import print_force_verdicts, run_forces
    from conrod.report.forces.folder import check_force_files, index_of
    from conrod.report.forces.writer import force_report_batch
    from conrod.selection import make_plan, parse_tolerance, select_engines, select_presets, select_scenes
    from conrod.studies.forces.document import forces_text
    from conrod.studies.forces.study import ForcePlan

    if figures is not None:
        raise InvalidInput("--figures does not go with --quantity: its report has one figure")
    chosen = select_scenes(scenes, assignments)
    asked = _quantities(quantity, chosen)
    engines = select_engines(engine)
    presets = select_presets(engines, preset)
    turns = DEFAULT_REVOLUTIONS if revolutions is None else revolutions
    allowed = None if tolerance is None else parse_tolerance(tolerance, asked)
    plan = ForcePlan(replace(make_plan(chosen, steps_per_rev, turns, None), tolerance=allowed), asked)
    folder = None if out is None else folder_to_write(out, "--out")
    file = None if document is None else file_to_write(document, "--json")
    if folder:
        check_force_files(folder, chosen, file)
    options = {
        "--quantity": quantity,
        "--engine": engine,
        "--preset": preset,
        "--steps-per-rev": steps_per_rev,
        "--revolutions": None if turns == DEFAULT_REVOLUTIONS else turns,
        "--tolerance": tolerance,
    }
    with LocalProcesses(available_cores() if jobs is None else jobs) as executor:
        studies = run_forces(chosen, engines, presets, plan, executor)
    with naming("standard output"):
        print_force_verdicts(studies)
    batches = [single(file, forces_text(studies))] if file else []
    if folder:
        command = reproduction("validate", scenes, options, assignments, folder)
        batches.append(force_report_batch(studies, folder, command))
    write_together(batches)
    if folder:
        click.echo(f"report: {folder / index_of([study.name for study in studies])}")
    if not all(study.passed for study in studies):
        sys.exit(exit_status.FAILED)


def _quantities(text: str, scenes: Mapping[str, Scene]) -> tuple[str, ...]:
    """The groups of quantities that were asked for, in their usual order.

    Raises:
        InvalidInput: an unknown one, one named twice, or contact where no scene has any.
    """
    from conrod.studies.forces.names import GROUPS

    given = [name.strip() for name in text.split(",")]
    for name in given:
        if name not in GROUPS:
            raise unknown_choice("quantity", name, GROUPS)
        if given.count(name) > 1:
            raise InvalidInput(f"--quantity {text}: {name} is named twice")
    if given == ["contact"] and not any(scene.kinematics.mechanism.cam_contacts for scene in scenes.values()):
        raise InvalidInput(f"--quantity contact: no joint of {', '.join(scenes)} acts by contact")
    return tuple(name for name in GROUPS if name in given)
