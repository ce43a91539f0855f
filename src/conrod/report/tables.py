"""Markdown tables, lists and paragraphs."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def table(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; a cell's bars are escaped. Nothing where there are no rows."""
    body = [_row(row) for row in rows]
    if not body:
        return ""
    return "\n".join([_row(head), _row(["---"] * len(head)), *body])


def paragraphs(*blocks: str) -> str:
    """Blocks with an empty line between them; empty ones are left out."""
    return "\n\n".join(block.strip("\n") for block in blocks if block.strip())


def bullets(points: Iterable[str]) -> str:
    """A list of points, each on one line."""
    return "\n".join(f"- {' '.join(point.split())}" for point in points)


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(cell.replace("|", "\\|").replace("\n", " ") for cell in cells) + " |"
