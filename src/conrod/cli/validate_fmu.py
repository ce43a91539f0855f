"""`conrod validate` of an FMU."""

from __future__ import annotations

from pathlib import Path

from conrod.cli.options import refuse
from conrod.cli.validate_request import DEFAULT_REVOLUTIONS, Request
from conrod.errors import InvalidInput
from conrod.mechanism.units import check_count
from conrod.own.fmu.study import in_columns, study_fmu
from conrod.own.tables.columns import request
from conrod.own.tables.estimation import parse_estimate
from conrod.own.tables.study import TableStudy
from conrod.scenes import Scene
from conrod.studies.frame.resolve_arguments import REVOLUTIONS, TOLERANCES, parse_tolerance, scene_text, select_scene

STEPS = 1000  # a revolution
OF_MODELS = ("drives", "plane", "rotation", "crank_zero", "length_unit", "keyframe", "controls", "touching")


def judge_fmu(path: Path, scene: str | Scene, asked: Request) -> TableStudy:
    """An FMU against the machine that a scene is.

    Raises:
        InvalidInput: the FMU or an option cannot be used.
    """
    refuse(asked, "an FMU: it is for scenes or MuJoCo models", *OF_MODELS, "engine", "qualify")
    machine = select_scene(scene, asked.assignments)[1]
    points, steps = tuple(machine.lengths), STEPS if asked.steps_per_rev is None else asked.steps_per_rev
    revolutions = DEFAULT_REVOLUTIONS if asked.revolutions is None else asked.revolutions
    check_count("--revolutions", revolutions, *REVOLUTIONS)
    wanted = request((*asked.columns, *in_columns(asked.points, asked.crank, points)), asked.units, points)
    estimate = () if asked.estimate is None else parse_estimate(asked.estimate)
    allowed = None if asked.tolerance is None else parse_tolerance(asked.tolerance, TOLERANCES)
    one, mode, turns = (scene_text(scene), machine), asked.preset, float(revolutions)
    try:
        return study_fmu(path, one, wanted, mode, steps, turns, estimate, allowed, asked.timeout)
    except InvalidInput as error:
        raise error if str(error).startswith(f"{path}: ") else InvalidInput(f"{path}: {error}") from None
