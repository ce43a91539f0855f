"""`python -m docs.studies.detection [--out DIR]`: how small a defect each verdict notices, and how often it is wrong.

Of each machine, engine and judged preset: the smallest size of each kind of defect, by `conrod validate --qualify`; how
tight its tolerances are; and of how many healthy machines with other parameters, speeds, starts and steps it says that
they are out of tolerance. Runs are kept in the ledger: an interrupted study goes on where it stopped.
"""

from __future__ import annotations

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from conrod.comparison.plain_values import json_document, plain_values
from conrod.crash import run_guarded
from conrod.engines import engine_named, engine_names
from conrod.execution.case import Study
from conrod.execution.files import folder_to_write
from conrod.execution.result import Plan, case_results
from conrod.execution.runner import Runner, Runs
from conrod.execution.writing import Batch, write_together
from conrod.report import numbers
from conrod.report.charts.canvas import add_legend_above, drawing_style, set_log_axis, set_rows, svg_text
from conrod.report.charts.styles import preset_style, preset_title
from conrod.report.results import engine_and_preset
from conrod.report.subreports import report_mark
from conrod.report.table import Table, table
from conrod.report.template import table_text
from conrod.scenes import SCENES, Scene, catalogue_names, scene_named
from conrod.studies.validation.results import DefectVerdict, ValidationResult
from docs.studies.defects import DetectionCase
from docs.studies.healthy import VariantCase, variant

# Healthy machines of each of the scenes, of the catalogue, and of those with a cam, whose runs take 100 times as long.
MANY, FEW = 200, 25
CAM_STEPS = 6000  # of machines with a cam, where defects are planted
LOOSE = 10.0  # times the error, of a tolerance that should be sharper


@dataclass(frozen=True)
class Machine:
    """Findings on one machine.

    Attributes:
        healthy: of the same machine with other parameters.
    """

    name: str
    verdicts: tuple[ValidationResult, ...]
    healthy: tuple[ValidationResult, ...]


def detection(scenes: Mapping[str, Scene], share: float) -> Study[list[Machine]]:
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
    return [Machine(name, noticed[name], healthy.get(name, ())) for name in scenes]


def _count(name: str) -> int:
    return MANY if name in SCENES else FEW


def _has_cam(scene: Scene) -> bool:
    return bool(scene.mechanism().cam_contacts)


# -- tables ------------------------------------------------------------------------------------------------------------


def _kinds(machines: Sequence[Machine]) -> dict[tuple[str, str], str]:
    """Defects by verdict and name, with their unit."""
    found: dict[tuple[str, str], str] = {}
    for verdict in (v for machine in machines for v in machine.verdicts):
        for kind, some in _found_of(verdict).items():
            found |= {(kind, one.defect): one.unit for one in some}
    return found


def _found_of(verdict: ValidationResult) -> dict[str, tuple[DefectVerdict, ...]]:
    return {} if verdict.qualified is None else vars(verdict.qualified)


def _tightness(verdict: ValidationResult) -> dict[str, tuple[float, float]]:
    """By judged quantity the error of a run that passed, and what is allowed."""
    if verdict.qualified is None:
        return {}
    return {q: (verdict.judged_error(q) or 0.0, allowed) for q, allowed in verdict.limits.items()}


def _sizes(machines: Sequence[Machine], kind: str, defect: str) -> dict[tuple[str, str], dict[str, Any]]:
    """By engine and preset what is found of a defect, by machine."""
    found: dict[tuple[str, str], dict[str, Any]] = {}
    for machine in machines:
        for verdict in machine.verdicts:
            for one in _found_of(verdict).get(kind, ()):
                if one.defect == defect:
                    found.setdefault((verdict.engine, str(verdict.preset)), {})[machine.name] = one
    return found


def limits_table(machines: Sequence[Machine]) -> Table:
    """A row for each defect: over all machines, the median and the largest of the smallest sizes that are noticed."""
    presets = dict.fromkeys((v.engine, str(v.preset)) for m in machines for v in m.verdicts if v.qualified)
    rows = []
    for (kind, defect), unit in _kinds(machines).items():
        sizes = _sizes(machines, kind, defect)
        cells = []
        for preset in presets:
            found = list(sizes.get(preset, {}).values())
            seen = [one for one in found if one.visible]
            least = [one.smallest for one in seen if one.smallest is not None]
            missed = [one for one in seen if (one.smallest is None if unit else not one.by)]
            text = "cannot be seen" if found and not seen else "not judged" if not found else "noticed"
            if unit and least:
                text = ", ".join(numbers.defect_size_text(size, unit) for size in (float(np.median(least)), max(least)))
            cells.append(text + (f"; not noticed on {len(missed)} of {len(seen)}" if missed else ""))
        rows.append((defect + (" (forces)" if kind == "forces" else ""), *cells))
    return table(["defect", *(preset_title(*preset) for preset in presets)], rows)


def alarms_table(machines: Sequence[Machine]) -> Table:
    """False alarms and tightness of each machine's verdicts."""
    rows = []
    for machine in machines:
        for verdict in machine.verdicts:
            runs = [
                r
                for r in machine.healthy
                if engine_and_preset(r) == engine_and_preset(verdict) and r.passed is not None
            ]
            alarms = sum(r.passed is False for r in runs)
            tight = [_times(*_tightness(verdict)[q]) if q in _tightness(verdict) else "n/a" for q in QUANTITIES]
            judged = f"{alarms} of {len(runs)}" if runs else verdict.reason or "not judged"
            rows.append((machine.name, *engine_and_preset(verdict), judged, *tight))
    head = ["machine", "engine", "preset", "false alarms", *(f"{q}: tolerance / error" for q in QUANTITIES)]
    return table(head, rows, head[3:])


QUANTITIES = ("position", "velocity", "acceleration", "velocity_rms")


def _times(error: float, allowed: float) -> str:
    return numbers.quantity(allowed / error, 3) if error > numbers.ROUNDING else "rounding"


def alarms(machines: Sequence[Machine]) -> list[str]:
    """Each false alarm in words."""
    return [
        f"{m.name}, {r.engine} {r.preset}, {r.steps_per_revolution} steps, speed {r.parameters['speed']:.4g} rad/s: "
        + (
            ", ".join(f"{q} {f / a:.3g} times its tolerance" for q, (f, a) in r.out_of_tolerance().items() if f)
            or r.reason
        )
        for m in machines
        for r in m.healthy
        if r.passed is False
    ]


# -- the report --------------------------------------------------------------------------------------------------------


def figure(machines: Sequence[Machine]) -> Figure:
    """A row for each defect that has a size, a dot for each machine, over the smallest size that is noticed."""
    kinds = {key: unit for key, unit in _kinds(machines).items() if unit}
    drawn = Figure(figsize=(10.5, 0.34 * len(kinds) + 1.2))
    axes = drawn.subplots()
    labels: dict[str, Any] = {}
    for row, key in enumerate(kinds):
        for k, (preset, found) in enumerate(sorted(_sizes(machines, *key).items())):
            least = sorted(one.smallest for one in found.values() if one.smallest is not None)
            style = preset_style(*preset) | {"linestyle": "none", "markersize": 4.0}
            if least:
                (mark,) = axes.plot(least, [row + 0.22 * (k - 1)] * len(least), **style)
                labels.setdefault(preset_title(*preset), mark)
        if not any(one.smallest for found in _sizes(machines, *key).values() for one in found.values()):
            axes.annotate("cannot be seen", (1e-12, row), va="center", color="#777777")
    set_log_axis(axes, (3e-14, 1e4), [10.0**k for k in range(-12, 4, 3)])
    names = [defect + (" (forces)" if kind == "forces" else "") for kind, defect in kinds]
    units = ["-" if unit.startswith("%") else unit for unit in kinds.values()]
    set_rows(axes, [f"{n} [{u}]" for n, u in zip(names, units, strict=True)], 0.6)
    axes.set_xlabel("smallest size noticed, [-] as a fraction of the value itself; a mark is a machine")
    for name, mark in labels.items():
        mark.set_label(name)
    add_legend_above(drawn, [*labels.values()], handlelength=1.5)
    return drawn


def page(machines: Sequence[Machine]) -> str:
    """The page in Markdown."""
    runs = [r for m in machines for r in m.healthy if r.passed is not None]
    wrong = alarms(machines)
    pairs = [
        (m.name, v, q, *_tightness(v)[q])
        for m in machines
        for v in m.verdicts
        for q in QUANTITIES
        if q in _tightness(v)
    ]
    loose = [
        f"{name}, {' '.join(engine_and_preset(v))}: {q} {_times(error, allowed)}"
        for name, v, q, error, allowed in pairs
        if error > numbers.ROUNDING and allowed > LOOSE * error
    ]
    lines = [
        "# Would it notice?", "",
        f"**{len(wrong)} false alarms in {len(runs)} healthy runs; {len(loose)} tolerances of {len(pairs)} are more "
        f"than {LOOSE:g} times what is measured.**", "",
        "![Smallest defects that the verdicts notice](figures/detection.svg)", "",
        f"On {len(machines)} machines, by `make detection`; what is planted and how is in "
        "[detection.md](../../docs/detection.md). [detection.json](detection.json) has all sizes, by machine.", "",
        "## The smallest defect that is noticed", "",
        "Median and largest over the machines, in the place where the verdict sees least, whatever the sign; at 1000 "
        f"steps a turn, with a cam at {CAM_STEPS}.", "",
        table_text(limits_table(machines)), "",
        "## False alarms, and how tight tolerances are", "",
        "Healthy machines: parameters up to 20 % off, the speed up to five times more or less and of either sense, "
        f"100 to 2000 steps a turn, any start; {MANY} of each scene, {FEW} of each of the catalogue. Cams have 2000 "
        "to 6000 steps, no more than their speed, and start at 0. What is below 1e-12 is rounding, and no law is sharp "
        "there.", "",
        table_text(alarms_table(machines)), "",
    ]  # fmt: skip
    for title, points in (("False alarms", wrong), (f"Tolerances of more than {LOOSE:g} times the error", loose)):
        lines += [f"## {title}", "", *(f"- {point}" for point in points or ["none"]), ""]
    return "\n".join(lines)


def main() -> None:
    """Pursue the study, print what it finds, and write the report where it is asked for."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.detection", description=main.__doc__)
    parser.add_argument("scenes", nargs="*", metavar="SCENE", help="[all scenes and the catalogue]")
    parser.add_argument("--healthy", type=float, default=1.0, metavar="SHARE", help="of the healthy machines [1]")
    parser.add_argument("--ledger", metavar="FILE", help="where finished runs are kept [in the cache folder]")
    parser.add_argument("--jobs", type=int, metavar="N", help="runs at a time [one a core]")
    parser.add_argument("--out", metavar="DIR", help="write page, figure and sizes")
    asked = parser.parse_args()
    scenes = {name: SCENES.get(name) or scene_named(name) for name in asked.scenes or [*SCENES, *catalogue_names()]}
    with Runner.open(Runs(ledger=asked.ledger, jobs=asked.jobs)) as runner:
        (machines,) = runner.pursue([detection(scenes, asked.healthy)])
    text = page(machines)
    print(text)
    if asked.out:
        with drawing_style():
            drawn = svg_text(figure(machines))
        sizes = {
            m.name: {" ".join(engine_and_preset(v)): plain_values(v.qualified) for v in m.verdicts} for m in machines
        }
        folder: Path = folder_to_write(asked.out, "--out")
        (folder / "figures").mkdir(parents=True, exist_ok=True)
        files = {"README.md": text, "detection.json": json_document(sizes), "results.json": report_mark("detection")}
        write_together([Batch(folder, files), Batch(folder / "figures", {"detection.svg": drawn})])


if __name__ == "__main__":
    run_guarded(main)
