"""`conrod show`."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from conrod.cli import options
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.exact.linkage.quantities import InstantQuantities, TurnQuantities
    from conrod.scenes import Scene
    from conrod.studies.frame.files import Batch

# Crank angle of the figures where none is asked for: away from the dead centres of most machines.
USUAL_ANGLE = math.radians(60.0)


@dataclass(frozen=True)
class _Files:
    """Files to write, if any."""

    drawing: Path | None
    figures: Path | None
    document: Path | None


@click.command()
@click.argument("scene", required=False)
@options.assignments
@click.option("--angle", metavar="ANGLE", help="Show velocities, accelerations, instant centres here, e.g. 60deg.")
@click.option("--svg", "drawing", metavar="FILE", help="Draw the scene to an SVG file.")
@click.option("--figures", metavar="FOLDER", help="Draw instant centres and polygons at --angle [60deg] as SVG.")
@click.option("--json", "document", metavar="FILE", help="Write the quantities as JSON.")
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
    from conrod.exact.linkage.quantities import turn_quantities
    from conrod.studies.frame.files import write_together
    from conrod.studies.frame.resolve_arguments import select_scene

    if scene is None:
        given = {"--svg": drawing, "--set": assignments, "--angle": angle, "--figures": figures, "--json": document}
        if any(value for value in given.values()) or drawing is not None:
            raise InvalidInput("--svg, --set, --angle, --figures and --json need a SCENE; `conrod show` lists them")
        show_catalogue()
        return
    files = _files(drawing, figures, document)
    name, chosen = select_scene(scene, assignments)
    instant = _instant(chosen, angle, files.figures is not None)
    turn = turn_quantities(chosen.kinematics)
    show_scene(name, chosen)
    show_turn(chosen.kinematics, turn)
    if instant:
        show_instant(instant, turn.numbers)
    write_together(_batches(files, name, chosen, turn, instant))
    if files.drawing:
        click.echo(f"drawing: {files.drawing}")
    if files.figures:
        click.echo(f"figures: {files.figures}")


def _files(drawing: str | None, figures: str | None, document: str | None) -> _Files:
    """Files that can be written, before any work is done."""
    from conrod.report.linkage.figures import FIGURES
    from conrod.studies.frame.files import check_apart, file_to_write, folder_to_write

    if drawing is not None and drawing.strip() and not drawing.lower().endswith(".svg"):
        raise InvalidInput(f"--svg {drawing}: the drawing is SVG: give a name that ends in .svg")
    found = _Files(
        None if drawing is None else file_to_write(drawing, "--svg"),
        None if figures is None else folder_to_write(figures, "--figures"),
        None if document is None else file_to_write(document, "--json"),
    )
    named = {"--svg": found.drawing, "--json": found.document}
    if found.figures:
        named |= {f"the figure {figure}": found.figures / figure for figure in FIGURES}
    check_apart({option: path for option, path in named.items() if path is not None})
    return found


def _instant(scene: Scene, text: str | None, wanted: bool) -> InstantQuantities | None:
    """Quantities at the crank angle that is asked for, or at a usual one where figures are."""
    from conrod.exact.linkage.quantities import instant_quantities
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


def _batches(
    files: _Files, name: str, scene: Scene, turn: TurnQuantities, instant: InstantQuantities | None
) -> list[Batch]:
    from conrod.report.linkage.document import linkage_text
    from conrod.studies.frame.files import single

    batches = []
    if files.drawing:
        from conrod.report.drawing.drawing import mechanism_svg

        batches.append(single(files.drawing, mechanism_svg(scene)))
    if files.figures and instant:
        from conrod.report.linkage.figures import figures_batch

        batches.append(figures_batch(instant, files.figures))
    if files.document:
        batches.append(single(files.document, linkage_text(name, scene, turn, instant)))
    return batches
