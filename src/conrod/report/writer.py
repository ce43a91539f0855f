"""Writes a report: all of it made first, then put in place together, the index last."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.files import Batch, write_together
from conrod.report.canvas import drawing_style, svg_text
from conrod.report.drawing import mechanism_svg
from conrod.report.error_figure import error_figure
from conrod.report.index import index_page
from conrod.report.motion_figure import motion_figure
from conrod.report.pages import scene_page
from conrod.report.refinement_figure import refinement_figure
from conrod.report.styles import completed
from conrod.report.summary import (
    DRAWN_OF_RUNS,
    FILE,
    INDEX,
    earlier_scenes,
    figure_file,
    page_file,
    scene_summary,
    summary_text,
)
from conrod.scenes import SCENES
from conrod.studies.results import SceneStudy

SCENE = "{scene}"


def write_report(studies: Sequence[SceneStudy], directory: Path, command: str) -> list[Path]:
    """Write the report of some studies into a folder, which is made if there is none.

    Returns:
        The files written, the index last.
    """
    batch = report_batch(studies, directory, command)
    write_together([batch])
    return [directory / name for name in batch.files]


def report_batch(studies: Sequence[SceneStudy], directory: Path, command: str) -> Batch:
    """All files of a report, rendered; nothing is written yet, so that an error leaves an existing report as it was.

    Scenes that a report in the folder already holds, and that are not among the studies, stay in its index. Other
    files are not touched.

    Args:
        command: what reproduces the report; the first `{scene}` in it stands for the scenes' names.
    """
    files: dict[str, str] = {}
    earlier = earlier_scenes(directory)
    scenes = dict(earlier)
    for study in studies:
        alone = command.replace(SCENE, study.name, 1)
        files |= {figure_file(study.name, name): text for name, text in figures(study).items()}
        files[page_file(study.name)] = scene_page(study, alone)
        scenes[study.name] = scene_summary(study, alone)
    scenes = _in_order(scenes)
    files[FILE] = summary_text(scenes, version("conrod"))
    files[INDEX] = index_page(scenes, _command_for_all(scenes, studies, command))
    return Batch(directory, files, _stale(directory, [s.name for s in studies if s.name in earlier], files))


def _command_for_all(scenes: Mapping[str, Any], studies: Sequence[SceneStudy], command: str) -> str | None:
    """The command that makes all scenes of the index; None where some are of an earlier run."""
    names = [study.name for study in studies]
    if set(names) != set(scenes):
        return None
    # Without a name the command runs all scenes that ship.
    return command.replace(f"{SCENE} ", "" if set(names) == set(SCENES) else f"{' '.join(names)} ", 1)


def _stale(directory: Path, names: Sequence[str], files: Mapping[str, str]) -> tuple[str, ...]:
    """Figures that an earlier page of a scene showed and the new one does not, because no run completed."""
    candidates = [figure_file(name, figure) for name in names for figure in DRAWN_OF_RUNS]
    return tuple(c for c in candidates if c not in files and (directory / c).is_file())


def figures(study: SceneStudy) -> dict[str, str]:
    """The SVG figures of a scene by name; those of the runs only where one completed."""
    drawn = {"mechanism": mechanism_svg(study.scene)}
    runs = completed(study.results)
    if runs:
        with drawing_style():
            drawn["motion"] = svg_text(motion_figure(study))
            drawn["error"] = svg_text(error_figure(study))
            if any(run.refinement for run in runs):
                drawn["order"] = svg_text(refinement_figure(study))
    return drawn


def _in_order(scenes: Mapping[str, Any]) -> dict[str, Any]:
    """The scenes that ship first, in their order."""
    names = [*(name for name in SCENES if name in scenes), *sorted(name for name in scenes if name not in SCENES)]
    return {name: scenes[name] for name in names}
