"""`conrod validate` of the trajectory of any tool, as a table."""

from __future__ import annotations

from conrod.commands.table_options import TableOptions
from conrod.errors import InvalidInput


def validate_table(
    file: str,
    scene: str,
    options: TableOptions,
    *,
    engine: str | None,
    preset: str | None,
    steps_per_rev: int | None,
    revolutions: int | None,
    assignments: tuple[str, ...],
    tolerance: str | None,
    out: str | None,
    document: str | None,
) -> None:
    """Judge a file against the machine that a scene is."""
    raise InvalidInput(f"{file}: not yet")
