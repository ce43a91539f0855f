"""The figures of a linkage at a crank angle, in one folder."""

from __future__ import annotations

from pathlib import Path

from conrod.exact.linkage.quantities import InstantQuantities
from conrod.studies.frame.files import Batch

CENTRES, VELOCITIES, ACCELERATIONS = FIGURES = ("centres.svg", "velocities.svg", "accelerations.svg")


def figures_batch(instant: InstantQuantities, folder: Path) -> Batch:
    """The mechanism with its instant centres, the velocity polygon and the acceleration polygon."""
    from conrod.report.linkage.mechanism_figure import centres_svg
    from conrod.report.linkage.polygon_figure import polygon_svg

    texts = (centres_svg(instant.state), polygon_svg(instant.velocities), polygon_svg(instant.accelerations))
    return Batch(folder, dict(zip(FIGURES, texts, strict=True)))
