"""The moving machine of a validation: an engine's bodies over the exact ones, with magnified error, and curves.

Curves against the crank angle are small SVGs with a cursor that the page's script moves.
"""

from __future__ import annotations

import json
from typing import Any

import numpy as np
from markupsafe import Markup

from conrod.exact.motion import QUANTITIES
from conrod.report import numbers
from conrod.report.charts.canvas import NORMS
from conrod.report.charts.styles import label, svg_stroke
from conrod.report.html.page import html_template
from conrod.report.html.panels import PanelCurve, panel_svg
from conrod.report.html.parts import points_text
from conrod.report.kind import Part
from conrod.studies.validation.motion_curves import PAGE_UNITS
from conrod.studies.validation.moving_drawing import MAX_POWER, POSES, MovingMachine, moving_machine, transforms
from conrod.studies.validation.results import SceneStudy

STILL_SHARE = 1e-9  # of the other component's span: what moves by less is rounding, and is not drawn


def machine_html(part: Part[SceneStudy], anchor: str) -> str:
    """Return the HTML of a moving machine with controls and curves; empty if no run has poses."""
    machine = moving_machine(part.findings)
    if machine is None:
        return ""
    first, still = machine.runs[0], machine.still
    power, exact = machine.power(first), machine.exact[machine.still]
    error = machine.errors(first)[round(still * (len(machine.errors(first)) - 1) / POSES)]
    bodies, (start, end) = list(machine.drawing.bodies.items()), machine.ends
    degrees = start + (end - start) * still / POSES
    return html_template("machine.html.jinja").render(
        anchor=anchor, study=part.findings, box=" ".join(f"{one:.0f}" for one in machine.drawing.box), still=still,
        bodies=[Markup(svg) for _, svg in bodies[:-1]], ground=Markup(bodies[-1][1]), power=power,
        order=machine.drawing.order, magnification=numbers.magnification, powers=range(MAX_POWER + 1),
        exact=transforms(exact), engine=transforms(exact + 10.0**power * error),
        runs=[(label(run), _legend_sample(machine, k)) for k, run in enumerate(machine.runs)],
        panels=_panels(machine), data=Markup(json.dumps(_script_data(machine), separators=(",", ":"))),
        degrees=f"{degrees:.0f}", traces=_point_paths(machine), output=part.findings.scene.output,
    )  # fmt: skip


def _script_data(machine: MovingMachine) -> dict[str, Any]:
    """Return the numbers by which the page's script moves the drawing."""
    scene = machine.study.scene
    observed = next(point for point in scene.mechanism().observed if point.name == scene.output)
    x, y = (machine.drawing.scale * one for one in observed.point)
    return {
        "ends": machine.ends, "exact": np.round(machine.exact, 3).tolist(), "mm": 1e3 / machine.drawing.scale,
        "point": [scene.mechanism().body_index[observed.body], round(x, 4), round(-y, 4)],
        "runs": [
            {
                "power": machine.power(run),
                "errors": [[numbers.round_to_digits(one, 3) for one in row] for row in machine.errors(run).tolist()],
            }
            for run in machine.runs
        ],
    }  # fmt: skip


def _stroke(machine: MovingMachine, number: int) -> str:
    run = machine.runs[number]
    return svg_stroke(run.engine, run.preset)


def _legend_sample(machine: MovingMachine, number: int) -> Markup:
    return Markup(f'<svg viewBox="0 0 30 8" aria-hidden="true"><path d="M0 4H30" {_stroke(machine, number)}/></svg>')


def _point_paths(machine: MovingMachine) -> list[str]:
    scene, scale = machine.study.scene, machine.drawing.scale
    points = scene.motion(machine.angles[::4], scene.speed).points.values()
    return [points_text((scale * x, -scale * y) for x, y in point.position) for point in points]


def _panels(machine: MovingMachine) -> list[Markup]:
    """Draw for each quantity of the output its exact curve, and the errors of all runs."""
    scene, at, found = machine.study.scene, machine.still / POSES, list[Markup]()
    motion = scene.motion(machine.angles[::2], scene.speed).point(scene.output)
    along, ends = np.linspace(0.0, 1.0, len(machine.angles[::2])), machine.ends
    for quantity in QUANTITIES:
        unit, factor = PAGE_UNITS[quantity]
        values = factor * getattr(motion, quantity)
        # Each component in a scale of its own: the 12 mm of a ram are a flat line beside a height of -420 mm.
        spans = np.ptp(values, axis=0)
        for k, name in enumerate("xy"):
            if spans[k] > STILL_SHARE * spans.max():
                curve = PanelCurve(along, values[:, k], -1, f'class="{name}"')
                found.append(panel_svg(f"{quantity} of {scene.output}: {name} [{unit}]", [curve], ends, at))
        errors = [line for k in range(len(machine.runs)) for line in _error_curves(machine, k, quantity)]
        found.append(panel_svg(f"{quantity}: error of {scene.output} / {NORMS[quantity]}", errors, ends, at, log=True))
    return found


def _error_curves(machine: MovingMachine, number: int, quantity: str) -> list[PanelCurve]:
    """Return the curve of a run's errors over the drawn range; empty if the run has no curves."""
    run, (first, last) = machine.runs[number], (machine.angles[0], machine.angles[-1])
    if not run.curves:
        return []
    curve = run.curves[machine.study.scene.output][quantity]
    along = (curve.error_angle - first) / (last - first)
    inside = (along >= 0.0) & (along <= 1.0)
    return [PanelCurve(along[inside], curve.error[inside], number, _stroke(machine, number))] if inside.any() else []
