"""The report on a user's model, and the table of its runs."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

from conrod.own.models.runs import QUANTITIES
from conrod.own.models.study import EXACT_SOLVER, OWN, ModelStudy
from conrod.report.charts.user_model import model_figure
from conrod.report.figure import Figure
from conrod.report.kind import Index, Kind, Page, Part
from conrod.report.table import Table, table
from conrod.report.template import rendered
from conrod.report.user_model_words import drive, frame, own_settings, paths, run_cells, verdict, wiring

RIGHT = ("steps/rev", *QUANTITIES)


def runs_table(study: ModelStudy) -> Table:
    """A row for each run: its largest errors and what they are."""
    rows = [run_cells(study, run) for run in study.runs.values()]
    return table(("settings", *RIGHT, "verdict"), rows, RIGHT, "driven: largest error, normalised by L, ω L, ω² L")


def _page(part: Part[ModelStudy]) -> Page:
    study = part.findings
    figure = Figure(
        f"{part.name}-model", "Distance from the exact paths, and errors of the runs", partial(model_figure, study)
    )
    text = rendered(
        "model", study=study, name=Path(study.file).name, verdict=verdict(study), figure=figure, command=part.command,
        places=", ".join(f"{place.point} = `{place}`" for place in study.question.places), frame=frame(study),
        wiring=wiring(study), paths=paths(study), settings=own_settings(study), runs=runs_table(study),
        drive=drive(study), own=OWN if EXACT_SOLVER in study.runs else "",
    )  # fmt: skip
    return Page(text, (figure,))


def _summary(study: ModelStudy) -> dict[str, Any]:
    return {
        "scene": study.scene_name,
        "is_machine": study.is_machine,
        "passed": study.passed,
        "verdict": verdict(study),
    }


def _index(index: Index[ModelStudy]) -> Page:
    return Page(rendered("model-index", entries=index.entries))


KIND = Kind(
    name="model",
    findings=ModelStudy,
    title=lambda study: f"{Path(study.file).name}: is it {study.scene_name}?",
    summary=_summary,
    page=_page,
    index=_index,
    results="models.json",
    index_file="models.md",
    suffix="-model",
    digits=6,
)
