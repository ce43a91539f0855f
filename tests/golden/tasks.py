"""Commands whose results are golden, by group."""

from __future__ import annotations

from dataclasses import dataclass

SCENES = ("shear-press", "saw-40rpm", "saw-500rpm", "cam-follower")
CATALOGUE = (
    "cam-3-4-5", "cam-4-5-6-7", "cam-cycloidal", "cam-simple-harmonic", "crank-shaper", "double-rocker", "geneva",
    "inverted-slider-crank", "jansen-leg", "one-cylinder-engine", "parallelogram", "peaucellier", "planetary-gear",
    "rack-and-wheel", "rolling-on-concave", "rolling-on-convex", "rolling-on-flat", "six-bar", "slider-crank",
    "swinging-four-bar", "two-slider-linkage", "watt-straight-line", "web-cutter", "whitworth",
)  # fmt: skip
DYNAMICS = (
    "cam-spring-fast", "cam-spring-slow", "four-bar-swing", "pendulum", "press-cutting", "press-cutting-flywheel",
    "saw-coasting", "six-bar-swing", "slider-crank-spring",
)  # fmt: skip
# The longer ones take longer and show nothing else, except their exact motion.
CHAINS = ("four-bar-chain-2", "four-bar-chain-10", "four-bar-chain-40")
ANGLES = 100  # in a turn of the crank
ALL_FORCES = "torque,reactions,contact"
# Scene, kind of motion, how long [s]. A cam's contact takes small steps. Some are refused: that, too, is a result.
MOTIONS = (
    ("cam-spring-slow", "free", 1),
    ("saw-coasting", "free", 2),
    ("press-cutting", "torque", 2),
    ("press-cutting-flywheel", "torque", 2),
    ("press-cutting-flywheel", "free", 2),
    ("four-bar-chain-10", "free", 2),
    ("six-bar-swing", "free", 2),
    ("cam-spring-fast", "free", 1),
    ("four-bar-chain-2", "free", 2),
    ("slider-crank-spring", "free", 2),
    ("press-cutting", "free", 2),
    ("four-bar-swing", "free", 2),
    ("pendulum", "free", 2),
    ("pendulum", "torque", 2),
)
SWEEP = ("sweep", "shear-press", "--grid", "coarse")
STEPS_AXIS = ("limits", "saw-500rpm", "--axis", "steps")
# What a kept ledger answers without a new run, and where each command's JSON goes.
FROM_LEDGER = (SWEEP, STEPS_AXIS)
# The fewest that there may be: what something costs is not golden.
ABLATE = ("ablate", "shear-press", "--rounds", "2")


@dataclass(frozen=True)
class Task:
    """One command and the file that it writes; its records stand under its name.

    Attributes:
        arguments: of conrod, without the file; none of the task that asks the kept ledger.
        output: name of the file, and the option that it is given to.
    """

    group: str
    name: str
    arguments: tuple[str, ...]
    output: tuple[str, str] = ("--json", "results.json")


def all_tasks() -> list[Task]:
    """All of them, those that take longest first: the last ones to run then fill both cores."""
    return [
        Task("catalogue", "validate-catalogue", ("validate", "catalogue", "--jobs", "1")),
        *(_forces(scene) for scene in ("cam-spring-slow", "cam-spring-fast")),
        Task("ablate", "shear-press", (*ABLATE, "--jobs", "1")),
        Task("sweep", "shear-press-coarse", (*SWEEP, "--jobs", "1")),
        *(Task("scenes", scene, ("validate", scene, "--jobs", "1")) for scene in reversed(SCENES)),
        *(_determinism(scene) for scene in ("cam-follower", "saw-500rpm", "shear-press")),
        Task("limits", "saw-500rpm-steps", (*STEPS_AXIS, "--jobs", "1")),
        *(_motion(*motion) for motion in MOTIONS),
        Task("ledger", "no-new-run", ()),
        *(_forces(scene) for scene in (*DYNAMICS[2:], CHAINS[0])),
        *(_exact(machine) for machine in (*SCENES, *CATALOGUE, *DYNAMICS, *CHAINS)),
        *(Task("mjcf", scene, ("export", scene, "--format", "mjcf"), ("-o", f"{scene}.xml")) for scene in SCENES),
    ]


def _forces(scene: str) -> Task:
    return Task("forces", scene, ("forces", scene, "--quantity", ALL_FORCES, "--jobs", "1"))


def _motion(scene: str, kind: str, seconds: int) -> Task:
    torque = ("--torque",) if kind == "torque" else ()
    return Task("motion", f"{scene}-{kind}", ("free", scene, *torque, "--seconds", str(seconds), "--jobs", "1"))


def _determinism(scene: str) -> Task:
    return Task("determinism", scene, ("limits", scene, "--axis", "determinism", "--jobs", "1"))


def _exact(machine: str) -> Task:
    asked = ("export", machine, "--format", "csv", "--steps-per-rev", str(ANGLES))
    return Task("exact", machine, asked, ("-o", "motion.csv"))
