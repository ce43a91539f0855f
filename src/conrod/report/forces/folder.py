"""The files of a report on forces: in a folder of their own, or beside the report on motion."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from pathlib import Path
from typing import Any

from conrod.report.apart import check_beside
from conrod.report.own_folder import check_own_folder, document_in, holds_document

FIGURES, FILE, INDEX = "figures", "forces.json", "forces.md"
KEYS = {"schema", "force_scenes"}


def page_of(scene: str) -> str:
    """Name of a scene's page."""
    return f"{scene}-forces.md"


def figure_of(scene: str) -> str:
    """Name of a scene's figure."""
    return f"{FIGURES}/{scene}-torque.svg"


def index_of(scenes: Sequence[str]) -> str:
    """The page to read first: that of the scene, or the list of several."""
    return page_of(scenes[0]) if len(scenes) == 1 else INDEX


def check_force_files(directory: Path, scenes: Collection[str], document: Path | None) -> None:
    """Refuse what the report would replace that is not its own, and a document that is a file of it.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    own = holds_document(directory / FILE, KEYS)
    pages = [INDEX, FILE, *(page_of(scene) for scene in scenes)]
    drawn = [figure_of(scene) for scene in scenes]
    check_own_folder(directory, pages, drawn, FIGURES, own, "a report on forces")
    if document:
        check_beside(document, directory, [*pages, *drawn])


def earlier_scenes(directory: Path) -> dict[str, Any]:
    """Scenes of the report on forces that a folder already holds, by name."""
    try:
        scenes = document_in(directory / FILE)["force_scenes"]
        return {name: entry for name, entry in scenes.items() if (directory / page_of(name)).is_file()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return {}
