"""`python -m docs.studies.detection [--out DIR]`: how small a defect each verdict notices, and how often it is wrong.

Of each machine, engine and judged preset: the smallest size of each kind of defect, by `conrod validate --qualify`; how
tight its tolerances are; and of how many healthy machines with other parameters, speeds, starts and steps it says that
they are out of tolerance. Runs are kept in the ledger: an interrupted study goes on where it stopped.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence

from conrod.crash import run_guarded
from conrod.engines import engine_named, engine_names
from conrod.execution.case import Study
from conrod.execution.files import folder_to_write
from conrod.execution.result import Plan, case_results
from conrod.execution.runner import Runner, Runs
from conrod.execution.writing import write_together
from conrod.report.folder import ReportFolder
from conrod.report.kind import Reproduction
from conrod.report.terminal import print_parts
from conrod.report.writer import report_batch
from conrod.scenes import SCENES, Scene, catalogue_names, scene_named
from conrod.studies.validation.results import ValidationResult
from docs.studies.defects import DetectionCase
from docs.studies.detection_report import DETECTION_REPORT
from docs.studies.detection_results import Detection, FalseAlarm, MachineDetection, PresetDetection
from docs.studies.healthy import VariantCase, variant

# Healthy machines of each of the scenes, of the catalogue, and of those with a cam, whose runs take 100 times as long.
MANY, FEW = 200, 25
CAM_STEPS = 6000  # of machines with a cam, where defects are planted
PART = "detection"


def detection(scenes: Mapping[str, Scene], share: float) -> Study[Detection]:
    """The study: first what is noticed, then what is not to be; `share` of the numbers of healthy machines."""
    judged = [(e, p) for e in map(engine_named, engine_names()) for p, rule in e.presets.items() if rule.judged]
    noticed = yield from case_results(
        DetectionCase(name, scene, engine.name, preset, Plan(CAM_STEPS if _has_cam(scene) else None))
        for name, scene in scenes.items()
        for engine, preset in judged
    )
    passed = {name: [(r.engine, str(r.preset)) for r in found if r.qualified] for name, found in noticed.items()}
    healthy = yield from case_results(
        VariantCase(name, made, engine, preset, Plan(steps, 1.0), start)
        for name, scene in scenes.items()
        for number in range(round(share * _count(name)))
        for made, steps, start in [variant(scene, number)]
        for engine, preset in passed[name]
    )
    return Detection(
        tuple(
            MachineDetection(name, tuple(preset_detection(one, healthy.get(name, ())) for one in noticed[name]))
            for name in scenes
        )
    )


def preset_detection(verdict: ValidationResult, healthy: Sequence[ValidationResult]) -> PresetDetection:
    """Sum up what is found of a preset on a machine.

    Args:
        healthy: runs of the same machine with other parameters, in all presets.
    """
    runs = [
        run
        for run in healthy
        if (run.engine, run.preset) == (verdict.engine, verdict.preset) and run.passed is not None
    ]
    limits = {} if verdict.qualified is None else verdict.limits
    return PresetDetection(
        verdict.engine,
        str(verdict.preset),
        verdict.reason,
        verdict.qualified,
        {name: (verdict.judged_error(name) or 0.0, allowed) for name, allowed in limits.items()},
        len(runs),
        tuple(
            FalseAlarm(run.steps_per_revolution, run.parameters["speed"], run.reason, run.out_of_tolerance())
            for run in runs
            if run.passed is False
        ),
    )


def _count(name: str) -> int:
    return MANY if name in SCENES else FEW


def _has_cam(scene: Scene) -> bool:
    return bool(scene.mechanism().cam_contacts)


def main() -> None:
    """Pursue the study, print what it finds, and write the report where it is asked for."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.detection", description=main.__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="[all scenes and the catalogue]")
    parser.add_argument("--healthy", type=float, default=1.0, metavar="SHARE", help="of the healthy machines [1]")
    parser.add_argument("--ledger", metavar="FILE", help="where finished runs are kept [in the cache folder]")
    parser.add_argument("--jobs", type=int, metavar="N", help="runs at a time [one a core]")
    parser.add_argument("--out", metavar="DIR", help="write page, figure and findings")
    asked = parser.parse_args()
    scenes = {name: SCENES.get(name) or scene_named(name) for name in asked.scenes or [*SCENES, *catalogue_names()]}
    folder = None if asked.out is None else folder_to_write(asked.out, "--out")
    if folder:
        ReportFolder(folder, DETECTION_REPORT).check([PART])
    with Runner.open(Runs(ledger=asked.ledger, jobs=asked.jobs)) as runner:
        (found,) = runner.pursue([detection(scenes, asked.healthy)])
    print_parts(DETECTION_REPORT.printed([found]))
    if folder:
        write_together([report_batch(DETECTION_REPORT, {PART: found}, folder, Reproduction("make detection"))])


if __name__ == "__main__":
    run_guarded(main)
