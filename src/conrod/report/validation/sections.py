"""The sections of a scene's page, each a function from the study to Markdown."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from conrod.engines.follower import follower_lift
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.tables import bullets, paragraphs, table
from conrod.report.validation import prose
from conrod.report.validation.verdicts import verdict
from conrod.runs.convergence import PAIRS_AGREE, observed_order
from conrod.runs.trajectory import Outcome
from conrod.scenes import CamFollower, Scene
from conrod.studies.validation.results import QUANTITIES, Result, SceneStudy

MEASURES = ("max", "rms", "final")


def has_contact(study: SceneStudy) -> bool:
    """Whether a joint of the scene acts by contact."""
    return bool(study.scene.mechanism().cam_contacts)


def dynamic(study: SceneStudy) -> list[Result]:
    """The results of real time stepping."""
    return [r for r in study.results if r.mode == "dynamic"]


def name_of(result: Result) -> list[str]:
    """The first two cells of a row: engine and preset."""
    return [engine_title(result.engine), result.preset or "kinematic mode"]


def verdicts(study: SceneStudy) -> str:
    """One line for each run."""
    rows = [
        [*name_of(r), numbers.MISSING if r.steps_per_revolution is None else str(r.steps_per_revolution), verdict(r)]
        for r in study.results
    ]
    return table(["engine", "preset", "steps per revolution", "verdict"], rows)


def parameters(study: SceneStudy) -> str:
    """Values, units and meanings of the scene's parameters."""
    facts = study.scene.parameter_facts()
    rows = []
    for name, value in study.scene.parameters.items():
        shown, unit = numbers.in_shown_unit(value, facts[name].unit)
        rows.append([f"`{name}`", shown, unit, facts[name].meaning])
    return table(["parameter", "value", "unit", "meaning"], rows)


def errors(study: SceneStudy) -> str:
    """A table for each observed point, with its exact peaks."""
    runs = [r for r in dynamic(study) if r.errors is not None]
    blocks = []
    for point, length in study.scene.lengths.items():
        shown = [r for r in runs if r.errors is not None and point in r.errors]
        rows = [[*name_of(r), *(_sizes(r, point, q) for q in (*QUANTITIES, "total"))] for r in shown]
        head = ["engine", "preset", *(f"{q}: max, rms, final" for q in (*QUANTITIES, "total"))]
        blocks += [f"### Point {point}", _peaks(study, point, length), table(head, rows)]
    return paragraphs(prose.ERRORS, *blocks)


def _sizes(result: Result, point: str, quantity: str) -> str:
    assert result.errors is not None
    size = result.errors[point].get(quantity)
    return numbers.MISSING if size is None else ", ".join(numbers.measured(size[m]) for m in MEASURES)


def _peaks(study: SceneStudy, point: str, length: float) -> str:
    """L and the exact peaks, in mm, beside what velocity and acceleration are divided by."""
    speed = abs(study.scene.speed)
    turn = np.linspace(*study.scene.kinematics.span, 7201)
    exact = study.scene.motion(turn, study.scene.speed).point(point)
    velocity, acceleration = (
        1e3 * float(np.linalg.norm(values, axis=1).max()) for values in (exact.velocity, exact.acceleration)
    )
    rows = [
        ["position", f"L = {numbers.quantity(1e3 * length)} mm", "-"],
        ["velocity", f"ω L = {numbers.quantity(1e3 * speed * length)} mm/s", f"{numbers.quantity(velocity)} mm/s"],
        [
            "acceleration",
            f"ω² L = {numbers.quantity(1e3 * speed**2 * length)} mm/s²",
            f"{numbers.quantity(acceleration)} mm/s²",
        ],
    ]
    return table(["exact motion", "errors are divided by", "exact peak"], rows)


def orders(study: SceneStudy) -> str:
    """Errors along the refinement path and the order that they show."""
    runs = [r for r in dynamic(study) if r.refinement]
    steps = sorted({p.steps_per_revolution for r in runs for p in r.refinement})
    head = ["engine", "preset", "quantity", *(f"N = {n}" for n in steps), "order"]
    rows = []
    for run in runs:
        by_steps = {p.steps_per_revolution: p for p in run.refinement}
        for quantity in QUANTITIES:
            cells = []
            for n in steps:
                point = by_steps.get(n)
                stable = None if point is None else getattr(point, quantity)
                ended = "" if point is None or point.outcome == "completed" else f" ({point.outcome})"
                cells.append(numbers.measured(stable) + ended)
            rows.append([*name_of(run), quantity, *cells, _order(run, quantity)])
    return paragraphs(prose.ORDER, table(head, rows))


def _order(run: Result, quantity: str) -> str:
    """The claimed order, or what the errors do instead."""
    claimed = None if run.order is None else run.order.get(quantity)
    if claimed is not None:
        return numbers.order(claimed)
    stable = [(p.steps_per_revolution, e) for p in run.refinement if (e := getattr(p, quantity)) is not None]
    if len(stable) < 2:
        return numbers.MISSING
    pairs = [p for p in observed_order([n for n, _ in stable], [e for _, e in stable]).pairs if p is not None]
    if pairs and max(pairs[-2:]) <= PAIRS_AGREE:
        return f"none: plateau at {numbers.measured(stable[-1][1])}"
    return "none claimed: pairs " + ", ".join(f"{round(p, 1) + 0.0:.1f}" for p in pairs)


def closure(study: SceneStudy) -> str:
    """Closure, phase and drive of every run."""
    head = ["engine", "preset", "gap, max / L", "gap rate, max / (ω L)", "gap acceleration, max / (ω² L)"]
    head += ["phase [rad], max", "final", "speed ripple", "angular acceleration / ω²"]

    def drive(run: Result) -> list[str]:
        return _values(run.drive, ("speed", "acceleration"))

    rows = [
        [*name_of(r), *_values(r.closure, QUANTITIES), *_values(r.phase, ("max", "final")), *drive(r)]
        for r in dynamic(study)
        if r.closure is not None
    ]
    text = (
        "Closure is the largest gap left open in any joint, its rate and its acceleration, over the largest L of the "
        "scene. Phase is the crank angle against ω t; the drive is its rate against ω, and its angular acceleration "
        "against zero."
    )
    return paragraphs(text, table(head, rows))


def prediction(study: SceneStudy) -> str:
    """Errors told from the joints alone, beside the measured ones."""

    def entry(run: Result, quantity: str) -> str:
        told = None if run.prediction is None else run.prediction[quantity]
        return ", ".join([numbers.measured(run.largest(quantity)), *_values(told, ("predicted", "difference"))])

    rows = [[*name_of(r), *(entry(r, q) for q in QUANTITIES)] for r in dynamic(study) if r.prediction is not None]
    head = ["engine", "preset", *(f"{q}: measured, told, difference" for q in QUANTITIES)]
    return paragraphs(prose.PREDICTION, table(head, rows))


def _values(values: Mapping[str, float | None] | None, names: tuple[str, ...]) -> list[str]:
    return [numbers.measured(None if values is None else values.get(name)) for name in names]


def kinematic(study: SceneStudy) -> str:
    """Kinematic mode: the proof of the model."""
    rows = [
        [
            engine_title(r.engine),
            numbers.measured(r.largest("position")),
            numbers.measured(r.largest("velocity")),
            *_values(r.closure, ("position",)),
            numbers.measured(r.tolerance.position),
            numbers.measured(r.tolerance.velocity),
            r.tolerance.reason,
            verdict(r),
        ]
        for r in study.results
        if r.mode == "kinematic"
    ]
    head = ["engine", "position error / L, max", "velocity error / (ω L), max", "gap / L, max"]
    head += ["position allowed", "velocity allowed", "because", "verdict"]
    one_pass = study.scene.kinematics.mechanism.driver.span is not None
    text = prose.KINEMATIC.format(stretch="its one pass" if one_pass else "one turn")
    return paragraphs(text, prose.KINEMATIC_CONTACT if has_contact(study) else "", table(head, rows))


def tolerances(study: SceneStudy) -> str:
    """What was allowed in dynamic mode, and why."""
    names = ("position", "velocity", "acceleration", "total", "velocity_rms")
    rows = [
        [*name_of(r), *(numbers.measured(getattr(r.tolerance, n)) for n in names), _because(r)] for r in dynamic(study)
    ]
    head = ["engine", "preset", "position", "velocity", "acceleration", "total", "velocity, rms", "because"]
    return paragraphs(prose.TOLERANCE, table(head, rows))


def _because(run: Result) -> str:
    unsupported = run.outcome == Outcome.UNSUPPORTED.slug
    return run.tolerance.reason or ("unsupported" if unsupported else "not judged")


def printed_table(study: SceneStudy) -> str:
    """The document's printed table against the runs; nothing where there is none."""
    checked = [(r, r.printed) for r in study.results if r.printed is not None]
    if not checked:
        return ""
    first = checked[0][1]
    text = prose.PRINTED.format(**vars(first), others=first.cells - first.exact_agrees)
    rows = [[*name_of(r), f"{p.engine_agrees} of {p.exact_agrees}", numbers.measured(p.worst)] for r, p in checked]
    head = ["engine", "preset", "cells met", "largest distance from a print [last printed units]"]
    return paragraphs("## The printed table", f"{text} {prose.PRINTED_STEPS}", table(head, rows))


def cam(study: SceneStudy) -> str:
    """What is particular to contact; nothing for a linkage."""
    if not has_contact(study):
        return ""
    rows = [
        [*name_of(r), numbers.measured(r.lift_error)]
        + [numbers.measured(r.largest(q, m)) for q, m in (("velocity", "rms"), ("acceleration", "rms"))]
        for r in dynamic(study)
        if r.errors is not None
    ]
    head = ["engine", "preset", "lift error / lift", "velocity error / (ω L), rms", "acceleration error / (ω² L), rms"]
    full, notes = _contact_notes(study.scene)
    return paragraphs("## Contact", full, table(head, rows), *notes)


def _contact_notes(scene: Scene) -> tuple[str, list[str]]:
    """The full lift of a cam, and what explains its table."""
    breaks = ", ".join(numbers.quantity(float(np.degrees(a))) for a in scene.break_angles())
    if not isinstance(scene, CamFollower):
        lift = follower_lift(scene.kinematics)
        full = f"Full lift: {numbers.quantity(1e3 * lift.full)} mm." if lift else ""
        return full, [*prose.CAM[:3], prose.CAM_BREAKS.format(breaks=breaks) if breaks else ""]
    facts = {"preload": numbers.quantity(scene.preload), "force": numbers.quantity(scene.preload_force)}
    told, rms, acceleration, jumps, preload = (text.format(breaks=breaks, **facts) for text in prose.CAM)
    full = f"Full lift: {numbers.quantity(1e3 * scene.full_lift)} mm."
    return full, [told, rms, acceleration, jumps if breaks else prose.ONE_CIRCLE, preload]


def blind_spots(study: SceneStudy) -> str:
    """What the comparison cannot see."""
    first = prose.BLIND_SPOTS_CONTACT if has_contact(study) else prose.BLIND_SPOTS_LINKAGE
    return bullets((first, *prose.blind_spots(study.scene.closed_form)))
