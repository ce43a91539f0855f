"""The page of one scene's sweep, in Markdown."""

from __future__ import annotations

from collections.abc import Collection

from conrod.report import numbers
from conrod.report.names import FIGURES
from conrod.report.sweep import prose
from conrod.report.sweep.bands import shares_table
from conrod.report.sweep.budgets import budget_tables
from conrod.report.sweep.failures import failures_table
from conrod.report.sweep.findings import found_in
from conrod.report.sweep.fronts import cheapest_table, counted, labelled_table
from conrod.report.sweep.naming import versions_of
from conrod.report.sweep.predicted_errors import largest_difference, told_table
from conrod.report.sweep.refinement_orders import orders_table
from conrod.report.sweep.setting_tables import knobs_table, size_of_grid, variations_table
from conrod.report.tables import paragraphs
from conrod.studies.sweep.results import SweepStudy

NO_FINDINGS = "Too little of the sweep completed for a statement."


def sweep_page(study: SweepStudy, command: str, drawn: Collection[str], explanation: str) -> str:
    """The page.

    Args:
        command: what reproduces the page.
        drawn: the figures that there are.
        explanation: where a newcomer learns to read it, in Markdown.
    """
    blocks = [
        f"# {study.name}: speed against accuracy",
        f"{study.scene.title}, swept with {versions_of(study)}. Timed on: {study.machine}.",
        f"{explanation} See the [index](README.md) for the other machines.",
        f"Reproduced by `{command}`.",
        "## What it shows",
        "\n".join(f"- {text}" for text in found_in(study)) or NO_FINDINGS,
        *_costs(study, drawn),
        "## Order, plateau, floor",
        _figure(study, "orders", drawn, "Error against steps per revolution"),
        prose.ORDERS,
        orders_table(study, presets_only=True),
        folded("Every setting", orders_table(study)),
        *_section("Would a study of convergence alone have noticed?", shares_table(study), _bands(study, drawn)),
        *_section("What the error is made of", budget_tables(study), _budget(study, drawn)),
        *_section("Errors told from the joints", folded("Every run of the presets", told_table(study)), _told(study)),
        *_section("Masses and gravity", variations_table(study), prose.VARIATIONS),
        *_section("What did not complete", failures_table(study), "Every other run of the grid completed."),
        "## What was swept",
        size_of_grid(study),
        knobs_table(study),
    ]
    return paragraphs(*blocks) + "\n"


def folded(summary: str, text: str) -> str:
    """A part of the page that a reader opens; nothing where there is nothing in it."""
    return f"<details>\n<summary>{summary}</summary>\n\n{text}\n\n</details>" if text else ""


def _section(title: str, table: str, before: str) -> list[str]:
    """A section that is there only with its table."""
    return [f"## {title}", before, table] if table else []


def _figure(study: SweepStudy, name: str, drawn: Collection[str], text: str) -> str:
    return f"![{text}, {study.name}]({FIGURES}/{study.name}-{name}.svg)" if name in drawn else ""


def _costs(study: SweepStudy, drawn: Collection[str]) -> list[str]:
    """What needs timings."""
    if "work-precision" not in drawn:
        return ["## Work-precision diagram", "No run was timed, so there is no cost to show."]
    return [
        "## Work-precision diagram",
        _figure(study, "work-precision", drawn, "Error against cost of every run"),
        prose.WORK_PRECISION,
        f"{prose.FAILED} {counted(study)}",
        "### The labelled points",
        labelled_table(study),
        prose.FRONTS,
        "## The cheapest settings",
        cheapest_table(study),
        prose.COST,
        prose.ERRORS,
        *([] if study.scene.kinematics.mechanism.driver.span is None else [prose.ONE_PASS]),
    ]


def _bands(study: SweepStudy, drawn: Collection[str]) -> str:
    return paragraphs(
        _figure(study, "convergence-index", drawn, "Share of bands that hold the true error"), prose.BANDS
    )


def _budget(study: SweepStudy, drawn: Collection[str]) -> str:
    figure = _figure(study, "budget", drawn, "Parts of the error")
    lawful = any(part.predicted is not None for budget in study.budgets for part in budget.parts)
    return paragraphs(figure, prose.BUDGET, prose.BUDGET_FIGURE if figure else "", prose.BUDGET_LAW if lawful else "")


def _told(study: SweepStudy) -> str:
    found = largest_difference(study)
    if found is None:
        return prose.TOLD
    share, runs = found
    apart = f"the two position errors differ by at most {numbers.measured(share)} of the error"
    return f"{prose.TOLD} Over {runs} runs of the grid {apart}."
