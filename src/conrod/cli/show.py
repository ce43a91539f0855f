"""`conrod show`."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.cli import options
from conrod.cli.say import say
from conrod.errors import InvalidInput

if TYPE_CHECKING:
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
    from conrod.exact.linkage import turn_quantities
    from conrod.studies.frame.files import single, write_together
    from conrod.studies.frame.resolve_arguments import select_scene

    wanted = {"--svg": drawing, "--figures": figures, "--json": document}
    if scene is None:
        if assignments or angle or any(value is not None for value in wanted.values()):
            raise InvalidInput("--svg, --set, --angle, --figures and --json need a SCENE; `conrod show` lists them")
        show_catalogue()
        return
    files = _files({option: text for option, text in wanted.items() if text is not None})
    name, chosen = select_scene(scene, assignments)
    instant = _instant(chosen, angle, "--figures" in files)
    turn = turn_quantities(chosen.kinematics)
    show_scene(name, chosen)
    show_turn(chosen.kinematics, turn)
    if instant:
        show_instant(instant, turn.numbers)
    batches = []
    if "--svg" in files:
        from conrod.report.drawing.drawing import mechanism_svg

        batches.append(single(files["--svg"], mechanism_svg(chosen)))
    if "--figures" in files and instant:
        from conrod.report.linkage.figures import figures_batch

        batches.append(figures_batch(instant, files["--figures"]))
    if "--json" in files:
        from conrod.report.linkage.document import linkage_text

        batches.append(single(files["--json"], linkage_text(name, chosen, turn, instant)))
    write_together(batches)
    for option, word in (("--svg", "drawing"), ("--figures", "figures")):
        if option in files:
            say(f"{word}: {files[option]}")


def _files(texts: dict[str, str]) -> dict[str, Path]:
    """Files and folders that can be written, by option, before any work is done."""
    from conrod.report.linkage.figures import FIGURES
    from conrod.studies.frame.files import check_apart, file_to_write, folder_to_write

    drawing = texts.get("--svg", "").strip()
    if drawing and not drawing.lower().endswith(".svg"):
        raise InvalidInput(f"--svg {drawing}: the drawing is SVG: give a name that ends in .svg")
    found = {
        option: folder_to_write(text, option) if option == "--figures" else file_to_write(text, option)
        for option, text in texts.items()
    }
    named = {option: path for option, path in found.items() if option != "--figures"}
    if "--figures" in found:
        named |= {f"the figure {figure}": found["--figures"] / figure for figure in FIGURES}
    check_apart(named)
    return found


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
