"""The report of `make detection`: tables, figure and sentences on what verdicts notice."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from conrod.engines import engine_style
from conrod.report import numbers
from conrod.report.charts.styles import preset_style, preset_title
from conrod.report.figure import Figure
from conrod.report.kind import Kind
from conrod.report.table import Table, table
from conrod.report.terminal import PrintedPart
from conrod.studies.validation.results import DefectVerdict
from docs.studies.detection_results import Detection, PresetDetection

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

LOOSE = 10.0  # times the error, of a tolerance that should be sharper
QUANTITIES = ("position", "velocity", "acceleration", "velocity_rms")
DIGITS, TIGHTNESS_DIGITS = 3, 6  # saved, of sizes; of errors and tolerances


def _kinds(found: Detection) -> dict[tuple[str, str], str]:
    """Defects by verdict and name, with their unit."""
    kinds: dict[tuple[str, str], str] = {}
    for preset in found.presets():
        for kind, some in preset.defects().items():
            kinds |= {(kind, one.defect): one.unit for one in some}
    return kinds


def _sizes(found: Detection, kind: str, defect: str) -> dict[tuple[str, str], list[DefectVerdict]]:
    """By engine and preset what is found of a defect on each machine."""
    sizes: dict[tuple[str, str], list[DefectVerdict]] = {}
    for preset in found.presets():
        for one in preset.defects().get(kind, ()):
            if one.defect == defect:
                sizes.setdefault((preset.engine, preset.preset), []).append(one)
    return sizes


def limits_table(found: Detection) -> Table:
    """Return a row for each defect: over all machines, median and largest of the smallest sizes that are noticed."""
    presets = dict.fromkeys((one.engine, one.preset) for one in found.presets() if one.qualified)
    rows = []
    for (kind, defect), unit in _kinds(found).items():
        sizes, cells = _sizes(found, kind, defect), []
        for preset in presets:
            verdicts = sizes.get(preset, [])
            seen = [one for one in verdicts if one.visible]
            least = [one.smallest for one in seen if one.smallest is not None]
            missed = [one for one in seen if (one.smallest is None if unit else not one.by)]
            text = "cannot be seen" if verdicts and not seen else "noticed" if verdicts else "not judged"
            if unit and least:
                text = ", ".join(numbers.defect_size_text(size, unit) for size in (float(np.median(least)), max(least)))
            cells.append(text + (f"; not noticed on {len(missed)} of {len(seen)}" if missed else ""))
        rows.append((defect + (" (forces)" if kind == "forces" else ""), *cells))
    return table(["defect", *(preset_title(*preset) for preset in presets)], rows)


def alarms_table(found: Detection) -> Table:
    """Return a row for each verdict: its false alarms, and tolerances over errors."""
    rows = []
    for machine in found.machines:
        for one in machine.presets:
            tight = [_times(*one.tightness[q]) if q in one.tightness else numbers.MISSING for q in QUANTITIES]
            judged = f"{len(one.alarms)} of {one.healthy}" if one.healthy else one.reason or "not judged"
            rows.append((machine.name, engine_style(one.engine).title, one.preset, judged, *tight))
    head = ["machine", "engine", "preset", "false alarms", *(f"{q}: tolerance / error" for q in QUANTITIES)]
    return table(head, rows, head[3:])


def _times(error: float, allowed: float) -> str:
    return numbers.quantity(allowed / error, 3) if error > numbers.ROUNDING else "rounding"


def false_alarms(found: Detection) -> list[str]:
    """Describe each false alarm."""
    return [
        f"{machine.name}, {engine_style(one.engine).title} {one.preset}, {alarm.steps_per_revolution} steps, speed "
        f"{alarm.speed:.4g} rad/s: "
        + (", ".join(f"{q} {f / a:.3g} times its tolerance" for q, (f, a) in alarm.over.items() if f) or alarm.reason)
        for machine in found.machines
        for one in machine.presets
        for alarm in one.alarms
    ]


def loose_tolerances(found: Detection) -> list[str]:
    """Describe each tolerance that is more than `LOOSE` times the error."""
    return [
        f"{machine.name}, {engine_style(one.engine).title} {one.preset}: {quantity} {_times(error, allowed)}"
        for machine in found.machines
        for one in machine.presets
        for quantity, (error, allowed) in one.tightness.items()
        if error > numbers.ROUNDING and allowed > LOOSE * error
    ]


def verdict_text(found: Detection) -> str:
    """Say how many false alarms and loose tolerances there are."""
    runs = sum(one.healthy for one in found.presets())
    pairs = sum(len([q for q in QUANTITIES if q in one.tightness]) for one in found.presets())
    return (
        f"{len(false_alarms(found))} false alarms in {runs} healthy runs; {len(loose_tolerances(found))} tolerances of "
        f"{pairs} are more than {LOOSE:g} times what is measured."
    )


def sizes_figure(found: Detection) -> Figure:
    """The figure of all sizes that are noticed."""
    return Figure("detection", "Smallest defects that the verdicts notice", lambda: _draw_sizes(found))


def _draw_sizes(found: Detection) -> Canvas:
    """Draw a row for each defect that has a size, a mark for each machine at the smallest size that is noticed."""
    from matplotlib.figure import Figure as Canvas

    from conrod.report.charts.canvas import add_legend_above, set_log_axis, set_rows

    kinds = {key: unit for key, unit in _kinds(found).items() if unit}
    drawn = Canvas(figsize=(10.5, 0.34 * len(kinds) + 1.2))
    axes = drawn.subplots()
    labels: dict[str, Any] = {}
    for row, key in enumerate(kinds):
        sizes = sorted(_sizes(found, *key).items())
        for k, (preset, verdicts) in enumerate(sizes):
            least = sorted(one.smallest for one in verdicts if one.smallest is not None)
            style = preset_style(*preset) | {"linestyle": "none", "markersize": 4.0}
            if least:
                (mark,) = axes.plot(least, [row + 0.22 * (k - 1)] * len(least), **style)
                labels.setdefault(preset_title(*preset), mark)
        if not any(one.smallest for _, verdicts in sizes for one in verdicts):
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


def _in_saved_digits(found: Detection) -> Detection:
    """Round the smallest sizes, which may lie far below what the kind's digits tell from 0."""
    return Detection(
        tuple(replace(one, presets=tuple(map(_preset_in_saved_digits, one.presets))) for one in found.machines)
    )


def _preset_in_saved_digits(preset: PresetDetection) -> PresetDetection:
    if preset.qualified is None:
        return preset
    rounded = {
        kind: tuple(
            one if one.smallest is None else replace(one, smallest=numbers.round_to_digits(one.smallest, DIGITS))
            for one in some
        )
        for kind, some in preset.defects().items()
    }
    return replace(preset, qualified=replace(preset.qualified, **rounded))


def _summary(found: Detection) -> Mapping[str, Any]:
    return {"verdict": verdict_text(found), "alarms": false_alarms(found)}


def _printed(findings: Sequence[Detection]) -> Iterator[PrintedPart]:
    for found in findings:
        yield limits_table(found)
        yield alarms_table(found)
        yield from false_alarms(found)
        yield verdict_text(found)


DETECTION_REPORT = Kind(
    name="detection",
    findings=Detection,
    title=lambda found: "Would it notice?",
    summary=_summary,
    printed=_printed,
    verdict=verdict_text,
    one_part=True,
    prepare_to_save=_in_saved_digits,
    digits=TIGHTNESS_DIGITS,
    digits_of={"smallest": None},
)
