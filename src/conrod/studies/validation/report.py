"""The report of a validation: a page for each scene, and an index that opens with how far off each engine is."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from conrod.errors import InvalidInput
from conrod.report import numbers
from conrod.report.charts.styles import engine_title, label
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Part
from conrod.report.results import index_words, scene_summary, scene_verdict
from conrod.report.table import Cell, ColouredCell, Table, table
from conrod.scenes import Scene, scene_named
from conrod.studies.validation import tables as validation_tables
from conrod.studies.validation.motion_curves import marked_runs, motion_words
from conrod.studies.validation.results import (
    Curve,
    PointSamples,
    PoseErrors,
    SceneStudy,
    ValidationResult,
    drawable_runs,
)

GRID_SHARE = 1e-4  # of a curve's span: less cannot be seen in a figure
ERROR_DIGITS, POSE_DIGITS = 4, 3


def heading(study: SceneStudy) -> str:
    """Return a page's title: the machine and its changed parameters, 'saw-500rpm (speed 320 rpm): ..'."""
    try:
        shipped = scene_named(study.name).parameters
    except InvalidInput:  # a member of a family, or a machine of the user's
        shipped = study.scene.parameters
    facts = study.scene.parameter_facts()
    words = ", ".join(
        " ".join([name, *numbers.in_shown_unit(value, facts[name].unit)]).removesuffix(" -")
        for name, value in study.scene.parameters.items()
        if name in facts and value != shipped.get(name, value)
    )
    return f"{study.name}{f' ({words})' if words else ''}: {study.scene.title}"


# -- curves to save ---------------------------------------------------------------------------------------------------


def _drawable_study(study: SceneStudy) -> SceneStudy:
    """Return the study with its curves rounded to the digits that a figure can show.

    Of the samples that the figure of motion marks, the runs take turns, so that no mark covers another.
    """
    drawn = drawable_runs(study.results)
    turns = {id(run): slice(place, None, len(drawn)) for place, run in enumerate(drawn)}
    results = (_drawable_result(run, turns.get(id(run), slice(None))) for run in study.results)
    return replace(study, results=tuple(results))


def _drawable_result(result: ValidationResult, marked: slice) -> ValidationResult:
    curves = result.curves and {
        point: {
            quantity: Curve(_round_to_span(curve.error_angle), _round_array(curve.error, ERROR_DIGITS))
            for quantity, curve in curves.items()
        }
        for point, curves in result.curves.items()
    }
    poses = result.poses
    if poses is not None:
        # Rounding noise is drawn as zero, however magnified.
        values = np.where(np.abs(poses.values) < numbers.ROUNDING, 0.0, poses.values)
        poses = PoseErrors(_round_to_span(poses.angle), _round_array(values, POSE_DIGITS))
    samples = result.samples and {
        quantity: PointSamples(_round_to_span(one.angle[marked]), *_round_to_span(np.array([one.x, one.y])[:, marked]))
        for quantity, one in result.samples.items()
    }
    return replace(result, curves=curves, poses=poses, samples=samples)


def _round_array(values: Any, digits: int) -> Any:
    return np.vectorize(lambda one: numbers.round_to_digits(one, digits), otypes=[float])(values)


def _round_to_span(values: Any) -> Any:
    """Round values (K,) or (2, K) to a power of ten, at most `GRID_SHARE` of their span."""
    span = float(np.ptp(values, axis=-1).max()) if np.size(values) else 0.0
    # Adding zero makes -0.0 a plain zero.
    return values if span == 0.0 else np.round(values, -int(np.floor(np.log10(GRID_SHARE * span)))) + 0.0


def _summary(study: SceneStudy) -> dict[str, Any]:
    return {
        "closed_form": study.scene.closed_form,
        **scene_summary(study, partial(_largest_errors, study.scene.lengths)),
    }


def _largest_errors(lengths: Mapping[str, float], result: ValidationResult) -> dict[str, Any]:
    largest = {name: result.largest(name) for name in ("position", "velocity", "acceleration", "total")}
    places = [lengths[p] * size["max"] for p, sizes in (result.errors or {}).items() if (size := sizes["position"])]
    metres = max(places, default=None)
    return {"mode": result.mode, "largest": largest, "position_m": metres, "allowed": result.limits}


tables = validation_tables  # for the page's template


# -- a scene's page --------------------------------------------------------------------------------------------------


def figures(study: SceneStudy) -> dict[str, Figure]:
    """Return the figures of a scene's page by name; error figures only if a run completed."""
    from conrod.report.drawing.drawing import mechanism_svg
    from conrod.studies.validation.charts import error_figure, refinement_figure
    from conrod.studies.validation.motion_chart import motion_figure
    from conrod.studies.validation.moving_drawing import animated_svg, moving_machine

    name = study.name
    drawn: dict[str, tuple[str, Any]] = {
        "mechanism": (f"The mechanism of {name} with its dimensions", partial(mechanism_svg, study.scene)),
        "motion": (motion_words(study), partial(motion_figure, study)),
    }
    if machine := moving_machine(study):
        magnified = f"its error {numbers.magnification(machine.power(machine.runs[0]))}"
        alt = f"In motion: in grey {name}, exact; in colour {label(machine.runs[0])}, {magnified}"
        drawn["moving"] = (alt, partial(animated_svg, machine))
    if drawable_runs(study.results):
        drawn["error"] = (f"Error of every run of {name} against the crank angle", partial(error_figure, study))
    if any(run.refinement for run in study.results):
        drawn["order"] = (f"Error of {name} against step size", partial(refinement_figure, study))
    return {which: Figure(f"{name}-{which}", alt, draw) for which, (alt, draw) in drawn.items()}


def has_marks(study: SceneStudy) -> bool:
    """Return True if samples of a run were saved, so that the figure of motion marks them."""
    return bool(marked_runs(study))


def break_angles_text(scene: Scene) -> str:
    """List the crank angles [deg] at which an acceleration or a jerk jumps."""
    return ", ".join(numbers.quantity(float(np.degrees(angle))) for angle in scene.break_angles())


def _live_html(part: Part[SceneStudy], anchor: str) -> str:
    """Return the HTML of the drawing that moves, under an anchor of the page; empty if nothing is drawn."""
    from conrod.studies.validation.machine_page import machine_html

    return machine_html(part, anchor)


# -- the index -------------------------------------------------------------------------------------------------------


def overview(index: Index[SceneStudy]) -> Figure:
    """Return the figure of the position errors of all engines on all machines."""
    from conrod.studies.validation.charts import overview_figure

    scenes = {name: entry["summary"] for name, entry in index.entries.items()}
    alt = "Largest position error of every machine, engine and preset"
    return Figure("overview", alt, partial(overview_figure, scenes))


def _link(name: str, entry: Mapping[str, Any]) -> str:
    return f"[{name}]({entry['page']})"


def errors_table(entries: Mapping[str, Mapping[str, Any]]) -> Table:
    """Return the largest position error of each machine, by engine and preset."""
    runs = dict.fromkeys(_engine_and_preset(r) for entry in entries.values() for r in entry["summary"]["results"])
    rows = []
    for name, entry in entries.items():
        cells = {_engine_and_preset(r): _error_cell(r) for r in entry["summary"]["results"]}
        rows.append((_link(name, entry), entry["title"], *(cells.get(run, "") for run in runs)))
    right = [" ".join(run) for run in runs]
    return table(("machine", "title", *right), rows, right, "largest position error / L over the run (in mm)")


def _engine_and_preset(result: Mapping[str, Any]) -> tuple[str, str]:
    return engine_title(result["engine"]), result["preset"] or "kinematic"


def _error_cell(result: Mapping[str, Any]) -> Cell:
    completed = result["outcome"] == "completed"
    text = numbers.measured_text(result["largest"]["position"]) if completed else result["outcome"]
    if completed and text != numbers.BELOW_ROUNDING:
        text += f" ({numbers.measured_text(1e3 * result['position_m'])} mm)"
    return ColouredCell(text, "bad") if result["passed"] is False else text


def reasons(entries: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """List the results that did not pass, with reasons."""
    return [
        f"{_link(name, entry)}, {' '.join(_engine_and_preset(r))}: {r['verdict']}"
        for name, entry in entries.items()
        for r in entry["summary"]["results"]
        if r["passed"] is False
    ]


def unsupported_table(entries: Mapping[str, Mapping[str, Any]]) -> Table:
    """Return a row for each machine that an engine does not support, with the reason."""
    found = dict.fromkeys(
        (_link(name, entry), engine_title(r["engine"]), r["reason"])
        for name, entry in entries.items()
        for r in entry["summary"]["results"]
        if r["outcome"] == "unsupported"
    )
    return table(("machine", "engine", "why"), found)


def headline(entries: Mapping[str, Mapping[str, Any]]) -> str:
    """Say of how many machines how far off engines are, and whether all judged results are within tolerance."""
    return f"{len(entries)} machines. {index_words(entries)}"


VALIDATION_REPORT = Kind(
    name="validation",
    findings=SceneStudy,
    title=lambda study: study.scene.title,
    summary=_summary,
    printed=validation_tables.results_to_print,
    verdict=scene_verdict,
    headline=headline,
    prepare_to_save=_drawable_study,
    digits=6,
    places={"angle": "difference", "error_angle": "error"},
    live_html=_live_html,
    replaced_figures=("-moving.svg",),
    tile="-moving.svg",
)
