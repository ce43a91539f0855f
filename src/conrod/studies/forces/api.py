"""Forces: torque of the crank, reactions of joints and contact forces at constant crank speed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from conrod.errors import InvalidInput, as_names, unknown_choice
from conrod.execution.baseline_check import BaselineCheck, scene_lines
from conrod.execution.resolve_arguments import (
    Engines,
    Scenes,
    choose_engines,
    engine_names_given,
    make_plan,
    scenes_by_name,
    select_presets,
)
from conrod.execution.result import presets_study
from conrod.execution.runner import Runner, Runs
from conrod.execution.tolerances import check_tolerance
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.studies.forces.report import FORCES_REPORT
from conrod.studies.forces.results import GROUPS, ForceStudy
from conrod.studies.forces.study import ForceCase, ForcePlan

REVOLUTIONS = 2


def forces(
    scenes: Scenes = (),
    *,
    quantities: str | Sequence[str] | None = None,
    engines: Engines = None,
    preset: str | None = None,
    steps_per_rev: int | None = None,
    revolutions: int = REVOLUTIONS,
    tolerance: Mapping[str, float | str] | None = None,
    baseline: str | Path | None = None,
    accept: bool = False,
    runs: Runs | None = None,
) -> Findings[ForceStudy]:
    """Compare the forces that engines report with the exact ones, at constant crank speed.

    Args:
        quantities: of "torque", "reactions" and "contact"; torque and reactions, and contact where a scene has any,
            where none is given.
        tolerance: largest error by quantity, over the largest exact force of its kind.
        scenes, engines, preset, steps_per_rev, revolutions, baseline, accept, runs: as in `validate`.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    runs = runs or Runs()
    chosen, chosen_engines = scenes_by_name(scenes), choose_engines(engines)
    quantities = None if quantities is None else as_names(quantities)
    presets, asked = select_presets(chosen_engines, preset), check_quantities(quantities, chosen)
    allowed = None if tolerance is None else check_tolerance(tolerance, asked)
    steps = make_plan(chosen, steps_per_rev, revolutions, None)
    plan = ForcePlan(steps.steps_per_revolution, steps.revolutions, allowed, asked)
    options: dict[str, Any] = {
        "engine": engine_names_given(engines),
        "preset": preset,
        "quantity": ",".join(quantities or asked),
    }
    options |= {"steps-per-rev": steps_per_rev, "revolutions": None if revolutions == REVOLUTIONS else revolutions}
    baseline_check = None
    if baseline or accept:
        baseline_check = BaselineCheck.prepare(baseline, chosen, options, accept=accept)
    runs = replace(runs, fresh=True) if baseline_check else runs

    def find(several: Sequence[Mapping[str, Scene]]) -> list[Sequence[ForceStudy]]:
        with Runner.open(runs) as runner:
            return runner.pursue([presets_study(ForceCase, one, chosen_engines, presets, plan) for one in several])

    (found,) = find([chosen])
    compared = baseline_check.compare(found, find, scene_lines) if baseline_check else None
    call = text_of_call(
        "forces",
        list(chosen),
        quantities=asked,
        engines=engine_names_given(engines),
        preset=preset,
        steps_per_rev=steps_per_rev,
        revolutions=options["revolutions"],
        tolerance=tolerance,
    )
    return Findings(FORCES_REPORT, {study.name: study for study in found}, call, baseline=compared)


def check_quantities(names: Sequence[str] | None, scenes: Mapping[str, Scene]) -> tuple[str, ...]:
    """Groups of forces in their usual order.

    Raises:
        InvalidInput: an unknown one, one named twice, or contact where no scene has any.
    """
    touching = any(scene.kinematics.mechanism.cam_contacts for scene in scenes.values())
    if names is None:
        return tuple(name for name in GROUPS if touching or name != "contact")
    for name in names:
        if name not in GROUPS:
            raise unknown_choice("quantity", name, GROUPS)
        if list(names).count(name) > 1:
            raise InvalidInput(f"--quantity {','.join(names)}: {name} is named twice")
    if list(names) == ["contact"] and not touching:
        raise InvalidInput(f"--quantity contact: no joint of {', '.join(scenes)} acts by contact")
    return tuple(name for name in GROUPS if name in names)
