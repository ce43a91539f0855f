"""Variations of an engine's settings, one thing at a time, which separate the causes of an error."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic

from conrod.engines.engine import AnyFields, Machine, step_length, with_fields


class Variations(ABC, Generic[AnyFields]):
    """Variations of settings with fields `iterations`, `rounded_state` and `cam_vertices`."""

    def refined(self, machine: Machine, settings: AnyFields, steps_per_revolution: int) -> AnyFields:
        """The same settings, in seconds, at another number of steps per revolution."""
        step = step_length(machine, steps_per_revolution)
        return with_fields(settings, steps_per_revolution=steps_per_revolution, timestep=step)

    @abstractmethod
    def converged(self, machine: Machine, settings: AnyFields, times: int = 1) -> AnyFields:
        """With as many iterations as stand for infinitely many, or a multiple of them."""

    @abstractmethod
    def less_regularised(self, machine: Machine, settings: AnyFields) -> AnyFields | None:
        """With less regularisation of what closes the joints or of the contacts; None where there is none."""

    @abstractmethod
    def restabilised(self, machine: Machine, settings: AnyFields) -> AnyFields | None:
        """With another stabilisation of what closes the joints or of the contacts; None where there is none."""

    @abstractmethod
    def stabilised(self, machine: Machine, settings: AnyFields, steps: float) -> AnyFields:
        """With a time constant of so many steps, of what closes the joints or, of a cam, of the contacts.

        Guards of the engine against short ones are off where they would act.
        """

    @abstractmethod
    def regularised(self, machine: Machine, settings: AnyFields, share: float) -> AnyFields | None:
        """With so much regularisation; None where the engine has none.

        Args:
            share: in (0, 1], of what the engine puts on a joint by itself; of a contact what impedance lacks of 1.
        """

    def iterated(self, settings: AnyFields, iterations: int) -> AnyFields:
        """With so many iterations of the solver at most."""
        return with_fields(settings, iterations=iterations)

    def rounded(self, settings: AnyFields, single: bool) -> AnyFields:
        """With the state rounded to single precision after each step, or not."""
        return with_fields(settings, rounded_state=single)

    def faceted(self, settings: AnyFields, vertices: int) -> AnyFields:
        """With a polygon of about so many vertices for each cam."""
        return with_fields(settings, cam_vertices=vertices)
