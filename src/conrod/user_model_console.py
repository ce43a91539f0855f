"""What the command line prints of a user's own model."""

from __future__ import annotations

from rich.markup import escape
from rich.table import Table

from conrod.console import console
from conrod.report.user_model import run_words, words
from conrod.studies.user_model.study import ModelStudy


def print_model_study(study: ModelStudy) -> None:
    """Verdict, frame, wiring, paths, runs."""
    out = console()
    colour = "green" if study.passed else "red"
    out.print(f"[{colour}]{escape(study.file)}: {escape(words.verdict(study))}[/]", soft_wrap=True)
    for title, lines in (
        ("frame", words.frame(study)),
        ("wiring", words.wiring(study)),
        ("paths (kinematic mode)", words.paths(study)),
        ("its own settings", [run_words.own_settings(study), *study.scan.remarks]),
    ):
        out.print(f"\n{title}")
        for line in lines:
            out.print(f"  {escape(line)}", soft_wrap=True)
    out.print()
    if study.runs:
        table = Table(title="driven: largest error, normalised by L, omega L, omega^2 L", title_justify="left")
        for heading in run_words.HEAD:
            table.add_column(heading, justify="left" if heading in ("settings", "verdict") else "right")
        for row in run_words.rows(study):
            table.add_row(*(escape(cell) for cell in row))
        out.print(table)
    for line in run_words.drive(study):
        out.print(f"  {escape(line)}", soft_wrap=True)
