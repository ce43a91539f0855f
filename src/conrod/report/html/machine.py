"""The machine of a validation in motion: an engine's bodies over the exact ones, its error magnified; and curves."""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from markupsafe import Markup

from conrod.exact.motion import Array
from conrod.report import numbers
from conrod.report.charts.styles import colour, label
from conrod.report.drawing.drawing import telling_angle
from conrod.report.html.curves import Line, panel
from conrod.report.html.page import template
from conrod.report.html.parts import UNITS, Drawing, drawing_of
from conrod.report.kind import Part
from conrod.studies.validation.results import SceneStudy, ValidationResult

POSES = 360  # exact poses of a turn, between which nothing can be seen
VISIBLE = 0.06  # of the machine: what an error is magnified to, at most
MOST_POWER = 12
DASHES = ("", "6 3", "2 3", "8 3 2 3")  # of the presets of an engine, in their order
QUANTITIES = {"position": ("mm", 1e3), "velocity": ("m/s", 1.0), "acceleration": ("m/s²", 1.0)}


@dataclass(frozen=True)
class Moving:
    """A machine with the runs whose bodies are known over a turn, and how it is drawn.

    Attributes:
        runs: that have errors of poses, one at least.
    """

    part: Part[SceneStudy]
    runs: tuple[ValidationResult, ...]

    @cached_property
    def drawing(self) -> Drawing:
        """Shapes of the bodies."""
        return drawing_of(self.part.findings.scene)

    @cached_property
    def angles(self) -> Array:
        """Crank angles of the exact poses (`POSES` + 1,) [rad], over the stretch that the runs' last turn is."""
        first = self.runs[0].poses
        assert first is not None
        return np.linspace(first.angle[0], first.angle[-1], POSES + 1)

    @property
    def ends(self) -> tuple[float, float]:
        """The stretch as it is shown [deg]: a turn begins within the first."""
        whole = 0.0 if self.part.findings.scene.kinematics.mechanism.driver.span else 2.0 * math.pi
        first = self.angles[0] - (round(self.angles[0] / whole) * whole if whole else 0.0)
        return math.degrees(first), math.degrees(first + self.angles[-1] - self.angles[0])

    @property
    def still(self) -> int:
        """Number of the pose at the angle that the machine is drawn at where nothing moves."""
        first, last = np.radians(self.ends)
        return int(np.clip(round((telling_angle(self.part.findings.scene) - first) / (last - first) * POSES), 0, POSES))

    @cached_property
    def exact(self) -> Array:
        """Exact poses (`POSES` + 1, 3 n) of the drawing."""
        return self.drawing.poses(self.part.findings.scene.kinematics.poses(self.angles))

    def errors(self, run: ValidationResult) -> Array:
        """Errors of a run's poses (K, 3 n) in the drawing, K evenly over the stretch."""
        assert run.poses is not None
        return self.drawing.poses(run.poses.values)

    def power(self, run: ValidationResult) -> int:
        """Power of ten that makes a run's error visible."""
        errors = np.abs(self.errors(run)).reshape(-1, 3) * [1.0, 1.0, math.radians(UNITS / 4.0)]
        largest = float(errors.max())
        return int(np.clip(math.floor(math.log10(VISIBLE * UNITS / largest)), 0, MOST_POWER)) if largest else 0

    def command(self, run: ValidationResult) -> str:
        """The command that makes this run, and no other where it can be named."""
        options = {"--engine": run.engine, "--preset": run.preset if run.mode == "dynamic" else None}
        given = [f" {name} {value}" for name, value in options.items() if value and name not in self.part.command]
        return self.part.command + "".join(given)


def moving(part: Part[SceneStudy]) -> Moving | None:
    """The machine in motion; None where no run came to its end, or an earlier conrod kept no poses."""
    runs = tuple(run for run in part.findings.results if run.poses is not None and len(run.poses.angle) > 1)
    return Moving(part, runs) if runs else None


def machine_html(part: Part[SceneStudy], anchor: str) -> str:
    """The machine in motion with its controls and curves, as a part of a page; empty where there is nothing to move."""
    machine = moving(part)
    if machine is None:
        return ""
    first, still = machine.runs[0], machine.still
    power, exact = machine.power(first), machine.exact[machine.still]
    error = machine.errors(first)[round(still * (len(machine.errors(first)) - 1) / POSES)]
    bodies = list(machine.drawing.bodies.items())
    return template("machine.html.jinja").render(
        anchor=anchor, study=part.findings, box=" ".join(f"{one:.0f}" for one in machine.drawing.box), still=still,
        bodies=[Markup(svg) for _, svg in bodies[:-1]], ground=Markup(bodies[-1][1]), power=power,
        exact=_transforms(exact), engine=_transforms(exact + 10.0**power * error), powers=range(MOST_POWER + 1),
        runs=[(label(run), machine.command(run), _sample(machine, k)) for k, run in enumerate(machine.runs)],
        panels=_panels(machine), data=Markup(json.dumps(_data(machine), separators=(",", ":"))),
        degrees=f"{_degrees(machine, still):.0f}", traces=_traces(machine), output=part.findings.scene.output,
    )  # fmt: skip


def _degrees(machine: Moving, still: int) -> float:
    first, last = machine.ends
    return first + (last - first) * still / POSES


def _transforms(poses: Array) -> list[str]:
    """Attributes that put each body in its place."""
    return [f"translate({x:.3f} {y:.3f}) rotate({turn:.4f})" for x, y, turn in poses.reshape(-1, 3)]


def _data(machine: Moving) -> dict[str, Any]:
    """Numbers that page.js moves the drawing by; units of the drawing, and degrees."""
    scene = machine.part.findings.scene
    observed = next(point for point in scene.mechanism().observed if point.name == scene.output)
    x, y = (machine.drawing.scale * one for one in observed.point)
    return {
        "ends": machine.ends, "exact": np.round(machine.exact, 3).tolist(), "mm": 1e3 / machine.drawing.scale,
        "point": [scene.mechanism().body_index[observed.body], round(x, 4), round(-y, 4)],
        "runs": [
            {"power": machine.power(run), "errors": [[numbers.rounded(one, 3) for one in row] for row in errors]}
            for run in machine.runs
            for errors in [machine.errors(run).tolist()]
        ],
    }  # fmt: skip


def _look(machine: Moving, number: int) -> str:
    run = machine.runs[number]
    before = [one for one in machine.runs[:number] if one.engine == run.engine]
    dashes = DASHES[len(before) % len(DASHES)]
    return f'stroke="{colour(run.engine)}"' + (f' stroke-dasharray="{dashes}"' if dashes else "")


def _sample(machine: Moving, number: int) -> Markup:
    return Markup(f'<svg viewBox="0 0 30 8" aria-hidden="true"><path d="M0 4H30" {_look(machine, number)}/></svg>')


def _traces(machine: Moving) -> list[str]:
    scene, scale = machine.part.findings.scene, machine.drawing.scale
    points = scene.motion(machine.angles[::4], scene.speed).points.values()
    return [" ".join(f"{scale * x:.1f},{-scale * y:.1f}" for x, y in point.position) for point in points]


def _panels(machine: Moving) -> list[Markup]:
    """For each quantity of the output its exact curve, and the errors of all runs."""
    scene, at, found = machine.part.findings.scene, machine.still / POSES, list[Markup]()
    motion = scene.motion(machine.angles[::2], scene.speed).point(scene.output)
    along, ends = np.linspace(0.0, 1.0, len(machine.angles[::2])), machine.ends
    for quantity, (unit, factor) in QUANTITIES.items():
        values = factor * getattr(motion, quantity)
        exact = [Line(along, values[:, k], -1, f'class="{name}"') for k, name in enumerate("xy")]
        found.append(panel(f"{quantity} of {scene.output} [{unit}]: x, and y dashed", exact, ends, at))
        errors = [line for k in range(len(machine.runs)) for line in _error(machine, k, quantity)]
        found.append(panel(f"{quantity}: error of {scene.output} / {NORMS[quantity]}", errors, ends, at, log=True))
    return found


NORMS = {"position": "L", "velocity": "(ω L)", "acceleration": "(ω² L)"}


def _error(machine: Moving, number: int, quantity: str) -> list[Line]:
    """The errors of a run over the stretch; none of one whose curves are not kept."""
    run, (first, last) = machine.runs[number], (machine.angles[0], machine.angles[-1])
    if not run.curves:
        return []
    curve = run.curves[machine.part.findings.scene.output][quantity]
    along = (curve.error_angle - first) / (last - first)
    inside = (along >= 0.0) & (along <= 1.0)
    return [Line(along[inside], curve.error[inside], number, _look(machine, number))] if inside.any() else []
