"""What the command line prints, and its progress."""

from __future__ import annotations

import math
from collections.abc import Sequence

from rich.console import Console
from rich.markup import escape
from rich.padding import Padding
from rich.table import Table
from rich.text import Text

from conrod.engines import engine_names
from conrod.errors import unknown_choice
from conrod.report.numbers import SHOWN_UNITS
from conrod.report.pack.export import as_csv, as_npz, exact_columns
from conrod.report.scene_words import described
from conrod.report.terminal import console
from conrod.scenes import SCENES, Scene
from conrod.scenes.catalogue import catalogue_heading, catalogue_names, dynamics_names
from conrod.studies.frame.scene_summary import dead_centres, jumps, stroke

WIDE = 400  # for lines that tell of a source
CSV_SAMPLES = 360


# -- show ------------------------------------------------------------------------------------------------------------


def show_catalogue() -> None:
    """One line for each scene, each machine of the catalogue, and each engine."""
    out = console(WIDE)
    scenes = [(name, scene.title, scene.source) for name, scene in SCENES.items()]
    _listed(out, "scenes with a closed form", ("name", "title", "source"), scenes)
    machines = []
    for name in catalogue_names():
        heading = catalogue_heading(name)
        links = f"{heading.links}, one pass" if heading.one_pass else str(heading.links)
        machines.append((name, heading.title, links, heading.source))
    _listed(out, "catalogue (machines from files)", ("name", "title", "moving links", "source"), machines)
    loaded = []
    for name in dynamics_names():
        heading = catalogue_heading(name)
        loaded.append((name, heading.title, str(heading.links), heading.source))
    _listed(out, "dynamics (under loads, or in free motion)", ("name", "title", "moving links", "source"), loaded)
    out.print(f"engines: {', '.join(engine_names())}")


def _listed(out: Console, title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    table = Table(title=title, title_justify="left", title_style="bold", box=None, pad_edge=False)
    for heading in headings:
        table.add_column(heading, no_wrap=True, overflow="ellipsis")
    for row in rows:
        table.add_row(*map(escape, row))
    out.print(table)
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
    table = Table(box=None, pad_edge=False)
    for heading in ("parameter", "value", "unit", "meaning"):
        table.add_column(heading, justify="right" if heading == "value" else "left")
    for parameter in scene.parameter_facts().values():
        unit, scale = SHOWN_UNITS.get(parameter.unit, (parameter.unit, 1.0))
        value = f"{scene.parameters[parameter.name] * scale:.6g}"
        table.add_row(parameter.name, value, unit, parameter.meaning)
    out.print(table)
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


# -- export ----------------------------------------------------------------------------------------------------------


def exported(name: str, scene: Scene, kind: str, steps_per_revolution: int | None, revolutions: int) -> str | bytes:
    """Content of an exported file."""
    if kind == "mjcf":
        from conrod.engines.mujoco.standalone import standalone_mjcf

        return standalone_mjcf(name, scene, steps_per_revolution)
    if kind not in ("csv", "npz"):
        raise unknown_choice("format", kind, ("mjcf", "csv", "npz", "pack"))
    columns = exact_columns(scene, steps_per_revolution or CSV_SAMPLES, revolutions)
    return as_csv(columns) if kind == "csv" else as_npz(columns)
