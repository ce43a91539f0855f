"""Error of one quantity over a run, as it is kept: its sizes, and a curve that can be drawn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from conrod.exact.motion import Array
from conrod.runs.comparison import Size, size_of

# More cannot be distinguished in the width of a figure; each span keeps its largest error.
SPANS = 400


@dataclass(frozen=True)
class ErrorCurve:
    """Normalised error over a run.

    Attributes:
        size: max, rms and final value of all samples.
        at: where each span begins (N,), in the unit of the run's axis; at most `SPANS`.
        largest: largest error in each span (N,).
    """

    size: Size
    at: Array
    largest: Array


def error_curve(at: Array, error: Array) -> ErrorCurve:
    """The curve of errors (T,) at places (T,) of a run."""
    edges = np.unique(np.linspace(0, len(error), min(SPANS, len(error)) + 1).astype(int))[:-1]
    return ErrorCurve(size_of(error), np.asarray(at[edges]), np.asarray(np.maximum.reduceat(error, edges)))
