"""`conrod validate`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from conrod.cli import options
from conrod.cli.options import RunOptions, as_given, complete_scene, option, refuse
from conrod.errors import InvalidInput
from conrod.own.files import check_readable

MECHANISMS = ".toml"
MODELS = (".xml", ".mjcf", ".mjb")
TABLES = (".csv", ".tsv", ".tab", ".txt", ".dat", ".parquet", ".npz")


@dataclass(frozen=True)
class MotionOptions:
    """A motion that no drive prescribes; None where nothing was given."""

    heading: ClassVar[str] = "Motion without a drive"

    motion: str | None = option(
        "--motion",
        metavar="KIND",
        help="Nothing holds the crank's speed: free, without a torque that drives it, or torque, with its torques.",
    )
    seconds: float | None = option("--seconds", type=float, metavar="S", help="Length of the run [10].")
    step: str | None = option("--step", metavar="TIME", help="Time step of the engines, e.g. 2ms [5 ms or less].")


@dataclass(frozen=True)
class TableOptions:
    """Options on the columns and units of a table of any tool; None or empty where nothing was given."""

    heading: ClassVar[str] = "Of a table (FILE.csv and the like)"

    columns: tuple[str, ...] = option("--column", multiple=True, metavar="Q=NAME", help="Column of a quantity, C.x=px.")
    units: tuple[str, ...] = option(
        "--unit", multiple=True, metavar="UNIT | Q=UNIT", help="Unit that no heading gives."
    )
    estimate: str | None = option(
        "--estimate", metavar="WHAT,...", help="What is unknown and to be estimated: time, phase, sense, frame."
    )


@dataclass(frozen=True)
class ModelOptions:
    """Options on the joints, points and frame of a user's own model; None or empty where nothing was given."""

    heading: ClassVar[str] = "Of a MuJoCo model (FILE.xml and the like)"

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
    length_unit: str | None = option("--length-unit", metavar="UNIT", help="m, cm, mm or inch [found].")
    keyframe: str | None = option("--keyframe", metavar="NAME", help="Assemble it from there [its reference pose].")
    controls: tuple[str, ...] = option("--ctrl")
    touching: str | None = option("--touching", metavar="CAM,ROLLER", help="Geoms of its cam contact [found].")


@dataclass(frozen=True)
class Request(TableOptions, ModelOptions, MotionOptions, RunOptions):
    """Request to `conrod validate`, as typed; None or empty where nothing was given.

    Attributes:
        subjects: scenes, or one file.
        document: the file that --json names.
    """

    subjects: tuple[str, ...] = ()
    scene: str | None = option(
        "--scene", metavar="SCENE", help="Machine that a FILE is judged against.", shell_complete=complete_scene
    )
    engine: str | None = option("--engine")
    preset: str | None = option("--preset")
    quantity: str | None = option("--quantity", metavar="NAME,...", help="Forces instead: torque, reactions, contact.")
    steps_per_rev: int | None = option(
        "--steps-per-rev", type=int, metavar="N", help="Time steps a turn [1000; contact 62832]."
    )
    revolutions: int | None = option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
    assignments: tuple[str, ...] = option("--set")
    figures: str | None = option(
        "--figures",
        metavar="NAME,...",
        help="Figures of the report: mechanism, motion, error, order.",
    )
    tolerance: str | None = option("--tolerance", metavar="Q=T,...", help="Judge by these, e.g. position=1e-4.")
    out: str | None = option("--out")
    document: str | None = option("--json")

    @property
    def given(self) -> dict[str, object]:
        """What was given of all that the result follows from, by the options' names."""
        return as_given(self, RunOptions, "assignments", "out", "document")


@options.verb()
@options.scene_argument("subjects", nargs=-1, metavar="[SCENE | FILE]...")
@options.gathered("asked", Request)
def validate(asked: Request) -> None:
    """Compare engines with the exact motion of SCENEs, or judge a model or table.

    All scenes that have a closed form are compared where none is named. A SCENE is one that `conrod show` lists, or a
    mechanism file of one's own (.toml); the word `catalogue` stands for all machines of the catalogue. Results are kept
    in the ledger: the same command goes on where it stopped, and asked again it runs nothing.

    A FILE is judged instead, against the machine that --scene names: a MuJoCo model (.xml, .mjb), or the trajectory of
    any tool as a table (.csv, .parquet, .npz).

    Exit status 0: all judged results are within tolerance; 1: something is not; 2: bad usage.
    """
    files = [name for name in asked.subjects if name.lower().endswith(MODELS + TABLES)]
    if files:
        _validate_file(files[0], asked)
        return
    _check_endings(asked.subjects, asked.scene)
    refuse(asked, "a scene: it is for a file", ModelOptions, TableOptions)
    if asked.scene is not None:
        name = asked.scene
        raise InvalidInput(f"--scene {name} is for a file; a scene is named as it is: conrod validate {name}")
    if asked.motion is None:
        refuse(asked, "a crank at constant speed: it is for --motion free and --motion torque", MotionOptions)
    else:
        refuse(asked, "--motion: forces are compared at constant crank speed", "quantity")
    from conrod.cli.validate_scenes import validate_scenes

    validate_scenes(asked)


def _validate_file(file: str, asked: Request) -> None:
    """Judge a user's own model or table.

    Raises:
        InvalidInput: also where options were given that are not for it.
    """
    check_readable(Path(file))
    if len(asked.subjects) > 1:
        others = [name for name in asked.subjects if name != file]
        said = f"without {others[0]}" if others else "but it is named twice"
        raise InvalidInput(f"{file}: a file is judged on its own, {said}")
    if asked.scene is None:
        raise InvalidInput(f"{file}: say with --scene what machine it is; `conrod show` lists them")
    refuse(asked, "a file: it is for scenes", MotionOptions, RunOptions, "quantity", "figures")
    from conrod.cli.validate_file import validate_file

    validate_file(Path(file), asked.scene, asked)


def _check_endings(subjects: Sequence[str], scene: str | None) -> None:
    """Refuse a file of no kind that can be judged, which is no scene either."""
    for name in subjects:
        if name.lower().endswith(MECHANISMS):
            continue
        if Path(name).is_file() or (scene is not None and Path(name).suffix):
            raise _unknown_ending(name)


def _unknown_ending(name: str) -> InvalidInput:
    return InvalidInput(
        f"{name}: a file is known by its ending, one of {', '.join(MODELS + TABLES)}; save a sheet as CSV"
    )


def check_file(path: Path) -> None:
    """Refuse what is no file that can be judged; raises InvalidInput, which says why."""
    check_readable(path)
    if not path.name.lower().endswith(MODELS + TABLES):
        raise _unknown_ending(str(path))
