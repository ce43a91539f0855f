"""`conrod validate MACHINE --engine ENGINE`: machines in space in several engines."""

from __future__ import annotations

from typing import Any

from conrod.cli import options
from conrod.cli.options import tolerance_in

TAKEN = (
    *("--engine", "--preset", "--steps-per-rev", "--revolutions", "--tolerance", "--out", "--html", "--json"),
    *("--jobs", "--cell-timeout", "--cell-memory"),
)


def compare_engines(names: tuple[str, ...], asked: Any) -> None:
    """Compare engines on machines in space.

    Args:
        asked: options of `conrod validate`.
    """
    from conrod.cli.outputs import check_outputs, exit_with_verdict, runs_with_progress
    from conrod.scenes.space import MACHINES, SPATIAL
    from conrod.studies.space.api import REVOLUTIONS, STEPS_PER_REV, validate_in_space
    from conrod.studies.space.report import SPACE_REPORT
    from conrod.studies.space.results import UNITS

    options.refuse_others(asked, "a machine in space in several engines", *TAKEN)
    chosen = tuple(MACHINES) if SPATIAL in names else names
    files = check_outputs(SPACE_REPORT, chosen, asked)
    with runs_with_progress(asked) as runs:
        found = validate_in_space(
            chosen,
            engines=asked.engine,
            preset=asked.preset,
            steps_per_rev=STEPS_PER_REV if asked.steps_per_rev is None else asked.steps_per_rev,
            revolutions=REVOLUTIONS if asked.revolutions is None else asked.revolutions,
            tolerance=tolerance_in(asked.tolerance, UNITS),
            runs=runs,
        )
    files.print_and_write(found, "validate", names)
    exit_with_verdict(found)
