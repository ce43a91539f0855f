"""The report of a sweep: all of it made first, so that it can be put in place together."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from matplotlib.figure import Figure

from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.names import FILE, INDEX, figure_file, page_file
from conrod.report.reproduction import Reproduction
from conrod.report.sweep.bands import bands_figure
from conrod.report.sweep.budgets import budgets_figure
from conrod.report.sweep.document import DRAWN, document_text, earlier_sweeps, scene_entry
from conrod.report.sweep.index import sweep_index
from conrod.report.sweep.page import sweep_page
from conrod.report.sweep.refinement_orders import orders_figure
from conrod.report.sweep.work_precision import work_precision_figure
from conrod.scenes import SCENES
from conrod.studies.frame.files import Batch
from conrod.studies.sweep.results import SweepStudy

if TYPE_CHECKING:
    from conrod.studies.recommend.transfer import Transfer

EXPLANATION = Path("docs/work-precision.md")
FIGURES: Mapping[str, Callable[[SweepStudy], Figure | None]] = {
    "work-precision": work_precision_figure,
    "orders": orders_figure,
    "convergence-index": bands_figure,
    "budget": budgets_figure,
}


def sweep_report_batch(
    studies: Sequence[SweepStudy], directory: Path, command: Reproduction, transfers: Sequence[Transfer] = ()
) -> Batch:
    """All files of a sweep's report, rendered; nothing is written yet, so an error leaves an existing one as it was.

    Scenes that a sweep's report in the folder already holds, and that are not among the studies, stay in its index.
    Other files are not touched.

    Args:
        command: what reproduces the report.
        transfers: settings chosen on all scenes but one, and tried on that one.
    """
    files: dict[str, str] = {}
    scenes = earlier = earlier_sweeps(directory)
    explanation = _explanation(directory)
    for study in studies:
        alone = command.of(study.name)
        drawn = sweep_figures(study)
        files |= {figure_file(study.name, name): text for name, text in drawn.items()}
        files[page_file(study.name)] = sweep_page(study, alone, drawn, explanation)
        scenes = scenes | {study.name: scene_entry(study, alone)}
    scenes = _in_order(scenes)
    files[FILE] = document_text(scenes, [found.as_dict() for found in transfers])
    files[INDEX] = sweep_index(scenes, transfers, _command_for_all(scenes, studies, command), explanation)
    return Batch(directory, files, _stale(directory, [s.name for s in studies if s.name in earlier], files))


def sweep_figures(study: SweepStudy) -> dict[str, str]:
    """The SVG figures of a scene by name; those for which it has data."""
    drawn = {}
    with drawing_style():
        for name in DRAWN:
            figure = FIGURES[name](study)
            if figure is not None:
                drawn[name] = svg_text(figure)
    return drawn


def _explanation(directory: Path) -> str:
    """Where to learn to read the report: a link where the report lies in a copy of the project, the name otherwise."""
    text = "how to read a work-precision diagram, and what each knob does"
    folder = directory.resolve()
    for parent in folder.parents:
        if (parent / EXPLANATION).is_file():
            return f"New to this? Read [{text}]({Path(os.path.relpath(parent / EXPLANATION, folder)).as_posix()})."
    return f"New to this? conrod's `{EXPLANATION.as_posix()}` says {text}."


def _command_for_all(scenes: Mapping[str, Any], studies: Sequence[SweepStudy], command: Reproduction) -> str | None:
    """The command that makes all scenes of the index; None where some are of an earlier run."""
    names = [study.name for study in studies]
    return command.of(*names) if set(names) == set(scenes) else None


def _stale(directory: Path, names: Sequence[str], files: Mapping[str, str]) -> tuple[str, ...]:
    """Figures that an earlier page of a scene showed and the new one does not."""
    candidates = [figure_file(name, figure) for name in names for figure in DRAWN]
    return tuple(c for c in candidates if c not in files and (directory / c).is_file())


def _in_order(scenes: Mapping[str, Any]) -> dict[str, Any]:
    """The scenes that ship first, in their order."""
    names = [*(name for name in SCENES if name in scenes), *sorted(name for name in scenes if name not in SCENES)]
    return {name: scenes[name] for name in names}
