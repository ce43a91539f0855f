"""What `conrod validate` is asked, and what comes of it: something to be judged, whatever its kind."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

from conrod.cli.options import ReportOptions, RunOptions, option

if TYPE_CHECKING:
    from conrod.report.kind import Kind
    from conrod.report.terminal import Part
    from conrod.scenes import Scene

MODELS = (".xml", ".mjcf", ".mjb")
FMUS = (".fmu",)
TABLES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".npz")
DEFAULT_REVOLUTIONS = 2
# Headings of options.
MOTION = "Motion without a drive"
MODEL = "Of a MuJoCo model (FILE.xml and the like)"
TABLE = "Of a table (FILE.csv and the like) or an FMU"
CHECKS = "Tests"
PAGES = "Pages"


@dataclass(frozen=True)
class Request(ReportOptions, RunOptions):
    """Request to `conrod validate`, as typed; None or empty where nothing was given.

    Attributes:
        subjects: scenes, or one file.
        machine: that `scene` is the kind of, where a program gave it.
    """

    motion: str | None = option("--motion", MOTION, metavar="KIND", help="free, or torque: with its driver's torques.")
    seconds: float | None = option("--seconds", MOTION, type=float, metavar="S", help="Length of the run [10].")
    step: str | None = option("--step", MOTION, metavar="TIME", help="Time step of the engines [5 ms or less].")
    drives: tuple[str, ...] = option(
        "--drive", MODEL, multiple=True, metavar="JOINT=LAW", help="No --scene: `60rpm`, `sine:20deg,1Hz`, and others."
    )
    crank: str | None = option("--crank", MODEL, metavar="JOINT", help="The hinge that is driven.")
    points: tuple[str, ...] = option(
        "--point", MODEL, multiple=True, metavar="NAME=site:SITE", help="Place of an observed point, or body: or geom:."
    )
    plane: str | None = option("--plane", MODEL, metavar="PLANE", help="Directions right and up, e.g. -xz [found].")
    rotation: str | None = option("--rotation", MODEL, metavar="ANGLE", help="Of the scene's x axis [found].")
    crank_zero: str | None = option("--crank-zero", MODEL, metavar="ANGLE", help="Hinge at crank angle 0 [found].")
    keyframe: str | None = option("--keyframe", MODEL, metavar="NAME", help="Assemble it from there.")
    controls: tuple[str, ...] = option("--ctrl", MODEL)
    columns: tuple[str, ...] = option("--column", TABLE, multiple=True, metavar="Q=NAME", help="Column of Q, C.x=px.")
    units: tuple[str, ...] = option("--unit", TABLE, multiple=True, metavar="UNIT", help="Where no heading has one.")
    estimate: str | None = option("--estimate", TABLE, metavar="WHAT,...", help="What is to be estimated: time, phase.")
    qualify: bool = option("--qualify", CHECKS, is_flag=True, help="Plant known defects too: which are noticed?")
    invariances: bool = option("--invariances", CHECKS, is_flag=True, help="Change what must not matter; no --scene.")
    baseline: str | None = option("--baseline", CHECKS, metavar="FILE", help="Compare with FILE; written if none.")
    accept: bool = option("--accept", CHECKS, is_flag=True, help="Write the baseline again, as it is now.")
    report: str | None = option("--report", PAGES, metavar="FILE", help="Write a verification report, HTML to sign.")
    measured: str | None = option("--measured", PAGES, metavar="TABLE", help="Measurements of the real machine.")
    limits: str | None = option("--limits", PAGES, metavar="DIR", help="Results of `conrod limits`.")
    uncertainties: tuple[str, ...] = option(
        "--uncertainty", PAGES, multiple=True, metavar="NAME=SIZE", help="Of a length, or of `measured`; standard."
    )
    subjects: tuple[str, ...] = ()
    machine: Scene | None = None
    scene: str | None = option("--scene", metavar="SCENE", help="Machine that a FILE is judged against.")
    engine: tuple[str, ...] = option("--engine")
    preset: str | None = option("--preset")
    quantity: str | None = option("--quantity", metavar="NAME,...", help="Forces instead: torque, reactions, contact.")
    steps_per_rev: int | None = option("--steps-per-rev", type=int, metavar="N", help="Steps a turn [1000; cam 62832].")
    revolutions: int | None = option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
    assignments: tuple[str, ...] = option("--set")
    tolerance: str | None = option("--tolerance", metavar="Q=T,...", help="Judge by these, e.g. position=1e-4.")

    @property
    def turns(self) -> int:
        """Revolutions of the crank."""
        return DEFAULT_REVOLUTIONS if self.revolutions is None else self.revolutions


Judge: TypeAlias = "Callable[[Request, Sequence[Mapping[str, Scene]]], Sequence[Sequence[Any]]]"


@dataclass(frozen=True)
class Judging:
    """Something that is to be judged, which can be: all that the options say of it is understood.

    Attributes:
        kind: of the report.
        typed: scenes as they were typed, or files by the parts of the report.
        parts: of the report.
        judge: findings on each part, for each of some collections of scenes in the place of `scenes`.
        told: findings for the terminal.
        verdict: a finding in words.
        scenes: machines that are judged, or that a file is judged against, by name.
        inputs: files that are read, by what a user calls them.
    """

    kind: Kind[Any]
    typed: Sequence[str] | Mapping[str, str]
    parts: Sequence[str]
    judge: Judge
    told: Callable[[Sequence[Any]], Iterable[Part]]
    verdict: Callable[[Any], str]
    scenes: Mapping[str, Scene] = field(default_factory=dict)
    inputs: Mapping[str, Path] = field(default_factory=dict)
