"""The report of a validation: a page for each scene, and an index that opens with how far off each engine is."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from conrod.report import numbers
from conrod.report.charts.errors import overview_figure, refinement_figure
from conrod.report.charts.motion import motion_figure
from conrod.report.charts.panels import error_figure
from conrod.report.charts.styles import FIGURE_NAMES, completed, engine_title, label
from conrod.report.drawing.drawing import mechanism_svg
from conrod.report.figure import Figure
from conrod.report.html.animated import animated_svg
from conrod.report.html.moving import moving
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.results import summary_of, summary_words, versions_words
from conrod.report.scene_words import described, parameters_table
from conrod.report.table import Cell, Table, Toned, table
from conrod.report.template import rendered
from conrod.report.validation import tables
from conrod.scenes import CamFollower, Scene
from conrod.studies.validation.results import Curve, PoseErrors, SceneStudy, ValidationResult

ALT = {
    "mechanism": "The mechanism of {name} with its dimensions",
    "motion": "Position, velocity and acceleration of the engines over the exact curve of {name}",
    "error": "Error of every run of {name} against the crank angle",
    "order": "Error of {name} against step size",
}
# Of a span that is drawn: what cannot be seen.
GRID = 1e-4
ERROR_DIGITS = 4
POSE_DIGITS = 3


# -- what is saved ---------------------------------------------------------------------------------------------------


def _kept(study: SceneStudy) -> SceneStudy:
    """The study with its curves in as many digits as a figure can show."""
    thinned = (_curves_changed(r, _thinned) for r in study.results)
    return replace(study, results=tuple(replace(r, poses=r.poses and _rounded(r.poses)) for r in thinned))


def without_motion(study: SceneStudy) -> SceneStudy:
    """The study without the curves that only a figure of the motion shows."""
    return replace(study, results=tuple(_curves_changed(r, _error_alone) for r in study.results))


def _error_alone(curve: Curve) -> Curve:
    return replace(curve, angle=np.zeros(0), values=np.zeros((0, 2)))


def _thinned(curve: Curve) -> Curve:
    return Curve(
        angle=_on_grid(curve.angle),
        values=_on_grid(curve.values),
        error_angle=_on_grid(curve.error_angle),
        error=np.array([numbers.rounded(error, ERROR_DIGITS) for error in curve.error.tolist()]),
    )


def _rounded(poses: PoseErrors) -> PoseErrors:
    """Poses in as many digits as a drawing can show, however magnified; what is rounding is nothing."""
    values = np.where(np.abs(poses.values) < numbers.ROUNDING, 0.0, poses.values)
    shown = [[numbers.rounded(one, POSE_DIGITS) for one in row] for row in values.tolist()]
    return PoseErrors(_on_grid(poses.angle), np.array(shown))


def _curves_changed(result: ValidationResult, change: Callable[[Curve], Curve]) -> ValidationResult:
    if result.curves is None:
        return result
    curves = {p: {q: change(curve) for q, curve in curves.items()} for p, curves in result.curves.items()}
    return replace(result, curves=curves)


def _on_grid(values: Any) -> Any:
    """Values rounded to a power of ten that is `GRID` of their span or less."""
    span = float(np.ptp(values, axis=0).max()) if len(values) else 0.0
    return values if span == 0.0 else np.round(values, -int(np.floor(np.log10(GRID * span))))


def _summary(study: SceneStudy) -> dict[str, Any]:
    return {"closed_form": study.scene.closed_form, **summary_of(study, partial(_sizes, study.scene.lengths))}


def _sizes(lengths: Mapping[str, float], result: ValidationResult) -> dict[str, Any]:
    largest = {name: result.largest(name) for name in ("position", "velocity", "acceleration", "total")}
    places = [lengths[p] * size["max"] for p, sizes in (result.errors or {}).items() if (size := sizes["position"])]
    metres = max(places, default=None)
    return {"mode": result.mode, "largest": largest, "position_m": metres, "allowed": result.limits}


# -- a scene's page --------------------------------------------------------------------------------------------------


def _figures(study: SceneStudy, shown: Sequence[str]) -> dict[str, Figure]:
    """The figures of a page by name; those of the runs only where one completed."""
    runs, alt = completed(study.results), dict(ALT)
    draw: dict[str, Any] = {"mechanism": partial(mechanism_svg, study.scene)}
    if machine := moving(study):
        draw["moving"] = partial(animated_svg, machine)
        magnified = f"its error magnified 10^{machine.power(machine.runs[0])} times"
        alt["moving"] = f"In motion: in grey {study.name}, exact; in colour {label(machine.runs[0])}, {magnified}"
    if runs:
        draw |= {"motion": partial(motion_figure, study), "error": partial(error_figure, study)}
    if any(run.refinement for run in runs):
        draw["order"] = partial(refinement_figure, study)
    return {
        name: Figure(f"{study.name}-{name}", alt[name].format(name=study.name), one)
        for name, one in draw.items()
        if name in shown
    }


def _page(part: Part[SceneStudy]) -> Page:
    study, scene = part.findings, part.findings.scene
    runs = completed(study.results)
    has_contact = bool(scene.mechanism().cam_contacts)
    figures = _figures(study, part.options.get("figures", FIGURE_NAMES))
    whole, last = _stretch(scene, runs[0].revolutions) if runs else ("", "")
    points = [(p, tables.errors_table(study, p)) for p in scene.lengths] if runs else []
    text = rendered(
        "validation", study=study, scene=scene, part=part, description=described(scene), figures=figures, whole=whole,
        last=last, summary=summary_words(study.results), versions=versions_words(study.results),
        verdicts=tables.verdicts_table([study]), added=tables.added_words(study), has_contact=has_contact,
        parameters=parameters_table(scene), noticed=tables.qualification_table(study),
        one_pass=scene.kinematics.mechanism.driver.span is not None, kinematic=tables.kinematic_table(study),
        refined=any(run.refinement for run in runs), points=points, orders=tables.orders_table(study),
        closure=tables.closure_table(study), prediction=tables.prediction_table(study),
        breaks=_breaks(scene),
        cam=scene if isinstance(scene, CamFollower) else None, tolerances=tables.tolerances_table(study),
        settings=tables.settings_tables(study, has_contact),
    )  # fmt: skip
    return Page(text, tuple(figures.values()))


def _live(part: Part[SceneStudy], anchor: str) -> str:
    from conrod.report.html.machine import machine_html

    return machine_html(part, anchor)


def _stretch(scene: Scene, revolutions: float) -> tuple[str, str]:
    """The stretch that was run, and the part of it that the curves show."""
    if scene.kinematics.mechanism.driver.span is None:
        turns = numbers.quantity(revolutions)
        return f"{turns} revolutions", f"the last of {turns} revolutions"
    degrees = numbers.quantity(360.0 * revolutions)
    return f"the pass of {degrees} deg", f"the pass of {degrees} deg that the input makes, which cannot turn fully"


def _breaks(scene: Scene) -> str:
    """Crank angles [deg] where the acceleration or the jerk jumps."""
    return ", ".join(numbers.quantity(float(np.degrees(a))) for a in scene.break_angles())


# -- the index -------------------------------------------------------------------------------------------------------


def _index(index: Index[SceneStudy]) -> Page:
    scenes = {name: entry["summary"] for name, entry in index.entries.items()}
    figure = Figure(
        "overview", "Largest position error of every machine, engine and preset", partial(overview_figure, scenes)
    )
    text = rendered(
        "validation-index", entries=index.entries, failed=[n for n, scene in scenes.items() if not scene["passed"]],
        errors=_errors_table(index.entries), figure=figure, reasons=_reasons(index.entries), origin=index.origin,
        versions=index.versions, unsupported=_unsupported_table(index.entries),
    )  # fmt: skip
    return Page(text, (figure,))


def _link(name: str, entry: Mapping[str, Any]) -> str:
    return f"[{name}]({entry['page']})"


def _errors_table(entries: Mapping[str, Mapping[str, Any]]) -> Table:
    """A row for each machine, a column for each engine and preset: the largest position error over L."""
    runs = dict.fromkeys(_run(r) for entry in entries.values() for r in entry["summary"]["results"])
    rows = []
    for name, entry in entries.items():
        cells = {_run(r): _error(r) for r in entry["summary"]["results"]}
        rows.append((_link(name, entry), entry["title"], *(cells.get(run, "") for run in runs)))
    right = [" ".join(run) for run in runs]
    return table(("machine", "title", *right), rows, right, "largest position error / L over the run (in mm)")


def _run(result: Mapping[str, Any]) -> tuple[str, str]:
    return engine_title(result["engine"]), result["preset"] or "kinematic"


def _error(result: Mapping[str, Any]) -> Cell:
    completed = result["outcome"] == "completed"
    text = numbers.measured(result["largest"]["position"]) if completed else result["outcome"]
    # A summary that an earlier conrod wrote has no lengths.
    if completed and "position_m" in result and text != numbers.BELOW_ROUNDING:
        text += f" ({numbers.measured(1e3 * result['position_m'])} mm)"
    return Toned(text, "bad") if result["passed"] is False else text


def _reasons(entries: Mapping[str, Mapping[str, Any]]) -> list[str]:
    """List of what did not pass, with reasons."""
    return [
        f"{_link(name, entry)}, {' '.join(_run(r))}: {r['verdict']}"
        for name, entry in entries.items()
        for r in entry["summary"]["results"]
        if r["passed"] is False
    ]


def _unsupported_table(entries: Mapping[str, Mapping[str, Any]]) -> Table:
    """Table of what an engine cannot do, with the reason."""
    found = dict.fromkeys(
        (_link(name, entry), engine_title(r["engine"]), r["reason"])
        for name, entry in entries.items()
        for r in entry["summary"]["results"]
        if r["outcome"] == "unsupported"
    )
    return table(("machine", "engine", "why"), found)


KIND = Kind(
    name="validation",
    findings=SceneStudy,
    title=lambda study: study.scene.title,
    summary=_summary,
    page=_page,
    index=_index,
    kept=_kept,
    digits=6,
    live=_live,
    in_live=("-moving.svg", "-motion.svg"),
    tile="-moving.svg",
)
