"""Output of `conrod show`."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

from rich.console import Console
from rich.padding import Padding
from rich.text import Text

from conrod.engines import engine_names
from conrod.engines.registry import presets_of
from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage import InstantQuantities, TurnQuantities
from conrod.exact.linkage.centres import centre_count
from conrod.report import numbers
from conrod.report.linkage.tables import (
    degrees,
    instant_tables,
    links_table,
    outputs_table,
    reach_words,
    transmission_table,
)
from conrod.report.scene_words import described
from conrod.report.table import Table, table
from conrod.report.terminal import console, print_lines, print_table
from conrod.scenes import SCENES, Scene
from conrod.scenes.catalogue import catalogue_heading, catalogue_names, dynamics_names
from conrod.studies.frame.scene_summary import dead_centres, jumps, stroke

WIDE = 400  # for lines that tell of a source
PARAMETER = ("parameter", "value", "unit", "meaning")


# -- show ------------------------------------------------------------------------------------------------------------


def show_catalogue() -> None:
    """One line for each scene, each machine of the catalogue, and each engine."""
    out = console(WIDE)
    scenes = [(name, scene.title, scene.source) for name, scene in SCENES.items()]
    _listed(out, "scenes with a closed form", ("name", "title", "source"), scenes)
    # What swings freely makes no pass.
    for title, names, driven in (
        ("catalogue (machines from files)", catalogue_names(), True),
        ("dynamics (under loads, or in free motion)", dynamics_names(), False),
    ):
        machines = []
        for name, heading in ((name, catalogue_heading(name)) for name in names):
            links = f"{heading.links}, one pass" if driven and heading.one_pass else str(heading.links)
            machines.append((name, heading.title, links, heading.source))
        _listed(out, title, ("name", "title", "moving links", "source"), machines)
    engines = [f"{name} (presets {', '.join(presets_of(name))})" for name in engine_names()]
    out.print(f"engines: {', '.join(engines)}")


def _listed(out: Console, title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    print_table(out, table(headings, rows, title=title), framed=False)
    out.print()


def show_scene(name: str, scene: Scene) -> None:
    """All about one scene."""
    out = console()
    mechanism = scene.kinematics.mechanism
    for text in (f"{name}: {scene.title}", f"source: {scene.source}", f"frame: {scene.frame}"):
        out.print(text, markup=False)
    if described(scene) != f"{scene.title}.":  # what a file without a description has
        out.print(f"\n{described(scene)}", markup=False)
    if scene.assumptions:
        out.print("\nassumed:")
    for assumption in scene.assumptions:
        out.print(Padding(Text(f"- {assumption}"), (0, 0, 0, 2), expand=False))
    out.print()
    rows = [
        (one.name, *numbers.in_shown_unit(scene.parameters[one.name], one.unit), one.meaning)
        for one in scene.parameter_facts().values()
    ]
    print_table(out, table(PARAMETER, rows, right=("value",)), folding=PARAMETER, framed=False)
    bodies = ", ".join(f"{b.name} {b.mass:.6g} kg, {b.inertia:.6g} kg m²" for b in mechanism.bodies)
    out.print(f"\nbodies: {bodies}")
    higher = len(mechanism.cam_contacts) + len(mechanism.meshes)
    out.print(
        f"mobility: {mechanism.mobility} (Gruebler: {len(mechanism.bodies)} moving links, "
        f"{len(mechanism.joints) - higher} lower and {higher} higher pairs)"
    )
    out.print(f"stroke of {scene.output}: {1e3 * stroke(scene):.6g} mm")
    for centre in dead_centres(scene):
        x, y = (1e3 * v for v in centre.place)
        out.print(f"dead centre of {scene.output}: {math.degrees(centre.angle):.4f} deg, at ({x:.6g}, {y:.6g}) mm")
    for angle, what in jumps(scene):
        out.print(f"{what} jumps at: {math.degrees(angle):.4f} deg")
    points = ", ".join(f"{p.name} (L = {1e3 * scene.lengths[p.name]:.6g} mm)" for p in mechanism.observed)
    out.print(f"observed points: {points}")
    generic = "generic Newton solver on the joint equations"
    out.print(f"references: {f'closed form from the parameters; {generic}' if scene.closed_form else generic}")


# -- show: a linkage -------------------------------------------------------------------------------------------------


def show_turn(kinematics: Kinematics, turn: TurnQuantities) -> None:
    """Print the quantities of a linkage over a turn, or its driver's span."""
    out = console()
    links = ", ".join(f"{number} {name}" for name, number in turn.numbers.items())
    count = centre_count(kinematics.mechanism)
    print_lines(
        out,
        (
            *("", f"links: {links}"),
            f"instant centres: {count}, n (n - 1) / 2 of n = {len(turn.numbers)} links",
            f"crank: {reach_words(turn.crank_range)}",
        ),
    )
    span = kinematics.mechanism.driver.span
    if span is not None:
        out.print(f"what follows is of the pass from {degrees(span[0])} to {degrees(span[1])} deg")
    elif turn.crank_range.full and not kinematics.repeats:
        out.print("after a turn the links do not stand as before it: strokes and angles are those of the first turn")
    for one in (outputs_table(turn), transmission_table(turn)):
        if one:
            _print_titled(out, one)


def show_instant(instant: InstantQuantities, numbering: dict[str, int]) -> None:
    """Print the quantities of a linkage at a crank angle."""
    out, state = console(), instant.state
    out.print(f"\nat crank angle {degrees(state.angle)} deg, crank speed {numbers.quantity(state.speed, 6)} rad/s")
    _print_titled(out, links_table(instant, numbering))
    for push in instant.pushes:
        angle = float(push.angle[0])
        out.print(
            f"transmission angle of {push.driven}, pushed by {push.through}: {math.degrees(angle):.4f} deg; "
            f"pressure angle {math.degrees(abs(0.5 * math.pi - angle)):.4f} deg"
        )
    for one in instant_tables(instant):
        _print_titled(out, one)


def _print_titled(out: Console, shown: Table) -> None:
    print_lines(out, ("", shown.title))
    print_table(out, replace(shown, title=""), folding=shown.headings, framed=False)
