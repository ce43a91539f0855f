"""Files of free motion in a report's folder, which may hold other reports' pages too."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from conrod.report.apart import check_beside
from conrod.report.own_folder import check_own_folder, holds_document

FIGURES = "figures"
# Of the numbers of a page, by which it is known.
KEYS = {"schema", "motion", "scene", "exact"}


def page_file(scene: str) -> str:
    """A scene's page."""
    return f"{scene}-motion.md"


def numbers_file(scene: str) -> str:
    """Its numbers for machines."""
    return f"{scene}-motion.json"


def figure_file(scene: str) -> str:
    """Its figure; another one than that of a driven crank's motion."""
    return f"{FIGURES}/{scene}-free-motion.svg"


def check_motion_folder(directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a folder in which a page of free motion would replace what is none.

    Raises:
        InvalidInput: names the file that is in the way.
    """
    for scene in scenes:
        own = holds_document(directory / numbers_file(scene), KEYS)
        pages = (page_file(scene), numbers_file(scene))
        check_own_folder(directory, pages, (figure_file(scene),), FIGURES, own, "a page of free motion")


def check_motion_apart(document: Path, directory: Path, scenes: Iterable[str]) -> None:
    """Refuse a file that is one of those that the pages of some scenes consist of.

    Raises:
        InvalidInput: names the file.
    """
    names = [make(scene) for scene in scenes for make in (page_file, numbers_file, figure_file)]
    check_beside(document, directory, names)
