"""All cams of document 004 in each engine: errors against the exact motion, and what the engine's follower does.

An engine collides a polygon with the roller: at each corner the follower's velocity jumps into a short spike. So its
velocity and acceleration are taken from its lift h at crank angles t, over a few corners:
v(t) = (h(t + d) - h(t - d)) w / 2d and a(t) = (v(t + d) - v(t - d)) w / 2d, with d = 1 deg. The exact motion is treated
alike where both are compared.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from audits.cam_survey import cams
from audits.documents.arc_cam import MM, ArcCam
from conrod import Runs, family, validate
from conrod.comparison.trajectory import Outcome
from conrod.engines import Engine, engine_named
from conrod.engines.run import run
from conrod.exact.motion import Array
from conrod.execution.resolve_arguments import select_engines
from conrod.scenes import CamFollower, Scene
from conrod.studies.validation.results import SceneStudy

PRESET, STEPS, REVOLUTIONS = "tuned", 12_566, 2  # 2000 steps per radian
HALF_SPAN = np.radians(1.0)  # d, half the span of the crank angle over which a mean rate is taken
FINE_DEGREES = np.arange(180.0, 540.0, 0.25)  # a whole turn in the middle of the run
MARK_STEP = 10.0  # [deg], the document's own
EXACT, EXACT_MEAN = "exact", "exact mean"


@dataclass(frozen=True)
class CamRun:
    """One cam in all engines.

    Attributes:
        base, flank: R and rho [mm].
        errors: largest position error over the lift by engine; None unless the run completed.
        passed: the verdict by engine.
        peaks: largest velocity and acceleration in size [mm/s, mm/s²] (2,) by engine; of the exact motion as it is
            ("exact"), and over the same spans as of the engines ("exact mean").
        marks: lift, velocity and acceleration (3, 36) [mm, mm/s, mm/s²] by engine, at `mark_degrees`.
    """

    base: float
    flank: float
    errors: Mapping[str, float | None]
    passed: Mapping[str, bool | None]
    peaks: Mapping[str, Array]
    marks: Mapping[str, Array]


@dataclass(frozen=True)
class CamFamily:
    """All cams that document 004 studies, in some engines.

    Attributes:
        engines: version by name of the engine.
        steps: steps per revolution.
    """

    engines: Mapping[str, str]
    steps: int
    cams: tuple[CamRun, ...]

    @property
    def passed(self) -> bool:
        """True if every cam is within tolerance in every engine."""
        return all(passed is not False for cam in self.cams for passed in cam.passed.values())


def mark_degrees(engine: str) -> Array:
    """Crank angles (36,) [deg] of an engine's marks; those of the second engine lie between those of the first."""
    first = MARK_STEP / 2.0 * (engine != "mujoco")
    return np.arange(first, 360.0, MARK_STEP)


def _in_the_middle(degrees: Array) -> Array:
    """The same angles of the cam in the middle turn of the run, whose ends are as far away as they can be."""
    return np.where(degrees < 180.0, degrees + 360.0, degrees)


def families(chosen: tuple[ArcCam, ...]) -> dict[str, Scene]:
    """Cams as scenes by name: a family for each base circle, which has flanks of its own."""
    found = dict[str, Scene]()
    for base in dict.fromkeys(cam.base for cam in chosen):
        flanks = [f"{cam.flank:g} mm" for cam in chosen if cam.base == base]
        found |= family("cam-follower", base_radius=[f"{base:g} mm"], flank_radius=flanks)
    return found


def study_cams(chosen: tuple[ArcCam, ...] | None = None, steps: int = STEPS, runs: Runs | None = None) -> CamFamily:
    """Validate cams, all of the document by default, and follow the rollers of the engines."""
    engines = select_engines([])
    found = validate(families(chosen or cams()), preset=PRESET, steps_per_rev=steps, runs=runs)
    return CamFamily(
        {engine.name: engine.version for engine in engines},
        steps,
        tuple(cam_run(study, engines, steps) for study in found.values()),
    )


def cam_run(study: SceneStudy, engines: list[Engine[Any]], steps: int) -> CamRun:
    """Findings on one cam: its errors, and the motion of the follower in each engine."""
    cam = study.scene
    assert isinstance(cam, CamFollower)
    results = {result.engine: result for result in study.results if result.preset == PRESET}
    lifts = {engine.name: engine_lift(cam, engine.name, steps) for engine in engines}
    fine = {EXACT_MEAN: mean_motion(exact_lift(cam), FINE_DEGREES)}
    fine |= {name: mean_motion(lift, FINE_DEGREES) for name, lift in lifts.items() if lift}
    return CamRun(
        base=round(cam.base_radius / MM, 6),
        flank=round(cam.flank_radius / MM, 6),
        errors={name: result.largest("position") for name, result in results.items()},
        passed={name: _judged(study, name) for name in results},
        peaks={EXACT: np.abs(ArcCam(cam.base_radius / MM, cam.flank_radius / MM).rise()[1][1:3]).max(axis=1)}
        | {name: np.abs(motion[1:]).max(axis=1) for name, motion in fine.items()},
        marks={name: mean_motion(lift, _in_the_middle(mark_degrees(name))) for name, lift in lifts.items() if lift},
    )


def _judged(study: SceneStudy, engine: str) -> bool | None:
    """True if the model in kinematic mode and the run are within tolerance; None if neither was judged."""
    verdicts = [result.passed for result in study.results if result.engine == engine]
    return False if False in verdicts else True if True in verdicts else None


Lift = Callable[[Array], Array]  # lift [mm] at crank angles [rad]


def exact_lift(cam: CamFollower) -> Lift:
    """Lift of the exact motion."""
    low = cam.base_radius + cam.roller_radius
    return lambda angle: (cam.motion(angle, cam.speed).point("roller").position[:, 1] - low) / MM


def engine_lift(cam: CamFollower, engine: str, steps: int) -> Lift | None:
    """Lift in a run of an engine, between its samples by straight lines; None unless the run completed."""
    settings = engine_named(engine).presets[PRESET](cam, steps)
    trajectory = run(cam, settings, REVOLUTIONS)
    if trajectory.outcome is not Outcome.COMPLETED:
        return None
    track, low = trajectory.points["roller"].position, cam.base_radius + cam.roller_radius
    angles, lifts = track.instants.angle, (track.values[:, 1] - low) / MM
    return lambda angle: np.interp(angle, angles, lifts)


def mean_motion(lift: Lift, degrees: Array) -> Array:
    """Lift, velocity and acceleration (3, T) [mm, mm/s, mm/s²] at 1 rad/s, as the module's first lines say."""
    angle, d = np.radians(degrees), HALF_SPAN
    middle = lift(angle)
    velocity = (lift(angle + d) - lift(angle - d)) / (2.0 * d)
    acceleration = (lift(angle + 2.0 * d) - 2.0 * middle + lift(angle - 2.0 * d)) / (2.0 * d) ** 2
    return np.array([middle, velocity, acceleration])
