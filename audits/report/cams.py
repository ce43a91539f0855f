"""The report on the cams of document 004 in the engines: one page of tables and the document's figures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from audits.cam_runs import EXACT, EXACT_MEAN, CamFamily, CamRun
from audits.report.cam_motion import figures, printed_marks
from conrod.report import numbers
from conrod.report.charts.styles import engine_title
from conrod.report.figure import Figure
from conrod.report.kind import Kind
from conrod.report.table import VERDICT, Cell, ColouredCell, Table, table
from conrod.report.terminal import PrintedPart

ERROR_DIGITS, PEAK_DIGITS = 2, 4  # saved
MARK_DECIMALS = np.array([[3], [2], [1]])  # of lift, velocity, acceleration: finer than can be seen in a figure
RATES = {"velocity": "mm/s", "acceleration": "mm/s²"}


def errors_table(family: CamFamily) -> Table:
    """Return a row for each cam: its errors in the engines, and the verdict."""
    engines = [engine_title(name) for name in family.engines]
    rows = [
        (f"{cam.base:g}", f"{cam.flank:g}", *(_error_cell(cam, name) for name in family.engines), _verdict(cam))
        for cam in family.cams
    ]
    right = ("R [mm]", "rho [mm]", *engines)
    return table((*right, VERDICT), rows, right, "largest position error over the lift", names=2)


def _error_cell(cam: CamRun, engine: str) -> Cell:
    error = cam.errors[engine]
    text = "did not complete" if error is None else numbers.measured_text(error)
    return ColouredCell(text, "bad") if cam.passed[engine] is False else text


def _verdict(cam: CamRun) -> Cell:
    if failed := [engine_title(name) for name, passed in cam.passed.items() if passed is False]:
        return ColouredCell(f"OUT OF TOLERANCE: {', '.join(failed)}", "bad")
    return ColouredCell("within tolerance", "good")


def rates_table(family: CamFamily, quantity: str) -> Table:
    """Return a row for each cam: the largest velocity, or acceleration, exact, in the engines and in print."""
    k, unit = list(RATES).index(quantity), RATES[quantity]
    columns = {f"exact [{unit}]": EXACT, "exact, mean": EXACT_MEAN}
    columns |= {f"{engine_title(name)}, mean": name for name in family.engines}
    rows = [
        (f"{cam.base:g}", f"{cam.flank:g}", *(_peak_text(cam, name, k) for name in columns.values()),
         _printed_text(cam, quantity))
        for cam in family.cams
    ]  # fmt: skip
    right = ("R [mm]", "rho [mm]", *columns, "printed")
    return table(right, rows, right, f"largest {quantity} in size")


def _peak_text(cam: CamRun, of: str, k: int) -> str:
    return f"{cam.peaks[of][k]:#.{PEAK_DIGITS}g}" if of in cam.peaks else numbers.MISSING


def _printed_text(cam: CamRun, quantity: str) -> str:
    """Extremes that the document prints for the cam, without those of a mirrored angle."""
    own = [
        mark for mark in printed_marks() if (mark.base, mark.flank, mark.quantity) == (cam.base, cam.flank, quantity)
    ]
    return ", ".join(dict.fromkeys(f"{abs(mark.value):g}" for mark in own))


def largest_difference(family: CamFamily, quantity: str) -> str:
    """Largest difference of the engines' peaks from the exact ones over the same spans, as shares of these."""
    k = list(RATES).index(quantity)
    shares = {
        name: max(
            abs(float(cam.peaks[name][k] / cam.peaks[EXACT_MEAN][k]) - 1.0) for cam in family.cams if name in cam.peaks
        )
        for name in family.engines
    }
    return " and ".join(f"{100.0 * share:.2g} % in {engine_title(name)}" for name, share in shares.items())


def all_figures(family: CamFamily) -> dict[str, Figure]:
    """Return the document's figures by number."""
    return {figure.name.removeprefix("figure-"): figure for figure in figures(family)}


def verdict_text(family: CamFamily) -> str:
    """Say how many cams are within tolerance, and which are not."""
    failed = [f"R = {cam.base:g}, rho = {cam.flank:g} mm" for cam in family.cams if False in cam.passed.values()]
    engines = " and ".join(f"{engine_title(name)} {version}" for name, version in family.engines.items())
    if failed:
        return f"OUT OF TOLERANCE in {engines}: {len(failed)} of {len(family.cams)} cams: {'; '.join(failed)}."
    return f"All {len(family.cams)} cams are within tolerance in {engines}."


def _kept(family: CamFamily) -> CamFamily:
    """Return the findings in digits that come out the same on every machine."""
    return replace(family, cams=tuple(map(_rounded, family.cams)))


def _rounded(cam: CamRun) -> CamRun:
    errors = {
        name: None if error is None else numbers.round_to_digits(error, ERROR_DIGITS)
        for name, error in cam.errors.items()
    }
    peaks = {
        name: np.array([numbers.round_to_digits(float(value), PEAK_DIGITS) for value in values])
        for name, values in cam.peaks.items()
    }
    marks = {name: np.round(motion / (step := 10.0**-MARK_DECIMALS)) * step + 0.0 for name, motion in cam.marks.items()}
    return replace(cam, errors=errors, peaks=peaks, marks={name: np.round(one, 6) for name, one in marks.items()})


def _summary(family: CamFamily) -> Mapping[str, Any]:
    return {"passed": family.passed, "verdict": verdict_text(family)}


def _printed(found: Sequence[CamFamily]) -> Iterator[PrintedPart]:
    for family in found:
        yield errors_table(family)
        yield verdict_text(family)


CAMS_REPORT = Kind(
    name="cams",
    findings=CamFamily,
    title=lambda family: "The cams of document 004 in the engines",
    summary=_summary,
    printed=_printed,
    verdict=verdict_text,
    one_part=True,
    prepare_to_save=_kept,
)
