"""`conrod validate` of a user's own MuJoCo model."""

from __future__ import annotations

from conrod.commands.model_options import ModelOptions
from conrod.errors import InvalidInput


def validate_model(
    file: str,
    scene: str,
    options: ModelOptions,
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
