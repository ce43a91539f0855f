"""The figures of a linkage at a crank angle."""

from __future__ import annotations

from functools import partial
from pathlib import Path

from conrod.exact.linkage.quantities import InstantQuantities
from conrod.report.figure import Figure
from conrod.report.linkage.mechanism_figure import centres_figure
from conrod.report.linkage.polygon_figure import polygon_figure
from conrod.studies.frame.files import Batch

FIGURES = ("centres.svg", "velocities.svg", "accelerations.svg")


def linkage_figures(instant: InstantQuantities) -> tuple[Figure, ...]:
    """The mechanism with its instant centres, the velocity polygon and the acceleration polygon."""
    return (
        Figure("centres", "The mechanism with its instant centres", partial(centres_figure, instant.state)),
        Figure("velocities", "Velocity polygon", partial(polygon_figure, instant.velocities)),
        Figure("accelerations", "Acceleration polygon", partial(polygon_figure, instant.accelerations)),
    )


def figures_batch(instant: InstantQuantities, folder: Path) -> Batch:
    """The figures in a folder of their own."""
    return Batch(folder, {f"{figure.name}.svg": figure.svg() for figure in linkage_figures(instant)})
