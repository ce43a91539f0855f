"""Plan of the runs of machines in space: what is run, the drives' laws, and what errors are divided by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from conrod.engines import engine_named, is_plugin
from conrod.engines.space import SpatialStart
from conrod.exact.motion import QUANTITIES
from conrod.scenes.space import SpatialMachine
from conrod.scenes.space.tree import exact_points, law_period, machine_laws
from conrod.studies.space.results import SpatialResult

SCALE_SAMPLES = 721  # in a revolution, by which L and the largest speed and acceleration are found


@dataclass(frozen=True, eq=False)
class SpatialModel:
    """A user's model as the machine in space that engines are given; its exact motion is that of its own tree.

    Attributes:
        start: its exact start, whose machine has been tracked for the whole run.
        scales: as in `SpatialStudy`.
    """

    start: SpatialStart
    scales: Mapping[str, float]


@dataclass(frozen=True)
class SpatialCell:
    """A request for the runs of a machine in space in an engine with a preset.

    Attributes:
        machine, engine, preset: names.
        steps: numbers of steps in a revolution of the slowest drive, growing; the last is judged.
        revolutions: length of the runs.
        model: what is run where the machine is a user's; None for one that is known by its name.
    """

    machine: str
    engine: str
    preset: str
    steps: tuple[int, ...]
    revolutions: int
    model: SpatialModel | None = field(default=None, repr=False)

    @property
    def plugin_name(self) -> str | None:
        """Name of the engine if another package brings it: it runs in a process that no other engine runs in."""
        return self.engine if is_plugin(self.engine) else None

    def empty_result(self) -> SpatialResult:
        """Return the result with its known facts, before anything is measured."""
        return SpatialResult(
            scene=self.machine, engine=self.engine, engine_version=engine_named(self.engine).version,
            preset=self.preset, steps_per_rev=self.steps[-1], revolutions=self.revolutions,
        )  # fmt: skip


def motion_scales(machine: SpatialMachine) -> dict[str, float]:
    """L [m], the largest range of an observed point, and the largest speed [m/s] and acceleration [m/s^2] of all."""
    found = exact_points(machine, np.linspace(0.0, law_period(machine_laws(machine)), SCALE_SAMPLES))
    ranges = (np.linalg.norm(one[0][:, None] - one[0][None], axis=2).max() for one in found.values())
    largest = (max(float(np.linalg.norm(one[k], axis=1).max()) for one in found.values()) for k in (1, 2))
    return dict(zip(QUANTITIES, (max(map(float, ranges)), *largest), strict=True))
