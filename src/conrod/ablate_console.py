"""What `conrod ablate` prints."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from conrod.console import console
from conrod.report.ablate.words import (
    alone,
    change_of,
    cost_of,
    in_full,
    needs_text,
    speed_up,
    torque_text,
    verdict_text,
)
from conrod.studies.ablate.results import AblationStudy, EngineAblation, Verdict

WIDE = 190  # where there is no terminal to fit
COLOURS = {Verdict.REQUIRED: "cyan", Verdict.FREE: "green", Verdict.COSTLY: "yellow", Verdict.HARMFUL: "red"}
HEADINGS = ("ingredient", "in words", "cost alone", "cost in full", "change", "verdict", "drive torque", "needed by")
CAPTION = (
    "cost: with it over without it, the median and the interval that holds it with 95 %; change: of the position, "
    "over the travel"
)


def print_ablation(studies: Sequence[AblationStudy]) -> None:
    """For each scene and engine, what every ingredient costs and changes, and what follows."""
    out = console(WIDE)
    for study in studies:
        for found in study.engines:
            table = Table(title=f"{study.name}, {found.engine}", title_justify="left")
            table.caption, table.caption_justify = CAPTION, "left"
            for heading in HEADINGS:
                table.add_column(heading)
            for row in _rows(found):
                table.add_row(*row)
            if table.row_count:
                out.print(table)
            out.print(speed_up(found).replace("**", ""), markup=False, soft_wrap=True)


def _rows(found: EngineAblation) -> list[list[str]]:
    colours = {verdict.slug: colour for verdict, colour in COLOURS.items()}
    rows = []
    for one in found.ingredients:
        colour, text = colours.get(one.verdict, "none"), verdict_text(one)
        first = alone(one) or in_full(one)
        rows.append(
            [
                one.name,
                one.title,
                cost_of(alone(one)),
                cost_of(in_full(one)),
                change_of(first),
                f"[{colour}]{text}[/]",
                torque_text(one),
                needs_text(one),
            ]
        )
    return rows
