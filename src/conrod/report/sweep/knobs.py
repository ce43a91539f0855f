"""What a sweep turned: every knob of each engine and where it stood."""

from __future__ import annotations

from conrod.report.styles import engine_title
from conrod.report.tables import table
from conrod.studies.sweep_results import SweepStudy

MEANINGS = {
    "integrator": "how a step is made from forces",
    "stabilisation": "time constant with which an open joint is closed: in seconds, steps h or shares of the period T",
    "regularisation": "how far a joint gives way under load: `solimp`, or inverse weights multiplied by a factor",
    "solver": "how the joint forces are solved for",
    "iterations": "passes of that solver, at most",
    "tolerance": "improvement at which the solver stops early",
    "rod": "the connecting rod as a body of its own, or as a distance joint without mass",
    "impedance": "how far a contact gives way under load",
    "vertices": "corners of the cam's polygon, about",
    "error_bias": "share of a joint's error left after a second; 0 mends all of it at each step",
    "slop": "overlap that a contact may keep",
    "bias": "share of a contact's error left after a second; 0 mends all of it at each step",
}


def knobs_table(study: SweepStudy) -> str:
    """Knob, meaning and values, the number of steps among them."""
    rows = []
    for engine in study.engines:
        points = [point for point in study.points if point.engine == engine]
        steps = sorted({point.steps_per_revolution for point in points})
        rows.append([engine_title(engine), "steps per revolution", "length of a step", ", ".join(map(str, steps))])
        for knob in dict.fromkeys(name for point in points for name in point.knobs):
            values = dict.fromkeys(point.knobs[knob] for point in points if knob in point.knobs)
            rows.append([engine_title(engine), f"`{knob}`", MEANINGS.get(knob, ""), ", ".join(values)])
    return table(["engine", "knob", "what it does", "values"], rows)


def size_of_grid(study: SweepStudy) -> str:
    """How many settings and runs, in a sentence."""
    parts = []
    for engine in study.engines:
        points = [point for point in study.points if point.engine == engine]
        completed = sum(point.completed for point in points)
        rules = len({point.rule for point in points})
        parts.append(f"{engine_title(engine)} {rules} settings in {len(points)} runs, of which {completed} completed")
    return f"The grid `{study.grid}`: " + "; ".join(parts) + "."
