"""Variations of an engine's settings, one thing at a time: how far each can be driven."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import Generic

from conrod.engines.engine import AnyFields, Machine, with_fields


class Variations(ABC, Generic[AnyFields]):
    """Variations of settings with fields `iterations`, `rounded_state` and `cam_vertices`."""

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
