"""Names of the files of reports whose kind is not in the frame yet."""

from __future__ import annotations

FIGURES, FILE, INDEX = "figures", "results.json", "README.md"


def page_file(scene: str) -> str:
    """Name of a scene's page in the report's folder."""
    return f"{scene}.md"


def figure_file(scene: str, figure: str) -> str:
    """Name of a scene's figure in the report's folder."""
    return f"{FIGURES}/{scene}-{figure}.svg"
