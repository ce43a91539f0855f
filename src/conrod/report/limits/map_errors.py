"""Errors at the nodes of a map that were not run, for its shades alone: between those of the runs about them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from conrod.motion import Array
from conrod.report.canvas import on_log_grid
from conrod.studies.limits.maps import MapRun

# The nearest runs count nearly alone, so that many runs along a boundary do not outweigh one nearby.
POWER = 4


def shaded_errors(runs: Sequence[MapRun], shape: tuple[int, int]) -> Array:
    """Errors (columns, rows): the runs' own, elsewhere their geometric mean weighted by distance in nodes to the -4.

    What a node's level is does not depend on this.

    Raises:
        ValueError: no run has an error.
    """
    told = [run for run in runs if run.error is not None]
    if not told:
        raise ValueError("there is no error to tell others from")
    at = np.array([(run.i, run.j) for run in told], dtype=float)
    logarithms = np.log10(on_log_grid(np.array([run.error for run in told])))
    i, j = np.meshgrid(np.arange(shape[0]), np.arange(shape[1]), indexing="ij")
    squared = (i[..., None] - at[:, 0]) ** 2 + (j[..., None] - at[:, 1]) ** 2
    # At a run itself all weight is its own.
    weights = np.where(squared > 0.0, squared, 1e-9) ** (-POWER / 2)
    return on_log_grid(10.0 ** ((weights @ logarithms) / weights.sum(axis=2)))
