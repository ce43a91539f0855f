"""A run whose follower's gap is kept, thinned, for a figure."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from conrod.engines.running import run
from conrod.exact.motion import Array
from conrod.runs.outcome import joint_gaps
from conrod.studies.frame.measurement import Measurement
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.extremes import Extremes
from conrod.studies.limits.stream_run import watch

SPANS = 360  # of a run, of each of which the least and the largest gap are kept

# Crank angle [rad], gap there, least and largest gap around it [m].
Gaps = tuple[tuple[float, float, float, float], ...]


@dataclass(frozen=True)
class GapCell(LimitCell):
    """A run of a cam whose measurement carries the gap over the run as well; it is made twice for that."""

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"gap_spans": SPANS}

    def perform(self) -> Measurement:
        return recorded(self)


def recorded(cell: GapCell) -> Measurement:
    """The measurement of a run with its gap."""
    measurement = watch(cell)
    watched = Extremes.of(measurement)
    if watched is None or not watched.finite:
        return measurement
    mechanism = cell.machine.kinematics.mechanism
    trajectory = run(cell.machine, cell.settings, cell.revolutions, cell.start_angle)
    assert trajectory.bodies is not None
    states = trajectory.bodies.position
    contact = mechanism.cam_contacts[0]
    gap = joint_gaps(mechanism, [states.poses])[contact.name]
    return replace(measurement, extremes=replace(watched, gaps=thinned(states.instants.angle, gap)).as_dict())


def thinned(angle: Array, gap: Array) -> Gaps:
    """The gap in the middle, the least and the largest one of each of `SPANS` equal parts of a run (or of fewer)."""
    angles, gaps = (np.array_split(values, min(SPANS, len(values))) for values in (angle, gap))
    return tuple(
        (float(a[len(a) // 2]), float(g[len(g) // 2]), float(g.min()), float(g.max()))
        for a, g in zip(angles, gaps, strict=True)
    )
