"""How far a choice of settings carries: chosen on some scenes, tried on the one left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from conrod.report import numbers
from conrod.report.styles import engine_title
from conrod.report.sweep.naming import tolerance
from conrod.report.tables import table

if TYPE_CHECKING:
    from conrod.studies.transfer import Transfer


def transfers_table(transfers: Sequence[Transfer]) -> str:
    """A row for each scene left out, engine and tolerance."""
    rows = [
        [
            found.left_out,
            engine_title(found.engine),
            f"{found.quantity} {tolerance(found.allowed)}",
            found.rule,
            str(found.steps_per_revolution),
            "; ".join(f"{scene} {numbers.measured(error)}" for scene, error in found.errors.items()),
            "did not complete" if found.error is None else numbers.measured(found.error),
            "yes" if found.held else "**no**",
            numbers.MISSING if found.best is None or not found.held else numbers.measured(1.0 / found.best),
        ]
        for found in transfers
    ]
    head = ["left out", "engine", "within", "cheapest settings of the others", "steps per revolution"]
    return table([*head, "errors there", "error on the one left out", "held", "cost over its own cheapest"], rows)


def transfers_sentence(transfers: Sequence[Transfer]) -> str:
    """How many held; nothing where none was tried."""
    if not transfers:
        return ""
    held = sum(found.held for found in transfers)
    return (
        f"Of {len(transfers)} settings that were the cheapest within a tolerance on all scenes but one, {held} kept "
        "that tolerance on the scene left out. (Scenes of one kind differ in speed alone.)"
    )
