"""Output of `conrod show` and `conrod results`: a scene, its linkage over a turn, all as JSON; the ledger to read."""

from __future__ import annotations

import math
import shlex
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.comparison.plain_values import plain_values
from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage import InstantQuantities, OutputLink, TurnQuantities
from conrod.exact.linkage.crank_range import CrankRange
from conrod.execution.results_table import columns_of
from conrod.mechanism.units import MM
from conrod.report import numbers
from conrod.report.folder import json_text
from conrod.report.results import scene_description
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart
from conrod.scenes import SCENES, Scene, catalogue_names, catalogue_tables, dynamics_names
from conrod.scenes.space import MACHINES

SHOW_SCHEMA = 3  # of the JSON
ENDS = {"limit": "where it has to turn back", "change point": "a change point", "none": "no end"}


def catalogue() -> Iterator[PrintedPart]:
    """One line for each scene and each machine."""
    closed = [(name, scene.title) for name, scene in SCENES.items()]
    tables = [table(("name", "title"), closed, title="scenes with a closed form")]
    for title, names in (
        ("catalogue (machines from files)", catalogue_names()),
        ("dynamics (under loads, or in free motion)", dynamics_names()),
    ):
        files = {name: catalogue_tables(name) for name in names}
        machines = [(name, file["title"], str(len(file["bodies"]))) for name, file in files.items()]
        tables.append(table(("name", "title", "moving links"), machines, title=title))
    spatial = [(name, made().title) for name, made in MACHINES.items()]
    title = "machines in space (in MuJoCo: validate, export --format mjcf)"
    yield from separated_by_lines(*tables, table(("name", "title"), spatial, title=title))
    yield from (
        "",
        "`conrod show SCENE` has its source and all about it, and draws it with --svg FILE.svg; `conrod engines` lists "
        "what runs them",
    )


def scene_parts(name: str, scene: Scene) -> Iterator[PrintedPart]:
    """Yield what `conrod show` prints of a scene: texts, parameters, bodies, and references."""
    mechanism = scene.kinematics.mechanism
    lines = [f"{name}: {scene.title}", f"source: {scene.source}", f"frame: {scene.frame}"]
    if scene_description(scene) != f"{scene.title}.":  # what a file without a description has
        lines += ["", scene_description(scene)]
    if scene.assumptions:
        lines += ["", "assumed:", *(f"  - {assumption}" for assumption in scene.assumptions)]
    yield from (*lines, "")
    rows = [
        (one.name, *numbers.in_shown_unit(scene.parameters[one.name], one.unit), one.meaning)
        for one in scene.parameter_facts().values()
    ]
    yield table(("parameter", "value", "unit", "meaning"), rows, right=("value",))
    bodies = ", ".join(f"{b.name} {b.mass:.6g} kg, {b.inertia:.6g} kg m²" for b in mechanism.bodies)
    higher = len(mechanism.cam_contacts) + len(mechanism.meshes)
    lines = [
        *("", f"bodies: {bodies}"),
        f"mobility: {mechanism.mobility} (Gruebler: {len(mechanism.bodies)} moving links, "
        f"{len(mechanism.joints) - higher} lower and {higher} higher pairs)",
    ]
    if breaks := ", ".join(f"{math.degrees(angle):.4f}" for angle in scene.break_angles()):
        lines.append(f"acceleration or jerk jumps at: {breaks} deg")
    points = ", ".join(f"{p.name} (L = {1e3 * scene.lengths[p.name]:.6g} mm)" for p in mechanism.observed)
    generic = "generic Newton solver on the joint equations"
    references = f"closed form from the parameters; {generic}" if scene.closed_form else generic
    yield from (*lines, f"observed points: {points}", f"references: {references}")


def next_parts(scene: str, assignments: Sequence[str], angle: str | None, *, drawn: bool) -> Iterator[PrintedPart]:
    """Yield the commands to type after `conrod show`: one that draws the scene, unless it is drawn, and `validate`.

    Args:
        scene: name or file, as typed.
        angle: crank angle, as typed; None where none is given.
    """
    given = [scene, *(word for text in assignments for word in ("--set", text))]
    there = [] if angle is None else ["--angle", angle]
    yield ""
    if not drawn:
        yield f"draw it: {shlex.join(['conrod', 'show', *given, *there, '--svg', f'{Path(scene).stem}.svg'])}"
    yield f"next: {shlex.join(['conrod', 'validate', *given])}"


def turn_parts(kinematics: Kinematics, turn: TurnQuantities) -> Iterator[PrintedPart]:
    """Yield strokes and transmission angles over a revolution, or over the driver's span."""
    yield from ("", f"crank: {reach_words(turn.crank_range)}")
    span = kinematics.mechanism.driver.span
    if span is not None:
        yield f"what follows is of the pass from {degrees(span[0])} to {degrees(span[1])} deg"
    elif turn.crank_range.full and not kinematics.repeats:
        yield "after a turn the links do not stand as before it: strokes and angles are those of the first turn"
    yield from separated_by_lines(outputs_table(turn), transmission_table(turn))


def separated_by_lines(*tables: Table) -> Iterator[PrintedPart]:
    """Tables that have rows, each after an empty line."""
    for shown in filter(None, tables):
        yield from ("", shown)


def reach_words(reach: CrankRange) -> str:
    """Range of the crank in words."""
    if reach.full:
        passed = ", ".join(degrees(angle) for angle in reach.change_points)
        return f"turns fully, through change points at {passed} deg" if passed else "turns fully"
    start, stop = degrees(reach.start), degrees(reach.stop)
    return f"reaches from {start} deg ({ENDS[reach.start_end]}) to {stop} deg ({ENDS[reach.stop_end]})"


def outputs_table(turn: TurnQuantities) -> Table:
    """Strokes, dead centres and time ratios of the driven links."""
    right = ("stroke", "turns back at [deg]", "there and back [deg]", "time ratio")
    title = "strokes, dead centres and time ratios"
    return table(("driven link", "guided by", *right), [_output_row(output) for output in turn.outputs], right, title)


def _output_row(output: OutputLink) -> tuple[str, ...]:
    on = f"goes on, {_displacement_text(output.gain, output.unit)} a turn"
    stroke = on if output.stroke is None else _displacement_text(output.stroke, output.unit)
    there_and_back = ", ".join(degrees(way) for way in (output.forward, output.backward) if way is not None)
    ratio = "" if output.time_ratio is None else f"{output.time_ratio:.6g}"
    ends = [dict.fromkeys((degrees(centre.angle), degrees(centre.until))) for centre in output.dead_centres]
    centres = ", ".join(" to ".join(end) for end in ends)
    return (output.link, output.joint, stroke, centres or "nowhere", there_and_back, ratio)


def _displacement_text(value: float, unit: str) -> str:
    return f"{MM * value:.6g} mm" if unit == "m" else f"{math.degrees(value):.6g} deg"


def transmission_table(turn: TurnQuantities) -> Table:
    """Transmission angles of the driven links, with the crank angles where they are taken."""
    head = ("driven link", "pushed by", "least", "greatest", "worst", "greatest pressure angle")
    title = "transmission angles [deg], and the crank angles where they are taken"
    rows = []
    for angle in turn.transmission:
        extremes = (angle.least, angle.greatest, angle.worst, angle.greatest_pressure_angle)
        values = [f"{math.degrees(one.value):.4f} at {math.degrees(one.angle):.2f}" for one in extremes]
        rows.append((angle.driven, angle.through, *values))
    return table(head, rows, title=title)


def degrees(angle: float) -> str:
    """An angle [rad] in degrees, to a ten thousandth, without trailing zeros."""
    return f"{math.degrees(angle):z.4f}".rstrip("0").rstrip(".")


def linkage_text(name: str, scene: Scene, turn: TurnQuantities, instant: InstantQuantities | None) -> str:
    """The JSON document of a scene; m, m/s, m/s^2, rad, rad/s, rad/s^2."""
    document = {
        "schema": SHOW_SCHEMA,
        "conrod": version("conrod"),
        "scene": name,
        "parameters": scene.parameters,
        "mobility": scene.kinematics.mechanism.mobility,
        "looked_at": scene.kinematics.span,
        "turn": plain_values(turn),
        "instant": plain_values(instant),
    }
    return json_text(document)


# -- results ----------------------------------------------------------------------------------------------------------

# What a reader looks at first; a file has all columns.
TERMINAL_COLUMNS = (
    "scene", "study", "engine", "engine_version", "preset", "steps_per_revolution", "outcome", "passed", "position_max",
    "velocity_max",
)  # fmt: skip


def ledger_table(rows: Sequence[Mapping[str, Any]], wanted: Sequence[str] = ()) -> Table:
    """Make a table for the terminal of a ledger's rows: the requested columns, or ten chosen ones."""
    columns = columns_of(rows, wanted) if wanted else TERMINAL_COLUMNS
    right = [name for name in columns if any(isinstance(row.get(name), float) for row in rows)]
    return table(columns, [[_cell(row.get(name)) for name in columns] for row in rows], right=right)


def _cell(value: Any) -> str:
    """Return a value as a cell to read: numbers in three digits, empty for None."""
    return "" if value is None else f"{value:.3g}" if isinstance(value, float) else str(value)
