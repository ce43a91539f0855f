"""`python -m docs.studies.own_models MODELS [--out DIR]`: closed loops of robots from public collections.

MODELS holds a folder for each repository of `SOURCES`, fetched by whoever runs it. Each robot is judged as by
`conrod check MODEL --drive ...`, and its mobility is compared with a count by hand. Nothing of a model is written
but what was measured on it.
"""

from __future__ import annotations

import argparse
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from conrod.comparison.trajectory import Outcome
from conrod.crash import run_guarded
from conrod.errors import InvalidInput
from conrod.execution.files import folder_to_write
from conrod.execution.writing import write_together
from conrod.mjcf.loop_results import LoopRequest, LoopStudy
from conrod.models.engine_comparison.api import check_loops_in_engines
from conrod.models.loops.api import check_model_loops
from conrod.models.loops.report import LOOPS_REPORT
from conrod.models.loops.words import shipped_words
from conrod.report.kind import SCENE, Reproduction
from conrod.report.numbers import measured_text, quantity
from conrod.report.table import Table, table
from conrod.report.template import table_text
from conrod.report.writer import report_batch
from conrod.studies.space.report import SPACE_REPORT
from conrod.studies.space.results import SpatialStudy

MENAGERIE = "google-deepmind/mujoco_menagerie"
# Repositories with the commit that the page was made of.
SOURCES = {
    MENAGERIE: "75df466bb0e39d8d7fa66b556513cfc676919924",
    "jeh15/digit_assets": "b5d04f2a89b95b4d779371efc50ee5d652be6399",
    "thomasvilly/dobot_mujoco": "b325a81c306fe2c1e9c68b28431fdd937c195e2d",
    "jurmy24/delta-simulation": "0f8b393e35cb0753122d8c5a999ad8a1087bdc06",
    "Rhoban/onshape-to-robot-examples": "a0f8b921b5e67ba31feac31c74ff6005c9043513",
    "yummypenguin/Unilab0731_ver-mujoco_menagerie": "9fa1cca140ebe958f77d28cbf28e708abf317a82",
}
INTRODUCTION = f"""\
How far their loops open in MuJoCo at each file's own step, driven along the exact motion, with its own settings and
with conrod's presets, and what a step costs over its own. `make own-models MODELS=DIR` makes this page; DIR has a clone
of each repository below, in a folder of its name. No part of a model is here.
[{LOOPS_REPORT.index_file}]({LOOPS_REPORT.index_file}) has the positions;
a page of each robot its redundant equations and what touches on the way.
[{SPACE_REPORT.index_file}]({SPACE_REPORT.index_file}) has six of them in other engines, too.
"""
HEADER = ("model", "mobility", "redundant", "step [ms]", "its own", "tuned", "hardened", "cost", "the file as it is")


@dataclass(frozen=True)
class Robot:
    """A model with what drives it.

    Attributes:
        path: in its repository.
        drives: by joint; `hold` where a joint only keeps the rest in place.
        mobility: degrees of freedom that its closures leave to the joints of its loops, counted by hand.
        counted: how that was counted.
        note: what was found, beside the numbers.
        corrected: text of the file that stands in its way, and what a copy has in its place.
    """

    repository: str
    path: str
    drives: Mapping[str, str]
    mobility: int
    counted: str
    note: str = ""
    keyframe: str | None = None
    corrected: Mapping[str, str] = field(default_factory=dict)

    def file(self, models: Path) -> Path:
        """Where it is in a folder of repositories."""
        return models / self.repository.partition("/")[2] / self.path


def _held(*joints: str) -> dict[str, str]:
    return dict.fromkeys(joints, "hold")


ROBOTS = {
    "cassie": Robot(
        MENAGERIE, "agility_cassie/cassie.xml",
        {"left-knee": "sine:10deg,1Hz", "left-foot-crank": "sine:20deg,2Hz"}
        | _held("left-shin", "left-heel-spring", "right-shin", "right-heel-spring", "right-knee", "right-foot-crank"),
        10,
        "a leg has ten rates in its loops; the Achilles rod's connect takes three of them, the plantar rod's, which is "
        "planar, two; knee, foot crank, two springs and the rod's spin are left",
        "Its keyframe itself stands open by 1.9 mm.",
        keyframe="home",
    ),
    "digit": Robot(
        "jeh15/digit_assets", "digit-v3.xml",
        {"left-knee": "sine:5deg,4Hz", "left-toe-A": "sine:5deg,8Hz", "left-toe-B": "sine:3deg,4Hz"}
        | _held("left-shin", "left-heel-spring", "right-shin", "right-heel-spring", "right-knee", "right-toe-A")
        | _held("right-toe-B"),
        16,
        "a leg has 17 rates in its loops, and three rods with a ball at each end take three each; knee, two toe "
        "motors, two springs and the spins of three rods are left",
        "Its reference pose is sunk in the ground: it was lifted by 1.5 m. RK4 of the presets, which is explicit, does "
        "not bear the damping of its light rods' balls at 0.5 ms; without that hardened is within 1.8e-8 mm.",
        corrected={"name='base' pos='0 0 0'": "name='base' pos='0 0 1.5'", "toe-A-rod.stl": "toe-a-rod.stl"}
        | {"toe-B-rod.stl": "toe-b-rod.stl", "arm-L": "arm-l"},
    ),
    "2f85": Robot(
        MENAGERIE, "robotiq_2f85/2f85.xml",
        {"right_driver_joint": "move:0,0.7rad,1s"}
        | dict.fromkeys(("right_spring_link_joint", "left_spring_link_joint"), "move:0,0.7rad,1s"),
        3,
        "eight hinges; two planar connects take two each, the coupling one: drive and the two spring links are left",
        "With both spring links going as the drive goes, its couplers pass their limit by 0.07 deg; without limits "
        "hardened is within 6.1e-10 mm, but hardening hardens limits too.",
    ),
    "2f85-v4": Robot(
        MENAGERIE, "robotiq_2f85_v4/2f85.xml", {"right_driver_joint": "move:0,0.7rad,1s"}, 1,
        "six hinges; two planar connects take two each, the coupling one",
    ),
    "xarm7": Robot(
        MENAGERIE, "ufactory_xarm7/xarm7.xml", {"left_driver_joint": "move:0,0.8rad,1s"}, 1,
        "six hinges in its hand, as in the 2F-85 v4; the arm's joints are in no loop", keyframe="home",
    ),
    "dobot": Robot(
        "thomasvilly/dobot_mujoco", "dobot_mujoco/env/assets/dobot_suction_cup.xml",
        {"motor2": "move:0,40deg,1s", "motor3": "move:0,30deg,1s"}, 2,
        "eight hinges; three planar connects take two each: a palletiser's two parallelograms",
        "Links that touch press its loops open; without contacts hardened is within 1.5e-9 mm, but hardening hardens "
        "contacts too.",
    ),
    "delta": Robot(
        "jurmy24/delta-simulation", "simulation/delta-robot/robot.xml",
        {"shoulder_1": "sine:10deg,1Hz", "shoulder_2": "sine:10deg,2Hz", "shoulder_3": "sine:5deg,1Hz"}, 9,
        "24 rates in its loops, five connects take three each; three shoulders and the spins of six rods are left",
    ),
    "stewart": Robot(
        "yummypenguin/Unilab0731_ver-mujoco_menagerie", "src/unilab/assets/robots/stewart/scene.xml",
        {"slide00": "move:0mm,50mm,1s", "slide10": "move:0mm,30mm,1s", "slide01": "move:0mm,60mm,1s"}
        | {"slide11": "move:0mm,40mm,1s", "slide02": "move:0mm,20mm,1s", "slide12": "move:0mm,50mm,1s"}, 6,
        "six legs of three rates and the platform's six, six connects take three each",
    ),
    "five-bar": Robot(
        "Rhoban/onshape-to-robot-examples", "planar-2dof/robot.xml",
        {"motor1": "sine:10deg,1Hz", "motor2": "sine:10deg,2Hz"}, 2, "four hinges; the planar connect takes two",
        "Links touch the base; without contacts hardened is within 1.0e-4 mm.",
    ),
    "toddlerbot": Robot(
        MENAGERIE, "toddlerbot_2xc/scene.xml",
        {"neck_yaw_drive": "sine:20deg,1Hz", "neck_pitch_act": "sine:10deg,2Hz"}
        | _held("left_hip_yaw_drive", "right_hip_yaw_drive", "left_shoulder_yaw_drive", "left_elbow_yaw_drive")
        | _held("left_wrist_pitch_drive", "right_shoulder_yaw_drive", "right_elbow_yaw_drive")
        | _held("right_wrist_pitch_drive"), 10,
        "nine pairs of gears leave one each, the neck's two parallelograms of four hinges leave one", keyframe="home",
    ),
    "panda": Robot(
        MENAGERIE, "franka_emika_panda/panda.xml", {"finger_joint1": "move:0mm,30mm,1s"}, 1, "two slides, coupled",
        keyframe="home",
    ),
}  # fmt: skip


def main() -> None:
    """Judge the robots and write the pages."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.own_models", description=__doc__)
    parser.add_argument("models", type=Path, help="folder with a clone of each repository")
    parser.add_argument("--out", default="reports/own-models", help="folder of the pages")
    parser.add_argument("--only", nargs="+", choices=ROBOTS, default=list(ROBOTS), help="these robots alone")
    parser.add_argument("--engines", action="store_true", help="compare engines on them, and write nothing else")
    asked = parser.parse_args()
    folder = folder_to_write(asked.out, "--out")
    if asked.engines:
        compared = {name: _compared(asked.models, name) for name in asked.only}
        again = Reproduction(f"python -m docs.studies.own_models DIR --engines --only {SCENE}")
        write_together([report_batch(SPACE_REPORT, compared, folder, again)])
        return
    found = {name: _judged(asked.models, name) for name in asked.only}
    studies = {name: one for name, one in found.items() if isinstance(one, LoopStudy)}
    pages = report_batch(LOOPS_REPORT, studies, folder, Reproduction(f"make own-models MODELS=DIR ROBOTS={SCENE}"))
    write_together([replace(pages, files={**pages.files, "README.md": page(found)})])


def _judged(models: Path, name: str) -> LoopStudy | str:
    robot = ROBOTS[name]
    file = robot.file(models)
    try:
        with tempfile.TemporaryDirectory() as folder:
            if robot.corrected:
                file = _corrected(file, robot.corrected, Path(folder))
            found = check_model_loops(file, LoopRequest(robot.drives, robot.keyframe), name)
    except InvalidInput as error:
        return str(error)
    print(f"{name}: {found.driven_run.outcome.slug}, mobility {found.mobility.remaining_dof}", flush=True)
    return replace(found, file=robot.path)


def _compared(models: Path, name: str) -> SpatialStudy:
    """Compare engines on a robot, at its file's own step and at half as many steps."""
    robot = ROBOTS[name]
    with tempfile.TemporaryDirectory() as folder:
        file = _corrected(robot.file(models), robot.corrected, Path(folder), f"{name}.xml")
        found = check_loops_in_engines(file, drives=robot.drives, keyframe=robot.keyframe).study
    print(f"{name}: {[one.outcome for one in found.results]}", flush=True)
    return replace(found, file=robot.path, title=f"{robot.repository}, {robot.path}")


def _corrected(file: Path, changes: Mapping[str, str], folder: Path, name: str = "") -> Path:
    """A copy of a model with other text, and a name if one is given, beside links to all that it may include."""
    for one in file.parent.iterdir():
        (folder / one.name).symlink_to(one.resolve())
    text, made = file.read_text(encoding="utf-8"), folder / (name or file.name)
    for old, new in changes.items():
        text = text.replace(old, new)
    made.unlink(missing_ok=True)
    made.write_text(text, encoding="utf-8")
    return made


def page(found: Mapping[str, LoopStudy | str]) -> str:
    """The first page: a row for each robot, how its mobility was counted by hand, and what was found."""
    studies = {name: one for name, one in found.items() if isinstance(one, LoopStudy)}
    right = sum(study.mobility.remaining_dof == ROBOTS[name].mobility for name, study in studies.items())
    lines = [
        "# Closed loops of robots\n",
        f"**{len(studies)} of {len(found)} models are judged by their own exact motion; the mobility of {right} is "
        "that counted by hand.**\n",
        INTRODUCTION,
        table_text(_rows(studies)),
        "\n## What was found\n",
        *(f"- {name}: {_said(ROBOTS[name], one)}" for name, one in found.items()),
        "\n## Sources\n",
        *(f"- [{name}](https://github.com/{name}) at {commit[:10]}" for name, commit in SOURCES.items()),
    ]  # fmt: skip
    return "\n".join(lines) + "\n"


def _rows(studies: Mapping[str, LoopStudy]) -> Table:
    rows = []
    for name, study in studies.items():
        gaps = [
            measured_text(1e3 * (r.gap or 0.0)) if r.outcome is Outcome.COMPLETED else r.outcome.slug
            for r in study.runs
        ]
        shipped = "oscillates" if study.shipped.chatter else study.shipped.outcome.slug
        costs = ", ".join(
            measured_text(run.cost) if run.outcome is Outcome.COMPLETED else "-" for run in study.runs[1:]
        )
        step = quantity(1e3 * study.driven_run.timestep)
        left, redundant = str(study.mobility.remaining_dof), str(sum(study.mobility.redundant.values()))
        rows.append((f"[{name}]({name}{LOOPS_REPORT.suffix}.md)", left, redundant, step, *gaps, costs, shipped))
    return table(HEADER, rows, HEADER[1:-1], "loops open [mm]; cost of tuned, hardened")


def _said(robot: Robot, found: LoopStudy | str) -> str:
    if isinstance(found, str):
        return found.partition(": ")[2]
    counted = "" if found.mobility.remaining_dof == robot.mobility else f"; NOT the {robot.mobility} COUNTED"
    note = f" {robot.note}" if robot.note else ""
    runs = {"as it is": found.shipped, **found.presets}
    ran = "; ".join(f"{label}, it {shipped_words(run)}" for label, run in runs.items())
    return f"mobility {found.mobility.remaining_dof}{counted}: {robot.counted}.{note} With its own actuators, {ran}."


if __name__ == "__main__":
    run_guarded(main)
