"""How an engine's settings are varied on purpose: one thing at a time, to tell the causes of an error apart."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING, Generic

from conrod.engines.presets import AnySettings

if TYPE_CHECKING:
    from conrod.engines.engine import Machine


class Variations(ABC, Generic[AnySettings]):
    """What studies vary of an engine's settings; each engine says which of its fields that is."""

    @abstractmethod
    def refined(
        self, machine: Machine, settings: AnySettings, steps_per_revolution: int, softness_follows: bool
    ) -> AnySettings:
        """The same settings at another number of steps per revolution.

        Args:
            softness_follows: whether what closes the joints keeps its softness in steps; else it does in seconds.
        """

    @abstractmethod
    def converged(self, machine: Machine, settings: AnySettings, times: int = 1) -> AnySettings:
        """With as many iterations as stand for infinitely many, or a multiple of them."""

    @abstractmethod
    def less_regularised(self, machine: Machine, settings: AnySettings) -> AnySettings | None:
        """With less regularisation of what closes the joints or of the contacts; None where there is none."""

    @abstractmethod
    def restabilised(self, machine: Machine, settings: AnySettings) -> AnySettings | None:
        """With another stabilisation of what closes the joints or of the contacts; None where there is none."""

    @abstractmethod
    def stabilised(self, machine: Machine, settings: AnySettings, steps: float) -> AnySettings:
        """With a time constant of so many steps, of what closes the joints or, of a cam, of the contacts.

        Guards of the engine against short ones are off where they would act.
        """

    @abstractmethod
    def regularised(self, machine: Machine, settings: AnySettings, share: float) -> AnySettings | None:
        """With so much regularisation; None where the engine has none.

        Args:
            share: in (0, 1], of what the engine puts on a joint by itself; of a contact what impedance lacks of 1.
        """

    @abstractmethod
    def iterated(self, settings: AnySettings, iterations: int) -> AnySettings:
        """With so many iterations of the solver at most."""

    @abstractmethod
    def rounded(self, settings: AnySettings, single: bool) -> AnySettings:
        """With the state rounded to single precision after each step, or not."""

    @abstractmethod
    def faceted(self, settings: AnySettings, vertices: int) -> AnySettings:
        """With a polygon of about so many vertices for each cam."""

    @abstractmethod
    def gravity_switched(self, settings: AnySettings) -> AnySettings:
        """Without gravity, or with it where there was none."""

    @abstractmethod
    def formal_order(self, settings: AnySettings) -> float:
        """Order that the description of the integrator promises, over smooth forces."""
