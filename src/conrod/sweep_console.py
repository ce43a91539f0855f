"""What `conrod sweep` prints."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from rich.table import Table

from conrod.console import console
from conrod.studies.results import QUANTITIES
from conrod.studies.sweep_results import SweepStudy, SweptPoint

WIDE = 170  # where there is no terminal to fit
CAPTION = "ratio: a revolution costs as much as so many steps of the engine's fixed reference loop"


def print_fronts(studies: Sequence[SweepStudy]) -> None:
    """For each scene and engine the settings that no other one beats in both cost and position error."""
    out = console(WIDE)
    for study in studies:
        title = f"{study.name}: settings that none beats in both cost and position"
        table = Table(title=title, title_justify="left", caption=CAPTION, caption_justify="left")
        for heading in ("point", "setting", "steps/rev", *QUANTITIES, "ms/rev", "ratio"):
            left = heading in ("point", "setting")
            # A narrow terminal breaks the names of settings, never the figures.
            table.add_column(heading, justify="left" if left else "right", no_wrap=heading != "setting")
        for engine in study.engines:
            for point in study.front("position", engine):
                table.add_row(*_row(point))
        out.print(table)
        out.print(_outcomes(study), markup=False, soft_wrap=True)


def _row(point: SweptPoint) -> list[str]:
    assert point.timing is not None
    name = point.rule if point.preset is None else f"{point.rule} [{point.preset}]".replace("[", "\\[")
    errors = [f"{point.error(quantity):.1e}" for quantity in QUANTITIES]
    cost = [f"{1e3 * point.timing.seconds_per_revolution:.3g}", f"{point.timing.ratio:.3g}"]
    return [point.label, f"{point.engine}: {name}", str(point.steps_per_revolution), *errors, *cost]


def _outcomes(study: SweepStudy) -> str:
    counts = Counter(point.measurement.outcome for point in study.points)
    return f"{len(study.points)} settings and steps: " + ", ".join(f"{n} {slug}" for slug, n in counts.most_common())
