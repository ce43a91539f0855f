"""`conrod show`."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import click

from conrod.cli import options
from conrod.cli.say import say
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from pathlib import Path

    from conrod.exact.linkage import InstantQuantities
    from conrod.scenes import Scene

# Crank angle of the figures where none is asked for: away from the dead centres of most machines.
USUAL_ANGLE = math.radians(60.0)


@options.verb()
@options.scene_argument(required=False)
@options.assignments
@click.option("--angle", metavar="ANGLE", help="Show velocities, accelerations, instant centres here, e.g. 60deg.")
@click.option("--svg", "drawing", metavar="FILE", help="Draw the scene to an SVG file.")
@click.option("--figures", metavar="FOLDER", help="Draw instant centres and polygons at --angle [60deg] as SVG.")
@options.document
def show(
    scene: str | None,
    assignments: tuple[str, ...],
    angle: str | None,
    drawing: str | None,
    figures: str | None,
    document: str | None,
) -> None:
    """List what is available, one line each; or describe one SCENE."""
    from conrod.cli.console import show_catalogue, show_instant, show_scene, show_turn
    from conrod.cli.say import waiting
    from conrod.exact.linkage import turn_quantities
    from conrod.studies.frame.files import files_to_write, folder_to_write
    from conrod.studies.frame.resolve_arguments import select_scene
    from conrod.studies.frame.writing import single, write_together

    if scene is None:
        if assignments or any(given is not None for given in (angle, drawing, figures, document)):
            raise InvalidInput("--svg, --set, --angle, --figures and --json need a SCENE; `conrod show` lists them")
        show_catalogue()
        return
    if drawing and not drawing.strip().lower().endswith(".svg"):
        raise InvalidInput(f"--svg {drawing}: the drawing is SVG: give a name that ends in .svg")
    folder = None if figures is None else folder_to_write(figures, "--figures")
    files = files_to_write({"--svg": drawing, "--json": document}, _drawn_in(folder) if folder else None)
    batches = []
    with waiting(scene, None):
        name, chosen = select_scene(scene, assignments)
        instant = _instant(chosen, angle, folder is not None)
        turn = turn_quantities(chosen.kinematics)
        if "--svg" in files:
            from conrod.report.drawing.drawing import mechanism_svg

            batches.append(single(files["--svg"], mechanism_svg(chosen)))
        if folder and instant:
            from conrod.report.linkage.figures import figures_batch

            batches.append(figures_batch(instant, folder))
        if "--json" in files:
            from conrod.report.linkage.tables import linkage_text

            batches.append(single(files["--json"], linkage_text(name, chosen, turn, instant)))
    show_scene(name, chosen)
    show_turn(chosen.kinematics, turn)
    if instant:
        show_instant(instant, turn.numbers)
    write_together(batches)
    for word, written in (("drawing", files.get("--svg")), ("figures", folder)):
        if written:
            say(f"{word}: {written}")


def _drawn_in(folder: Path) -> dict[str, Path]:
    from conrod.report.linkage.figures import FIGURES

    return {f"the figure {figure}": folder / figure for figure in FIGURES}


def _instant(scene: Scene, text: str | None, wanted: bool) -> InstantQuantities | None:
    """Quantities at the crank angle that is asked for, or at a usual one where figures are."""
    from conrod.exact.linkage import instant_quantities
    from conrod.mechanism.mechanism import LARGEST_SPAN
    from conrod.mechanism.units import check_number, parse_quantity
    from conrod.report.linkage.tables import degrees

    span = scene.mechanism().driver.span
    if text is None and not wanted:
        return None
    if text is None:
        angle = USUAL_ANGLE if span is None else 0.5 * (span[0] + span[1])
    else:
        angle = parse_quantity("--angle", text, "rad")
        check_number("--angle", angle, -LARGEST_SPAN, LARGEST_SPAN, "rad")
        if span is not None and not span[0] <= angle <= span[1]:
            first, last = (degrees(end) for end in span)
            raise InvalidInput(
                f"--angle {text}: the crank makes one pass, from {first} to {last} deg; give an angle between them"
            )
    return instant_quantities(scene.kinematics, angle, scene.speed)
