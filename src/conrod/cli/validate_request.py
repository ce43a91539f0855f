"""Options of `conrod validate`, by purpose, and the files that it knows by their endings."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from conrod.cli.options import ReportOptions, RunOptions, option

MODELS = (".xml", ".mjcf", ".mjb")
FMUS = (".fmu",)
DEFAULT_REVOLUTIONS = 2  # of a file's own runs
TABLES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".npz")


@dataclass(frozen=True)
class MotionOptions:
    """A motion that no drive prescribes; None where nothing was given."""

    heading: ClassVar[str] = "Motion without a drive"

    motion: str | None = option(
        "--motion",
        metavar="KIND",
        help="Nothing holds the crank's speed: free, without a torque that drives it, or torque, with its torques.",
    )
    seconds: float | None = option(
        "--seconds", type=float, metavar="S", help="Length of the run [10, or 50 fastest turns]."
    )
    step: str | None = option("--step", metavar="TIME", help="Time step of the engines, e.g. 2ms [5 ms or less].")


@dataclass(frozen=True)
class TableOptions:
    """Options on the columns and units of a table of any tool; None or empty where nothing was given."""

    heading: ClassVar[str] = "Of a table (FILE.csv and the like) or an FMU"

    columns: tuple[str, ...] = option(
        "--column", multiple=True, metavar="Q=NAME", help="Column or variable of a quantity, C.x=px."
    )
    units: tuple[str, ...] = option("--unit", multiple=True, metavar="UNIT", help="Unit of what no heading gives one.")
    estimate: str | None = option("--estimate", metavar="WHAT,...", help="What is to be estimated: time, phase.")


@dataclass(frozen=True)
class ModelOptions:
    """Options on the joints, points and frame of a user's own model; None or empty where nothing was given."""

    heading: ClassVar[str] = "Of a MuJoCo model (FILE.xml and the like)"

    drives: tuple[str, ...] = option(
        "--drive",
        multiple=True,
        metavar="JOINT=LAW",
        help="No --scene: law of a driven joint: `60rpm`, `sine:20deg,1Hz`, `move:0deg,90deg,2s`, `table:FILE.csv`.",
    )
    crank: str | None = option("--crank", metavar="JOINT", help="The hinge that is driven.")
    points: tuple[str, ...] = option(
        "--point",
        multiple=True,
        metavar="NAME=site:SITE",
        help="Place of an observed point (site:, body: or geom:); may be given again.",
    )
    plane: str | None = option("--plane", metavar="PLANE", help="Directions right and up, e.g. xz or -xz [found].")
    rotation: str | None = option("--rotation", metavar="ANGLE", help="Of the scene's x axis in the plane [found].")
    crank_zero: str | None = option(
        "--crank-zero", metavar="ANGLE", help="Angle of the hinge at crank angle 0 [found]."
    )
    keyframe: str | None = option("--keyframe", metavar="NAME", help="Assemble it from there [its reference pose].")
    controls: tuple[str, ...] = option("--ctrl")


@dataclass(frozen=True)
class CheckOptions:
    """Options of a regression test, and of checks other than that of an exact motion."""

    heading: ClassVar[str] = "Tests"

    qualify: bool = option("--qualify", is_flag=True, help="Plant known defects too: which are noticed?")
    invariances: bool = option("--invariances", is_flag=True, help="Change what must not matter; it needs no --scene.")
    baseline: str | None = option(
        "--baseline",
        metavar="FILE",
        help="Compare with what FILE has of an earlier run, all run again; written if none.",
    )
    accept: bool = option("--accept", is_flag=True, help="Write the baseline again, as it is now.")


@dataclass(frozen=True)
class VerificationOptions:
    """Options of a verification report; None or empty where nothing was given."""

    heading: ClassVar[str] = "Pages"

    report: str | None = option("--report", metavar="FILE", help="Write a verification report, one HTML file to sign.")
    measured: str | None = option("--measured", metavar="TABLE", help="Measurements of the real machine, as a table.")
    limits: str | None = option("--limits", metavar="DIR", help="Results of `conrod limits`: domain of validity.")
    uncertainties: tuple[str, ...] = option(
        "--uncertainty", multiple=True, metavar="NAME=SIZE", help="Standard one of a length, or of `measured`."
    )


@dataclass(frozen=True)
class Request(VerificationOptions, CheckOptions, TableOptions, ModelOptions, MotionOptions, ReportOptions, RunOptions):
    """Request to `conrod validate`, as typed; None or empty where nothing was given.

    Attributes:
        subjects: scenes, or one file.
    """

    subjects: tuple[str, ...] = ()
    scene: str | None = option("--scene", metavar="SCENE", help="Machine that a FILE is judged against.")
    engine: tuple[str, ...] = option("--engine")
    preset: str | None = option("--preset")
    quantity: str | None = option("--quantity", metavar="NAME,...", help="Forces instead: torque, reactions, contact.")
    steps_per_rev: int | None = option(
        "--steps-per-rev", type=int, metavar="N", help="Time steps a turn [1000; contact 62832]."
    )
    revolutions: int | None = option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
    assignments: tuple[str, ...] = option("--set")
    tolerance: str | None = option("--tolerance", metavar="Q=T,...", help="Judge by these, e.g. position=1e-4.")
