"""`conrod show` and `conrod engines`: what there is."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import click

from conrod.cli import completion, options, say, waiting
from conrod.errors import InvalidInput

if TYPE_CHECKING:
    from conrod.engines import Engine
    from conrod.exact.linkage import InstantQuantities
    from conrod.report.table import Table
    from conrod.scenes import Scene


@options.verb()
@click.argument("scene", required=False, shell_complete=completion.scenes)
@options.assignments
@click.option(
    "--angle", metavar="ANGLE", help="Show motion, instant centres and parts of accelerations here, e.g. 60deg."
)
@click.option(
    "--svg",
    "drawing",
    metavar="FILE",
    help="Draw the scene to an SVG file; with --angle at that angle, with centres and polygons.",
)
@options.document
def show(
    scene: str | None, assignments: tuple[str, ...], angle: str | None, drawing: str | None, document: str | None
) -> None:
    """List scenes and machines, one line each; or describe one SCENE."""
    from conrod.cli.console import catalogue, linkage_text, next_parts, scene_parts, turn_parts
    from conrod.cli.instant_tables import instant_parts
    from conrod.exact.linkage import turn_quantities
    from conrod.execution.files import files_to_write
    from conrod.execution.resolve_arguments import select_scene
    from conrod.execution.writing import single_file, write_together
    from conrod.report.terminal import print_parts

    if scene is None:
        if assignments or any(given is not None for given in (angle, drawing, document)):
            raise InvalidInput("--svg, --set, --angle and --json need a SCENE; `conrod show` lists them")
        print_parts(catalogue())
        return
    if drawing and not drawing.strip().lower().endswith(".svg"):
        raise InvalidInput(f"--svg {drawing}: the drawing is SVG: give a name that ends in .svg")
    files = files_to_write({"--svg": drawing, "--json": document})
    batches = []
    with waiting(scene, None):
        name, chosen = select_scene(scene, assignments)
        instant = None if angle is None else _instant(chosen, angle)
        turn = turn_quantities(chosen.kinematics)
        if "--svg" in files:
            from conrod.report.drawing.drawing import mechanism_svg
            from conrod.report.drawing.instant import instant_svg

            drawn = instant_svg(chosen, instant) if instant else mechanism_svg(chosen)
            batches.append(single_file(files["--svg"], drawn))
        if "--json" in files:
            batches.append(single_file(files["--json"], linkage_text(name, chosen, turn, instant)))
    print_parts(scene_parts(name, chosen))
    print_parts(turn_parts(chosen.kinematics, turn))
    print_parts(instant_parts(instant) if instant else ())
    write_together(batches)
    if "--svg" in files:
        say(f"drawing: {files['--svg']}")
    print_parts(next_parts(scene, assignments, angle, drawn="--svg" in files))


def _instant(scene: Scene, text: str) -> InstantQuantities:
    """Quantities at the crank angle that is asked for."""
    from conrod.cli.console import degrees
    from conrod.exact.linkage import instant_quantities
    from conrod.mechanism.mechanism import MAX_SPAN
    from conrod.mechanism.units import check_number, parse_quantity

    span, angle = scene.mechanism().driver.span, parse_quantity("--angle", text, "rad")
    check_number("--angle", angle, -MAX_SPAN, MAX_SPAN, "rad")
    if span is not None and not span[0] <= angle <= span[1]:
        first, last = (degrees(end) for end in span)
        raise InvalidInput(
            f"--angle {text}: the crank makes one pass, from {first} to {last} deg; give an angle between them"
        )
    return instant_quantities(scene.kinematics, angle, scene.speed)


@options.verb()
def engines() -> None:
    """List the installed engines: version, origin, presets and capabilities.

    Other packages bring engines by an entry point of the group `conrod.engines` (docs/engines.md). One that cannot be
    loaded is named with the reason, and keeps nothing else from running.
    """
    import conrod.execution  # noqa: F401  has engines of other packages in processes of their own
    from conrod.engines import OPTIONAL_ENGINES, loadable_engines
    from conrod.report.terminal import print_parts, verdict_line

    found, left_out = loadable_engines(OPTIONAL_ENGINES)
    print_parts([capabilities_table(found), *(verdict_line(line, False) for line in left_out)])


def capabilities_table(engines: Sequence[Engine[Any]]) -> Table:
    """Version, origin and presets of engines, and which capabilities each has."""
    from conrod.engines import origin_of
    from conrod.engines.capabilities import CAPABILITY_TITLES, MissingCapability, capability
    from conrod.report.table import table

    rows = [
        ("version", *(one.version for one in engines)),
        ("from", *(origin_of(one.name) for one in engines)),
        ("presets", *(", ".join(one.presets) for one in engines)),
    ]
    for kind, meaning in CAPABILITY_TITLES.items():
        supported = (not isinstance(capability(one, kind), MissingCapability) for one in engines)
        rows.append((meaning, *("yes" if has else "unsupported" for has in supported)))
    return table(("", *(one.name for one in engines)), rows)
