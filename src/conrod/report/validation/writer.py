"""Writes a report: all of it made first, then put in place together, the index last."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from importlib.metadata import version
from itertools import repeat
from pathlib import Path
from typing import Any

from conrod.report.charts.canvas import drawing_style, svg_text
from conrod.report.charts.errors import error_figure
from conrod.report.charts.motion import motion_figure
from conrod.report.charts.refinement import refinement_figure
from conrod.report.charts.styles import FIGURE_NAMES, completed
from conrod.report.drawing.drawing import mechanism_svg
from conrod.report.reproduction import Reproduction
from conrod.report.validation.index import index_page
from conrod.report.validation.pages import scene_page
from conrod.report.validation.summary import (
    FILE,
    INDEX,
    earlier_scenes,
    figure_file,
    page_file,
    scene_summary,
    summary_text,
)
from conrod.scenes import SCENES
from conrod.scenes.catalogue import CATALOGUE, catalogue_names
from conrod.studies.frame.files import Batch, write_together
from conrod.studies.validation.results import SceneStudy

Draw = Callable[..., Iterable[Any]]


def write_report(studies: Sequence[SceneStudy], directory: Path, command: Reproduction) -> list[Path]:
    """Write the report of some studies into a folder, which is made if there is none.

    Returns:
        The files written, the index last.
    """
    batch = report_batch(studies, directory, command)
    write_together([batch])
    return [directory / name for name in batch.files]


def report_batch(
    studies: Sequence[SceneStudy],
    directory: Path,
    command: Reproduction,
    shown: Sequence[str] = FIGURE_NAMES,
    draw: Draw = map,
) -> Batch:
    """All files of a report, rendered; nothing is written yet, so that an error leaves an existing report as it was.

    Scenes that a report in the folder already holds, and that are not among the studies, stay in its index. Other
    files are not touched.

    Args:
        command: what reproduces the report.
        shown: names of the figures that the pages show.
        draw: as `map`; that of an executor makes several pages at a time.
    """
    files: dict[str, str] = {}
    earlier = earlier_scenes(directory)
    scenes = dict(earlier)
    commands = [command.of(study.name) for study in studies]
    made = draw(_page_files, studies, commands, repeat(tuple(shown)))
    for study, alone, page_and_figures in zip(studies, commands, made, strict=True):
        files |= page_and_figures
        scenes[study.name] = scene_summary(study, alone)
    scenes = _in_order(scenes)
    files[FILE] = summary_text(scenes, version("conrod"))
    files[INDEX] = index_page(scenes, _command_for_all(scenes, studies, command))
    return Batch(directory, files, _stale(directory, [s.name for s in studies if s.name in earlier], files))


def _command_for_all(scenes: Mapping[str, Any], studies: Sequence[SceneStudy], command: Reproduction) -> str | None:
    """The command that makes all scenes of the index; None where some are of an earlier run."""
    names = [study.name for study in studies]
    if set(names) != set(scenes):
        return None
    if set(names) == set(SCENES):
        return command.of_all_that_ship()
    is_catalogue = not command.typed and set(names) == set(catalogue_names())
    return command.of(*((CATALOGUE,) if is_catalogue else names))


def _stale(directory: Path, names: Sequence[str], files: Mapping[str, str]) -> tuple[str, ...]:
    """Figures that an earlier page of a scene showed and the new one does not."""
    candidates = [figure_file(name, figure) for name in names for figure in FIGURE_NAMES]
    return tuple(c for c in candidates if c not in files and (directory / c).is_file())


def _page_files(study: SceneStudy, command: str, shown: Sequence[str]) -> dict[str, str]:
    """A scene's page and its figures; for any process."""
    drawn = {figure_file(study.name, name): text for name, text in figures(study, shown).items()}
    return {**drawn, page_file(study.name): scene_page(study, command, shown)}


def figures(study: SceneStudy, shown: Sequence[str] = FIGURE_NAMES) -> dict[str, str]:
    """The SVG figures of a scene by name; those of the runs only where one completed."""
    runs = completed(study.results)
    of_runs = {"motion": motion_figure, "error": error_figure, "order": refinement_figure} if runs else {}
    if not any(run.refinement for run in runs):
        of_runs.pop("order", None)
    drawn = {"mechanism": mechanism_svg(study.scene)} if "mechanism" in shown else {}
    with drawing_style():
        return drawn | {name: svg_text(make(study)) for name, make in of_runs.items() if name in shown}


def _in_order(scenes: Mapping[str, Any]) -> dict[str, Any]:
    """The scenes that ship first, in their order."""
    names = [*(name for name in SCENES if name in scenes), *sorted(name for name in scenes if name not in SCENES)]
    return {name: scenes[name] for name in names}
