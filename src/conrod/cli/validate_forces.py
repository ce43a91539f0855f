"""What `conrod validate --quantity` prints, and its progress.

`conrod validate --quantity`: forces in scenes by engines' accounts.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import replace

from conrod.cli import options as exit_status
from conrod.cli.options import RunOptions
from conrod.cli.outputs import outputs
from conrod.errors import InvalidInput, unknown_choice
from conrod.report.force_words import hidden_words, tolerance_reasons, unseen_words
from conrod.report.forces import KIND, ForceFindings, force_findings, verdicts_table
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import Scene
from conrod.studies.forces.exact import GROUPS


def print_force_verdicts(found: Sequence[ForceFindings]) -> None:
    """A line for each result: largest errors, observed orders, verdict; then what no quantity shows of a wrong mass."""
    out = console()
    print_table(out, verdicts_table(found), folding=("verdict",))
    print_lines(out, (f"tolerance: {reason}" for reason in tolerance_reasons(r for one in found for r in one.results)))
    for one in found:
        unseen = [*unseen_words(one.effects), *hidden_words(one.hidden)]
        if unseen:
            print_lines(out, [f"{one.name}: no quantity depends on: {'; '.join(unseen)}"])


DEFAULT_REVOLUTIONS = 2


def validate_forces(
    scenes: tuple[str, ...],
    quantity: str,
    how: RunOptions,
    *,
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int | None,
    assignments: tuple[str, ...],
    tolerance: str | None,
    out: str | None,
    document: str | None,
    figures: str | None,
) -> None:
    """Compare drive torque, reactions and contact forces of engines with the exact ones."""
    from conrod.cli.reproduction import reproduction
    from conrod.cli.runner import Runner
    from conrod.studies.forces.study import ForcePlan, force_study
    from conrod.studies.frame.files import naming
    from conrod.studies.frame.resolve_arguments import (
        make_plan,
        parse_tolerance,
        select_engines,
        select_presets,
        select_scenes,
    )

    if figures is not None:
        raise InvalidInput("--figures does not go with --quantity: its report has one figure")
    chosen = select_scenes(scenes, assignments)
    asked = _quantities(quantity, chosen)
    engines = select_engines(engine)
    presets = select_presets(engines, preset)
    turns = DEFAULT_REVOLUTIONS if revolutions is None else revolutions
    allowed = None if tolerance is None else parse_tolerance(tolerance, asked)
    plan = ForcePlan(replace(make_plan(chosen, steps_per_rev, turns, None), tolerance=allowed), asked)
    files = outputs(KIND, chosen, out, document)
    options = {
        "--quantity": quantity,
        "--engine": engine,
        "--preset": preset,
        "--steps-per-rev": steps_per_rev,
        "--revolutions": None if turns == DEFAULT_REVOLUTIONS else turns,
        "--tolerance": tolerance,
    }
    with Runner.of(how, files.file) as runner:
        found = [force_findings(study) for study in runner.pursue(force_study(chosen, engines, presets, plan))]
    with naming("standard output"):
        print_force_verdicts(found)
    command = reproduction("validate", scenes, options, assignments, files.folder) if files.folder else None
    files.write({one.name: one for one in found}, command)
    if not all(one.passed for one in found):
        sys.exit(exit_status.FAILED)


def _quantities(text: str, scenes: Mapping[str, Scene]) -> tuple[str, ...]:
    """The groups of quantities that were asked for, in their usual order.

    Raises:
        InvalidInput: an unknown one, one named twice, or contact where no scene has any.
    """
    given = [name.strip() for name in text.split(",")]
    for name in given:
        if name not in GROUPS:
            raise unknown_choice("quantity", name, GROUPS)
        if given.count(name) > 1:
            raise InvalidInput(f"--quantity {text}: {name} is named twice")
    if given == ["contact"] and not any(scene.kinematics.mechanism.cam_contacts for scene in scenes.values()):
        raise InvalidInput(f"--quantity contact: no joint of {', '.join(scenes)} acts by contact")
    return tuple(name for name in GROUPS if name in given)
