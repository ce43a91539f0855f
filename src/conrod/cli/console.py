"""Output of `conrod show`."""

from __future__ import annotations

import math
from collections.abc import Iterable

from rich.console import Console

from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage import InstantQuantities, TurnQuantities
from conrod.report import numbers
from conrod.report.linkage import degrees, links_table, outputs_table, points_table, reach_words, transmission_table
from conrod.report.scene_words import described
from conrod.report.table import Table, table
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import SCENES, Scene
from conrod.scenes.catalogue import catalogue_heading, catalogue_names, dynamics_names
from conrod.scenes.space import MACHINES

# -- show ------------------------------------------------------------------------------------------------------------


def show_catalogue() -> None:
    """One line for each scene and each machine."""
    closed = [(name, scene.title) for name, scene in SCENES.items()]
    tables = [table(("name", "title"), closed, title="scenes with a closed form")]
    for title, names in (
        ("catalogue (machines from files)", catalogue_names()),
        ("dynamics (under loads, or in free motion)", dynamics_names()),
    ):
        headings = {name: catalogue_heading(name) for name in names}
        machines = [(name, heading.title, str(heading.links)) for name, heading in headings.items()]
        tables.append(table(("name", "title", "moving links"), machines, title=title))
    spatial = [(name, made().title) for name, made in MACHINES.items()]
    title = "machines in space (in MuJoCo: validate, export --format mjcf)"
    out = console()
    _print_apart(out, [*tables, table(("name", "title"), spatial, title=title)])
    last = "`conrod show SCENE` has its source and all about it; `conrod engines` lists what runs them"
    print_lines(out, ["", last])


def show_scene(name: str, scene: Scene) -> None:
    """All about one scene."""
    out = console()
    mechanism = scene.kinematics.mechanism
    lines = [f"{name}: {scene.title}", f"source: {scene.source}", f"frame: {scene.frame}"]
    if described(scene) != f"{scene.title}.":  # what a file without a description has
        lines += ["", described(scene)]
    if scene.assumptions:
        lines += ["", "assumed:", *(f"  - {assumption}" for assumption in scene.assumptions)]
    print_lines(out, [*lines, ""])
    rows = [
        (one.name, *numbers.in_shown_unit(scene.parameters[one.name], one.unit), one.meaning)
        for one in scene.parameter_facts().values()
    ]
    print_table(out, table(("parameter", "value", "unit", "meaning"), rows, right=("value",)))
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
    print_lines(out, [*lines, f"observed points: {points}", f"references: {references}"])


# -- show: a linkage -------------------------------------------------------------------------------------------------


def show_turn(kinematics: Kinematics, turn: TurnQuantities) -> None:
    """Print the quantities of a linkage over a turn, or its driver's span."""
    out = console()
    print_lines(out, ("", f"crank: {reach_words(turn.crank_range)}"))
    span = kinematics.mechanism.driver.span
    if span is not None:
        print_lines(out, [f"what follows is of the pass from {degrees(span[0])} to {degrees(span[1])} deg"])
    elif turn.crank_range.full and not kinematics.repeats:
        again = "after a turn the links do not stand as before it: strokes and angles are those of the first turn"
        print_lines(out, [again])
    _print_apart(out, (outputs_table(turn), transmission_table(turn)))


def show_instant(instant: InstantQuantities) -> None:
    """Print the motion of links and points at a crank angle."""
    out = console()
    speed = " ".join(numbers.in_shown_unit(instant.speed, "rad/s"))
    print_lines(out, ("", f"at crank angle {degrees(instant.angle)} deg, crank speed {speed}"))
    _print_apart(out, (links_table(instant), points_table(instant)))


def _print_apart(out: Console, tables: Iterable[Table]) -> None:
    for shown in filter(None, tables):
        print_lines(out, [""])
        print_table(out, shown)
