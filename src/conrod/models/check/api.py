"""A user's own MuJoCo model, judged by the exact motion of the scene that it is to be."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conrod.errors import InvalidInput, as_mapping
from conrod.execution.local import call_on_file
from conrod.execution.resolve_arguments import REVOLUTIONS_RANGE, OneScene, scene_by_name
from conrod.execution.runner import Runs
from conrod.execution.tolerances import check_tolerance
from conrod.mechanism.units import check_count, check_number
from conrod.mjcf.loop_results import OWN_SETTINGS
from conrod.mjcf.request import ModelRequest, controls_of, places_of, size_of_unit
from conrod.models.check import report as user_model
from conrod.models.check.frame import GivenFrame
from conrod.models.check.results import OWN_RUN, ModelStudy
from conrod.report.findings import Findings, text_of_call
from conrod.scenes import Scene
from conrod.user_files.files import check_readable
from conrod.user_files.in_memory import Model, file_of_model
from conrod.user_files.kept_checks import check_or_recall

if TYPE_CHECKING:
    from conrod.execution.baseline_check import BaselineCheck

TURNS = 2
STUDY = "conrod.models.check.study.study_scene_model"


def check_model(
    model: Model,
    scene: OneScene,
    *,
    crank: str | None = None,
    points: Mapping[str, str] | None = None,
    plane: str | None = None,
    rotation: float | None = None,
    crank_zero: float | None = None,
    keyframe: str | None = None,
    controls: Mapping[str, float] | None = None,
    unit: str | None = None,
    revolutions: int = TURNS,
    tolerance: Mapping[str, float | str] | None = None,
    refine: bool = False,
    qualify: bool = False,
    baseline: str | Path | None = None,
    accept: bool = False,
    runs: Runs | None = None,
) -> Findings[ModelStudy]:
    """Judge a MuJoCo model by the exact motion of the scene that it is to be.

    The file is judged as it stands first, by its own actuators from its own start; then with conrod's drive.

    Args:
        model: path of an MJCF or binary file, or a model in memory.
        crank: joint of the model that is driven; None to find it, by its name or as the only one on the ground.
        points: place of each observed point in the model, such as {"C": "site:tip"}; "body:" and "geom:" likewise; None
            to find them by their names.
        plane: directions right and up of the model that are the scene's x and y, such as "-xz"; None to find them.
        rotation: angle of the scene's x axis in that plane [rad]; None to find it.
        crank_zero: hinge angle at which the crank angle is 0 [rad]; None to find it.
        keyframe: keyframe to start from; None for the first, "qpos0" for none.
        controls: inputs of actuators in place of the keyframe's, in MuJoCo's units.
        unit: unit of the model's lengths: m, cm, mm or inch; None to find it.
        tolerance: largest error by quantity, normalised.
        refine: run the model at other steps too, for the observed order.
        qualify: plant known defects into a check that has passed, and say which of them it notices.
        revolutions, baseline, accept: as in `validate`.
        runs: ledger that keeps what was found in a file for as long as no byte of it changes; None, as for a model in
            memory or with a baseline, to judge it here and now.

    Raises:
        InvalidInput: the model or an argument cannot be used; says what can.
    """
    with file_of_model(model) as (path, shown):
        check_readable(path)
        check_count("--revolutions", revolutions, *REVOLUTIONS_RANGE)
        name, machine = scene_by_name(scene)
        points, taken = as_mapping("points", points, "{'C': 'site:tip'}"), ""
        if crank is None or not points:
            from conrod.models.check.guessing import find_names

            crank, points = call_on_file(find_names, path, machine.mechanism(), crank, dict(points))
            typed = " ".join(f"--point {one}={where}" for one, where in points.items())
            taken = f"taken as --crank {crank} {typed}"
        question = question_on_model(machine, crank, points, keyframe, controls or {}, unit)
        question = replace(question, taken=taken)
        for angle, given in (("rotation", rotation), ("crank_zero", crank_zero)):
            if given is not None:
                check_number(angle, given, -math.inf, math.inf, "rad")
        frame = GivenFrame(
            plane, rotation, crank_zero, None if unit is None else 1.0
        )  # it is in metres from its loading on
        allowed = None if tolerance is None else check_tolerance(tolerance)
        options: dict[str, Any] = {
            "crank": crank, "point": tuple(f"{one}={where}" for one, where in points.items()), "plane": plane,
            "rotation": rotation, "crank-zero": crank_zero, "keyframe": keyframe,
            "ctrl": tuple(f"{one}={value:g}" for one, value in (controls or {}).items()),
            "unit": unit, "revolutions": None if revolutions == TURNS else revolutions,
        }  # fmt: skip
        baseline_check: BaselineCheck | None = None
        if baseline is not None or accept:
            from conrod.execution.baseline_check import BaselineCheck
            from conrod.models.check.baseline_lines import model_lines

            baseline_check = BaselineCheck.prepare(baseline, {name: machine}, options, accept=accept)

        def find(several: Sequence[Mapping[str, Scene]]) -> list[list[ModelStudy]]:
            # The file of a model in memory is there for a moment; a baseline is compared with what is measured now.
            kept = runs if shown is None and baseline is None else None
            given = question, frame, float(revolutions), allowed, refine, qualify and len(several) == 1
            return [
                [check_or_recall(STUDY, ModelStudy, path, (name, one), *given, runs=kept) for one in scenes.values()]
                for scenes in several
            ]

        try:
            ((found,),) = find([{name: machine}])
        except InvalidInput as error:
            raise InvalidInput(f"{error} ({taken})" if taken else f"{error}") from None
        compared = (
            baseline_check.compare([found], find, model_lines, {OWN_RUN: OWN_SETTINGS}) if baseline_check else None
        )
    part = path.stem if shown is None else shown
    call = text_of_call(
        "check_model",
        shown or str(path),
        name,
        crank=crank,
        points=dict(points),
        plane=plane,
        rotation=rotation,
        crank_zero=crank_zero,
        keyframe=keyframe,
        controls=controls,
        unit=unit,
        revolutions=options["revolutions"],
        tolerance=tolerance,
        qualify=qualify,
    )
    parts = {part: replace(found, file=shown or found.file)}
    return Findings(user_model.MODEL_REPORT, parts, call, typed={part: str(path)}, baseline=compared)


def question_on_model(
    scene: Scene, crank: str | None, points: Mapping[str, str], keyframe: str | None, controls: Mapping[str, float],
    unit: str | None = None,
) -> ModelRequest:  # fmt: skip
    """Make the request for a model, with its crank and observed points, and the mobility of its scene.

    Raises:
        InvalidInput: the crank or a point is missing or unknown.
    """
    mechanism = scene.mechanism()
    observed = [point.name for point in mechanism.observed]
    if crank is None:
        raise InvalidInput("say which joint of the model is driven: --crank JOINT")
    if not points:
        raise InvalidInput(f"say where an observed point of the scene is: --point {observed[0]}=site:NAME")
    places, contacts = places_of(points, observed), len(mechanism.cam_contacts)
    mobility, inputs = mechanism.mobility, controls_of(controls)
    return ModelRequest(crank, places, mobility, contacts, keyframe, inputs, unit=size_of_unit(unit))
