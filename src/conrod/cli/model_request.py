"""Question and frame of a user's own model, from the options as typed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from conrod.cli.options import ModelOptions
from conrod.cli.reproduction import command_line
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import parse_quantity
from conrod.own.models.frame import UNITS, GivenFrame
from conrod.own.models.request import Place, Question
from conrod.report.reproduction import Reproduction
from conrod.scenes import Scene

KINDS = ("site", "body", "geom")


def places_of(texts: Sequence[str], observed: Sequence[str] = ()) -> tuple[Place, ...]:
    """Parse the place of each point.

    Args:
        observed: names that points may have; any where there are none.

    Raises:
        InvalidInput: a point that is not written so, is unknown or given twice.
    """
    places: dict[str, Place] = {}
    for text in texts:
        name, equals, where = (part.strip() for part in text.partition("="))
        if not equals or not name or not where:
            raise InvalidInput(f"--point {text!r}: give it as {observed[0] if observed else 'NAME'}=site:SITE")
        if observed and name not in observed:
            raise unknown_choice("observed point", name, observed)
        if name in places:
            raise InvalidInput(f"--point {name}: given twice, as {str(places[name])!r} and {where!r}")
        kind, colon, element = where.partition(":")
        # A name may have a colon in it itself.
        if colon and kind in KINDS:
            places[name] = Place(name, kind, element)
        elif colon and not element:
            raise unknown_choice("kind of element", kind, KINDS)
        else:
            places[name] = Place(name, "", where)
    return tuple(places.values())


def question_of(options: ModelOptions, scene: Scene) -> Question:
    """Return what the options ask of the model.

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
    """Frame that the options give.

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
