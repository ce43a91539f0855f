"""Studies of limits made by hand."""

from __future__ import annotations

import math
from dataclasses import replace

from limit_walks import (
    SCENE,
    iterated_walks,
    mass_walks,
    nearness_walks,
    pose_walks,
    refused,
    regularisation_walks,
    steps_walks,
)

from conrod.scenes import SCENES
from conrod.studies.limits.determinism import RUNS, Determinism
from conrod.studies.limits.exact_flight import ExactFlight
from conrod.studies.limits.follower_float import ComparedFlight, FollowerFloat, GapCurve, OnsetProbe
from conrod.studies.limits.maps import LimitMap, MapRun
from conrod.studies.limits.records import Flight, Mark
from conrod.studies.limits.results import IterationNeed, LimitStudy, LongRun


def long_run(engine: str, preset: str, growth: float = 0.0, revolutions: float = 1000.0) -> LongRun:
    """A long run whose phase drifts in proportion to its length, and whose loop error grows by a power of it."""
    counts = [m * 10**k for k in range(7) for m in (1, 2, 5) if m * 10**k <= revolutions]
    marks = tuple(Mark(n, 1e-6 * n**growth, 2e-6 * n**growth, 1e-12 * n, 3e-14 * n**1.5) for n in counts)
    return LongRun(SCENE, engine, preset, 1000, revolutions, "completed", "", marks)


def same_again(engine: str, preset: str, across: bool = True) -> Determinism:
    """Four runs of one case; the one in another process differs where that is asked for."""
    first = f"{engine}-{preset}".encode().hex().ljust(64, "0")
    prints = dict.fromkeys(RUNS, first) | ({} if across else {RUNS[-1]: "f" * 64})
    return Determinism(SCENE, engine, preset, "completed", "", prints)


def small_map(engine: str, preset: str) -> LimitMap:
    """A map of three by three nodes, five of which were run."""
    runs = (
        MapRun(0, 0, "safe", "completed", False, 1e-3),
        MapRun(0, 2, "wrong", "completed", True, 0.5),
        MapRun(1, 1, "broken", "opened", True, None),
        MapRun(2, 0, "unbounded", "diverged", False, None),
        MapRun(2, 2, "unbounded", "diverged", False, None),
    )
    x, y = (1000.0, 100.0, 10.0), (1e-6, 1.0, 1e6)
    return LimitMap(SCENE, engine, preset, "steps", "mass-ratio", x, y, runs)


def follower(engine: str, preset: str) -> FollowerFloat:
    """A follower that flies a hair before the theory says, and lands a twentieth of a degree late."""
    exact = ExactFlight(1.2345678901, 1.4345678901, 1.0e-3, 1.35)
    measured = Flight(1.2350000001, exact.landing + math.radians(0.05), 1.01e-3)
    heights = (1e-3 * max(-0.01, math.sin(0.3 * k)) for k in range(40))
    gaps = tuple((1.2 + 0.01 * k, gap, gap - 1e-6, gap + 1e-6) for k, gap in enumerate(heights))
    return FollowerFloat(
        scene="cam-follower",
        engine=engine,
        preset=preset,
        refusal="",
        theory=37.123,
        steps_per_revolution=(20000, 40000),
        cam_vertices=(4000, 8000),
        penetration=1e-6,
        held=0.998,
        flown=0.9995,
        visible=1.004,
        from_length=1.001,
        probes=(OnsetProbe(0.998, (0.01, 0.005), 0.0), OnsetProbe(0.9995, (0.02, 0.02), 0.0)),
        flights=(ComparedFlight(1.05, 20000, "completed", exact, measured),),
        curve=GapCurve(1.5, 20000, gaps, ((1.23, 0.0), (1.33, 1e-3), (1.43, 0.0)), 1e-6, 1e-5),
        exact_lengths=((1.0, 0.0), (1.05, 0.2)),
    )


def limit_study(name: str = SCENE) -> LimitStudy:
    """A study with all of its parts but a follower."""
    scene = SCENES[name]
    study = LimitStudy(
        name=name,
        kind=type(scene).kind,
        title=type(scene).title,
        parameters=scene.parameters,
        engines={"mujoco": "4.0.0", "pymunk": "7.3.1"},
        walks=(
            *steps_walks(),
            *mass_walks(),
            *nearness_walks(),
            *regularisation_walks(),
            *pose_walks(),
            *(refused("float", "mujoco", p, "the saw has no follower") for p in ("stock", "tuned")),
        ),
        long_runs=(long_run("mujoco", "tuned"), long_run("pymunk", "tuned", growth=0.2)),
        maps=(small_map("mujoco", "stock"),),
        needs=tuple(IterationNeed(SCENE, "pymunk", "tuned", n, iterated_walks(0.3 * n)) for n in (10, 100)),
        determinism=(same_again("mujoco", "stock"), same_again("pymunk", "stock", across=False)),
        floats=(),
    )
    return study if name == SCENE else renamed(study, name)


def renamed(study: LimitStudy, name: str) -> LimitStudy:
    """The same of another scene."""
    parts = {
        part: tuple(replace(one, scene=name) for one in getattr(study, part))
        for part in ("walks", "long_runs", "maps", "needs", "determinism", "floats")
    }
    return replace(study, name=name, **parts)  # type: ignore[arg-type]  # each is a tuple of what it was


def of_axis(study: LimitStudy, axis: str) -> LimitStudy:
    """What asking for one axis alone would have given."""
    walks = tuple(walk for walk in study.walks if walk.axis == axis)
    return replace(study, walks=walks, long_runs=(), maps=(), needs=(), determinism=(), floats=())
