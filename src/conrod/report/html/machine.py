"""The machine of a validation in motion: an engine's bodies over the exact ones, its error magnified; and curves."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from markupsafe import Markup

from conrod.report import numbers
from conrod.report.charts.styles import colour, label
from conrod.report.html.curves import Line, panel
from conrod.report.html.moving import MOST_POWER, POSES, Moving, moving, transforms
from conrod.report.html.page import template
from conrod.report.kind import Part
from conrod.studies.validation.results import SceneStudy

DASHES = ("", "6 3", "2 3", "8 3 2 3")  # of the presets of an engine, in their order
QUANTITIES = {"position": ("mm", 1e3), "velocity": ("m/s", 1.0), "acceleration": ("m/s²", 1.0)}


def machine_html(part: Part[SceneStudy], anchor: str) -> str:
    """The machine in motion with its controls and curves, as a part of a page; empty where there is nothing to move."""
    machine = moving(part.findings)
    if machine is None:
        return ""
    first, still = machine.runs[0], machine.still
    power, exact = machine.power(first), machine.exact[machine.still]
    error = machine.errors(first)[round(still * (len(machine.errors(first)) - 1) / POSES)]
    bodies = list(machine.drawing.bodies.items())
    return template("machine.html.jinja").render(
        anchor=anchor, study=part.findings, box=" ".join(f"{one:.0f}" for one in machine.drawing.box), still=still,
        bodies=[Markup(svg) for _, svg in bodies[:-1]], ground=Markup(bodies[-1][1]), power=power,
        exact=transforms(exact), engine=transforms(exact + 10.0**power * error), powers=range(MOST_POWER + 1),
        runs=[(label(run), _sample(machine, k)) for k, run in enumerate(machine.runs)],
        panels=_panels(machine), data=Markup(json.dumps(_data(machine), separators=(",", ":"))),
        degrees=f"{_degrees(machine, still):.0f}", traces=_traces(machine), output=part.findings.scene.output,
    )  # fmt: skip


def _degrees(machine: Moving, still: int) -> float:
    first, last = machine.ends
    return first + (last - first) * still / POSES


def _data(machine: Moving) -> dict[str, Any]:
    """Numbers that page.js moves the drawing by; units of the drawing, and degrees."""
    scene = machine.study.scene
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
    scene, scale = machine.study.scene, machine.drawing.scale
    points = scene.motion(machine.angles[::4], scene.speed).points.values()
    return [" ".join(f"{scale * x:.1f},{-scale * y:.1f}" for x, y in point.position) for point in points]


def _panels(machine: Moving) -> list[Markup]:
    """For each quantity of the output its exact curve, and the errors of all runs."""
    scene, at, found = machine.study.scene, machine.still / POSES, list[Markup]()
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
    curve = run.curves[machine.study.scene.output][quantity]
    along = (curve.error_angle - first) / (last - first)
    inside = (along >= 0.0) & (along <= 1.0)
    return [Line(along[inside], curve.error[inside], number, _look(machine, number))] if inside.any() else []
