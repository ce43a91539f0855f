"""Writes a report: all of it made first, then put in place file by file, the index last."""

from __future__ import annotations

import os
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

from conrod.report.canvas import drawing_style, svg_text
from conrod.report.drawing import mechanism_svg
from conrod.report.error_figure import error_figure
from conrod.report.index import index_page
from conrod.report.motion_figure import motion_figure
from conrod.report.pages import FIGURES, scene_page
from conrod.report.refinement_figure import refinement_figure
from conrod.report.styles import completed
from conrod.report.summary import FILE, earlier_scenes, scene_summary, summary_text
from conrod.scenes import SCENES
from conrod.studies.results import SceneStudy

INDEX = "README.md"
SCENE = "{scene}"


def write_report(studies: Sequence[SceneStudy], directory: Path, command: str) -> list[Path]:
    """Write the report of some studies into a folder, which is made if there is none.

    Everything is rendered into a neighbouring temporary folder before the first file is replaced, so that an error
    leaves an existing report as it was. Scenes that a report in the folder already holds, and that are not among
    the studies, stay in its index. Other files are not touched.

    Args:
        command: what reproduces the report; `{scene}` in it stands for the scene's name on a scene's page, and for
            nothing in the index.

    Returns:
        The files written, the index last.
    """
    files = _rendered(studies, directory, command)
    directory.parent.mkdir(parents=True, exist_ok=True)
    waiting = Path(tempfile.mkdtemp(dir=directory.parent, prefix=f".{directory.name}."))
    try:
        for name, text in files.items():
            (waiting / name).parent.mkdir(exist_ok=True)
            (waiting / name).write_text(text, encoding="utf-8", newline="\n")
        for name in files:
            (directory / name).parent.mkdir(parents=True, exist_ok=True)
            os.replace(waiting / name, directory / name)
    finally:
        shutil.rmtree(waiting, ignore_errors=True)
    return [directory / name for name in files]


def _rendered(studies: Sequence[SceneStudy], directory: Path, command: str) -> dict[str, str]:
    """All files of the report by their name in its folder, the index last."""
    files: dict[str, str] = {}
    scenes = earlier_scenes(directory)
    for study in studies:
        alone = command.replace(SCENE, study.name)
        files |= {f"{FIGURES}/{study.name}-{name}.svg": text for name, text in figures(study).items()}
        files[f"{study.name}.md"] = scene_page(study, alone)
        scenes[study.name] = scene_summary(study, alone)
    scenes = _in_order(scenes)
    files[FILE] = summary_text(scenes, version("conrod"))
    files[INDEX] = index_page(scenes, version("conrod"), " ".join(command.replace(SCENE, "").split()))
    return files


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
