"""Studies made by hand, with round errors, for reports on them: of a scene, a model, closed loops, and a table."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from conrod.comparison.compare import Size
from conrod.comparison.trajectory import Outcome
from conrod.exact.motion import QUANTITIES
from conrod.exact.space.mobility import Mobility
from conrod.execution.result import SceneResults
from conrod.mjcf.loop_results import LoopRequest, LoopRun, LoopStudy, ShippedRun
from conrod.mjcf.request import ModelFacts, ModelRequest, PointPlace
from conrod.models.check.frame import Frame, PlaneView
from conrod.models.check.identity import Identity
from conrod.models.check.results import JudgedRun, ModelStudy
from conrod.models.tables.columns import Column
from conrod.models.tables.errors import ErrorCurve
from conrod.models.tables.study import TableStudy
from conrod.scenes import Saw
from conrod.studies.validation.results import RefinementPoint, SceneStudy, Tolerance, ValidationResult

# The slider C of this saw travels 0.2 m, and so does everything that a length of C normalises.
SCENE = Saw(crank=0.1, rod=0.3, offset=0.0)
PATH = (25, 50, 100, 200)


def at_order(order: float, limit: float, size: float) -> tuple[float, ...]:
    """Errors at the steps of `PATH`: limit + size (100 / n)^order."""
    return tuple(limit + size * (100.0 / n) ** order for n in PATH)


def refinement(*errors: tuple[float | None, ...]) -> tuple[RefinementPoint, ...]:
    """A run at the steps of `PATH`, by its errors of position, velocity and acceleration."""
    return tuple(
        RefinementPoint(n, "completed", *sizes) for n, sizes in zip(PATH, zip(*errors, strict=True), strict=True)
    )


# Of second order with an error of 1e-6 at a step of zero; of fourth order; and of first order.
SECOND, FOURTH, FIRST = at_order(2.0, 1e-6, 1.6e-4), at_order(4.0, 2e-9, 4e-6), at_order(1.0, 0.0, 4e-5)


def sizes(largest: float) -> dict[str, float]:
    return {"max": largest, "rms": 0.5 * largest, "final": 0.25 * largest}


def validation_result(preset: str | None, **given: object) -> ValidationResult:
    errors = {"position": sizes(1.6e-4), "velocity": sizes(3e-4), "acceleration": sizes(5e-3), "total": sizes(2e-4)}
    known = {
        "scene": "saw",
        "engine": "mujoco",
        "engine_version": "9.1",
        "preset": preset,
        "parameters": {},
        "mode": "dynamic",
        "steps_per_revolution": 100,
        "revolutions": 2.0,
        "errors": {"C": errors},
        "phase": sizes(1e-3),
    }
    return ValidationResult(**(known | given))  # type: ignore[arg-type]


def scene_study(*results: ValidationResult) -> SceneStudy:
    return SceneResults("saw", SCENE, results)


def judged_run(label: str, **given: object) -> JudgedRun:
    sizes_of = {
        "position": Size(3e-4, 1e-4, 0.0),
        "velocity": Size(4e-4, 2e-4, 0.0),
        "acceleration": Size(5e-4, 3e-4, 0.0),
        "total": Size(6e-4, 3e-4, 0.0),
    }
    known = {
        "label": label,
        "outcome": Outcome.COMPLETED,
        "reason": "",
        "steps_per_revolution": 100.2,
        "errors": {"C": sizes_of},
        "phase": 2e-9,
    }
    return JudgedRun(**(known | given))  # type: ignore[arg-type]


def model_study(**given: object) -> ModelStudy:
    """Study of a saw in a user's file, driven with the settings of the file and hardened."""
    place = ((0.0, 0.0, 0.0), (0.2, 0.0))
    view = PlaneView("xy", (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), 1)
    known = {
        "file": "saw.xml",
        "scene_name": "saw",
        "scene": SCENE,
        "question": ModelRequest("crank", (PointPlace("C", "site", "C"),), 1, 0),
        "model": ModelFacts(
            "saw", "9.1", {"hinge": 2, "slide": 1}, {"connect": 1}, 3, 2, None, 1e-3, "timestep 0.001 s"
        ),
        "identity": Identity(Frame(view, 1, 0.0, 0.0, 1.0, *place), False, {"C": 1e-5}, (), 1e-5, 1e-9),
        "tolerance": {"velocity": 1e-3},
        "revolutions": 2.0,
        "runs": {"as it is": judged_run("as it is"), "hardened": judged_run("hardened")},
        "refused": {},
        "points": ("C",),
        "refined": {"hardened": refinement(FOURTH, FIRST, SECOND)},
    }
    return ModelStudy(**(known | given))  # type: ignore[arg-type]


def loop_study(**given: object) -> LoopStudy:
    """Study of a four-bar without a machine to compare with, driven at 100 steps, and tuned at 25 to 200."""
    runs = [
        LoopRun(
            "tuned",
            2.0 / n,
            Outcome.COMPLETED,
            "",
            dict(zip(QUANTITIES, (e, 2.0 * e, 3.0 * e), strict=True)),
            "P",
            1e-5,
        )
        for n, e in zip(PATH, SECOND, strict=True)
    ]
    own = LoopRun(
        "as it is", 0.02, Outcome.COMPLETED, "", {"position": 3e-4, "velocity": 4e-3, "acceleration": 0.05}, "P", 2e-5
    )
    known = {
        "file": "bars.xml",
        "name": "bars",
        "engine_version": "9.1",
        "question": LoopRequest({"crank": "1rad/s"}, tolerance={"position": 1e-3}),
        "seconds": 2.0,
        "travel": 0.3,
        "held": (),
        "mobility": Mobility(3, 2, 2, {}, (), (), 0.25, 0.5),
        "misfit": 0.0,
        "kinematic": {"position": 1e-13},
        "ambiguous": (),
        "unmodelled": (),
        "remarks": ("a remark",),
        "shipped": ShippedRun("its own pose", 2.0, Outcome.COMPLETED, "", 1e-6),
        "runs": (own, runs[2]),
        "steps": (runs[3], runs[0], runs[1]),
        "points": ("P",),
    }
    return LoopStudy(**(known | given))  # type: ignore[arg-type]


def curve(largest: float) -> ErrorCurve:
    return ErrorCurve(Size(largest, 0.5 * largest, 0.25 * largest), np.zeros(1), np.array([largest]))


def table_study(**given: object) -> TableStudy:
    """A table of the saw's slider, judged."""
    known = {
        "file": "t.csv",
        "scene_name": "saw",
        "scene": SCENE,
        "columns": (Column("time", 0, "t", "s", 1.0, "assumed"), Column("C.x", 1, "x [mm]", "mm", 1e-3, "heading")),
        "unused": ("who",),
        "form": "text, separated by commas, decimal points",
        "rows": 7,
        "span": (0.0, 3.0 * SCENE.period),
        "errors": {"C": {"position": curve(2e-3), "total": curve(4e-3)}},
        "phase": math.radians(0.5),
        "estimates": (),
        "tolerance": {"position": 1e-2, "phase": math.radians(1.0)},
        "causes": (),
        "notes": ("a note",),
        "unjudged": (),
    }
    return TableStudy(**(known | given))  # type: ignore[arg-type]


def with_tolerance(result: ValidationResult, reason: str, **limits: float) -> ValidationResult:
    return replace(result, tolerance=Tolerance(**limits, reason=reason))
