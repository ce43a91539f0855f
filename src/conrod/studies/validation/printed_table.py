"""The shear press's printed table (document 000) against a run."""

from __future__ import annotations

import csv
from dataclasses import dataclass
from importlib.resources import files
from typing import Any

import numpy as np

from conrod.engines import Engine
from conrod.engines.running import whole_run
from conrod.exact.motion import Array, Motion
from conrod.runs.trajectory import Outcome, Track
from conrod.scenes import Scene, ShearPress
from conrod.studies.validation.results import PrintedCells

# Printed every 5 degrees: 72 divides the steps, so that the printed angles are sampled, and the schemes' errors
# (order 2 at worst: (2 pi / 7200)^2 = 8e-7) stay below a twentieth of the last printed unit.
STEPS_PER_REVOLUTION = 7200
# Run in for ten degrees before the first printed angle: soft closures start closed and come to rest within some ten of
# their time constants, and every quantity has samples on both sides of the angle.
LEAD_STEPS = 200
ALLOWED = 0.55  # of the last printed unit: half of it is the rounding of the print
MM = 1e-3


@dataclass(frozen=True)
class Column:
    """A printed column: what it is of point G, and its last printed unit [mm, mm/s, mm/s^2]."""

    name: str
    quantity: str
    component: int | None  # 0 x, 1 y, None the magnitude
    unit: float


COLUMNS = (
    Column("yG", "position", 1, 0.01),
    Column("xG", "position", 0, 0.01),
    Column("vyG", "velocity", 1, 0.1),
    Column("vxG", "velocity", 0, 0.1),
    Column("ayG", "acceleration", 1, 0.1),
    Column("axG", "acceleration", 0, 0.1),
    Column("vG", "velocity", None, 0.1),
    Column("aG", "acceleration", None, 0.1),
)


def applies(scene: Scene) -> bool:
    """True if the table was printed for this machine: its crank, rod and speed."""
    document = ShearPress()
    return isinstance(scene, ShearPress) and (scene.crank, scene.rod, scene.speed) == (
        document.crank,
        document.rod,
        document.speed,
    )


def compare_with_print(scene: Scene, engine: Engine[Any], preset: str) -> PrintedCells:
    """Cells of the table that the exact motion and the engine meet: none where the run did not complete."""
    settings = engine.presets[preset](scene, STEPS_PER_REVOLUTION)
    step = 2.0 * np.pi / STEPS_PER_REVOLUTION
    lead = LEAD_STEPS * step
    revolutions = 1.0 + 2.0 * LEAD_STEPS / STEPS_PER_REVOLUTION
    trajectory = whole_run(engine, scene, settings, revolutions, start_angle=-lead)
    completed = trajectory.outcome is Outcome.COMPLETED
    table = _table()
    angles = np.radians(table["theta_deg"])
    exact = scene.motion(angles, scene.speed)
    cells = agreeing = met = 0
    worst = 0.0
    for column in COLUMNS:
        printed = table[column.name]
        truth = _component(_exact(exact, column.quantity), column) / MM
        engine_value = np.full_like(truth, np.inf)
        if completed:
            engine_value = _component(_at(getattr(trajectory.points["G"], column.quantity), angles), column) / MM
        agrees = np.abs(truth - printed) <= 0.5 * column.unit * (1.0 + 1e-9)
        off = np.abs(engine_value - printed)[agrees] / column.unit
        cells += len(printed)
        agreeing += int(agrees.sum())
        met += int((off <= ALLOWED).sum())
        worst = max(worst, float(off.max(initial=0.0)))
    return PrintedCells(cells, agreeing, met, worst)


def _table() -> dict[str, Array]:
    text = files("conrod.scenes").joinpath("shear_press_table.csv").read_text(encoding="utf-8")
    rows = list(csv.DictReader(text.splitlines()))
    return {name: np.array([float(row[name]) for row in rows]) for name in rows[0]}


def _exact(motion: Motion, quantity: str) -> Array:
    values: Array = getattr(motion.point("G"), quantity)
    return values


def _at(track: Track, angles: Array) -> Array:
    """Values at crank angles, linear between samples."""
    at = track.instants.angle
    return np.column_stack([np.interp(angles, at, track.values[:, k]) for k in (0, 1)])


def _component(values: Array, column: Column) -> Array:
    return np.linalg.norm(values, axis=1) if column.component is None else values[:, column.component]
