"""What a user typed about a model of their own, translated into a question and a frame."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from conrod.commands.model_options import ModelOptions
from conrod.commands.places import places_of
from conrod.commands.reproduction import command_line
from conrod.errors import InvalidInput, unknown_choice
from conrod.report.reproduction import Reproduction
from conrod.scenes import Scene
from conrod.studies.user_model.frame import UNITS, GivenFrame
from conrod.units import parse_quantity
from conrod.user_model import Question


def question_of(options: ModelOptions, scene: Scene) -> Question:
    """What the model is asked for.

    Raises:
        InvalidInput: the crank or a point is missing, unknown or given twice.
    """
    mechanism = scene.mechanism()
    observed = [point.name for point in mechanism.observed]
    if options.crank is None:
        raise InvalidInput("say which joint of the model is driven: --crank JOINT")
    if not options.points:
        raise InvalidInput(f"say where an observed point of the scene is: --point {observed[0]}=site:NAME")
    touching = None if options.touching is None else _two(options.touching)
    if touching and not mechanism.cam_contacts:
        raise InvalidInput(f"--touching {options.touching}: the machine has no cam that touches anything")
    return Question(
        crank=options.crank,
        places=places_of(options.points, observed),
        mobility=mechanism.mobility,
        contacts=len(mechanism.cam_contacts),
        touching=touching,
        keyframe=options.keyframe,
    )


def given_frame(options: ModelOptions) -> GivenFrame:
    """What is said of the frame.

    Raises:
        InvalidInput: an angle or a unit that is none.
    """
    unit = options.length_unit
    if unit is not None and unit not in UNITS:
        raise unknown_choice("--length-unit", unit, UNITS)
    return GivenFrame(
        plane=options.plane,
        rotation=None if options.rotation is None else parse_quantity("--rotation", options.rotation, "rad"),
        zero=None if options.crank_zero is None else parse_quantity("--crank-zero", options.crank_zero, "rad"),
        unit=None if unit is None else UNITS[unit],
    )


def _two(text: str) -> tuple[str, str]:
    first, _, second = (part.strip() for part in text.partition(","))
    if not first or not second or "," in second:
        raise InvalidInput(f"--touching {text!r}: give two geoms, CAM,ROLLER")
    return first, second


def model_command_line(
    file: str,
    scene: str,
    options: ModelOptions,
    revolutions: int | None,
    tolerance: str | None,
    assignments: Sequence[str],
    folder: Path,
) -> str:
    """The words that judge the model again."""
    given = {
        "--scene": scene,
        "--crank": options.crank,
        "--point": options.points,
        "--plane": options.plane,
        "--rotation": options.rotation,
        "--crank-zero": options.crank_zero,
        "--length-unit": options.length_unit,
        "--keyframe": options.keyframe,
        "--touching": options.touching,
        "--revolutions": revolutions,
        "--tolerance": tolerance,
    }
    return Reproduction(command_line("validate", given, assignments, folder)).of(file)
