"""Options of `conrod validate`, by purpose."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any, ClassVar

import click

from conrod.cli.options import RunOptions, as_given, option


@dataclass(frozen=True)
class MotionOptions:
    """A motion that no drive prescribes; None where nothing was given."""

    heading: ClassVar[str] = "Motion without a prescribed crank (--motion)"

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

    heading: ClassVar[str] = "A table that another tool wrote (FILE.csv and the like)"

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

    heading: ClassVar[str] = "A MuJoCo model (FILE.xml and the like)"

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
    touching: str | None = option("--touching", metavar="CAM,ROLLER", help="Geoms of its cam contact [found].")


@dataclass(frozen=True)
class Request(TableOptions, ModelOptions, MotionOptions, RunOptions):
    """Request to `conrod validate`, as typed; None or empty where nothing was given.

    Attributes:
        subjects: scenes, or one file.
        document: the file that --json names.
    """

    heading: ClassVar[str] = "Options"

    subjects: tuple[str, ...] = ()
    scene: str | None = option(
        "--scene", metavar="SCENE", help="What a FILE is to be: the machine it is judged against."
    )
    engine: str | None = option("--engine", metavar="ENGINE", help="One engine only; `conrod show` lists them.")
    preset: str | None = option("--preset", metavar="PRESET", help="One preset only; `conrod show` lists them.")
    quantity: str | None = option(
        "--quantity", metavar="NAME,...", help="Forces in place of motion: torque, reactions, contact."
    )
    steps_per_rev: int | None = option(
        "--steps-per-rev", type=int, metavar="N", help="Time steps a revolution [1000; for contact 62832]."
    )
    revolutions: int | None = option("--revolutions", type=int, metavar="K", help="Turns of the crank [2].")
    assignments: tuple[str, ...] = option(
        "--set", multiple=True, metavar="NAME=VALUE", help="Override a parameter, e.g. --set crank=80mm."
    )
    figures: str | None = option(
        "--figures",
        metavar="NAME,...",
        help="Figures of the report: mechanism, motion, error, order [all; of the catalogue mechanism,error].",
    )
    tolerance: str | None = option(
        "--tolerance", metavar="Q=T,...", help="Judge every preset by these, e.g. position=1e-4,velocity=1e-3."
    )
    out: str | None = option("--out", metavar="DIR", help="Write the report there.")
    document: str | None = option("--json", metavar="FILE", help="Write the results as JSON.")

    @property
    def given(self) -> dict[str, object]:
        """What was given of all that the result follows from, by the options' names."""
        return as_given(self, RunOptions, "assignments", "out", "document")


class HeadedCommand(click.Command):
    """`conrod validate`, whose help has options under the headings of their classes."""

    def format_options(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        kinds: list[Any] = [kind for kind in Request.__mro__ if dataclasses.is_dataclass(kind)]
        home = {one.name: kind.heading for kind in kinds for one in dataclasses.fields(kind)}
        headings: dict[str, list[tuple[str, str]]] = {Request.heading: []}
        for parameter in self.get_params(ctx):
            record = parameter.get_help_record(ctx) if isinstance(parameter, click.Option) else None
            if record is not None:
                headings.setdefault(home.get(str(parameter.name), Request.heading), []).append(record)
        for heading, records in headings.items():
            with formatter.section(heading):
                formatter.write_dl(records)
