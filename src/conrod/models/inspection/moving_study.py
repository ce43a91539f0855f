"""The study of what moves a model: its mobility, its actuators, its keyframes and the energy of its free swing."""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import mujoco

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.mjcf.equalities import close_loops
from conrod.models.inspection.actuator_results import ActuatorResult
from conrod.models.inspection.actuators import try_actuators
from conrod.models.inspection.moving import CLOSED, ModelMobility, count_model_mobility
from conrod.models.inspection.moving_words import actuator_lines


@dataclass(frozen=True)
class MovingStudy:
    """What moves a model, and how well.

    Attributes:
        mobility: degrees of freedom, and what drives them; None of a model that has too many to count.
        actuators: results of its actuators, in order.
    """

    mobility: ModelMobility | None
    actuators: tuple[ActuatorResult, ...]

    @property
    def alarms(self) -> tuple[str, ...]:
        """What is wrong with actuators, each with its name."""
        return tuple(f"{one.name} {words}" for one in self.actuators for words in one.alarms)

    @property
    def passed(self) -> bool:
        """True if something can move, and no run broke off."""
        stuck = self.mobility is not None and self.mobility.is_stuck
        return not stuck and not any(one.broke for one in self.actuators)

    @property
    def lines(self) -> tuple[str, ...]:
        """The answer to `what moves it?` in lines."""
        return tuple(self._lines())

    def _lines(self) -> Iterator[str]:
        if self.mobility is not None:
            yield self.mobility.words
        yield from actuator_lines(self.actuators)


def study_moving(
    model: mujoco.MjModel, start: mujoco.MjData, progress: Callable[[str], object] = lambda name: None
) -> MovingStudy:
    """Study what moves a model, from the closed pose nearest to a start.

    Args:
        start: data at the start, as `conrod.mjcf.loading.data_at_start` gives it; it is not changed.
        progress: called with the name of each part before it is tried.
    """
    closed = copy.copy(start)
    with silence_warnings():
        if not close_loops(model, closed, CLOSED * float(model.stat.extent)):
            closed = copy.copy(start)
    return MovingStudy(count_model_mobility(model, start), try_actuators(model, closed, progress))
