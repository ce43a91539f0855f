"""Cost of a model over that of another one, as a case that the ledger keeps."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from conrod.engines import engine_named
from conrod.runs.plain import plain, restore
from conrod.runs.trajectory import Outcome, Settings
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.paired_timing import ROUNDS, PairedTiming, time_pair
from conrod.studies.frame.run import RunCase

COST_VERSION = 1  # raised when what is kept of the same timing means something else than before


@dataclass(frozen=True)
class CostCase(RunCase):
    """The cost of a revolution over that with other settings; see `conrod.studies.frame.paired_timing`.

    Attributes:
        against: the other settings.
        machine: fingerprint of the machine that it is timed on: figures of different machines do not mix.
        rounds: how often both are timed.
    """

    signed_angles: int = 0
    against: Settings = field(kw_only=True)
    machine: str = field(kw_only=True)
    rounds: int = field(kw_only=True, default=ROUNDS)

    def perform(self) -> Measurement:
        timing = time_pair(
            engine_named(self.settings.engine), self.scene, self.settings, self.against, rounds=self.rounds
        )
        return Measurement(Outcome.COMPLETED.slug, beside={"paired": plain(timing)})

    def _read(self, measurement: Measurement) -> None:
        if measurement.beside is not None:
            restore(PairedTiming, measurement.beside["paired"])

    def _identity(self, parameters: dict[str, Any] | None) -> dict[str, Any]:
        against = {key: value for key, value in self.against.as_dict().items() if key != "preset"}
        paired = {"cost": COST_VERSION, "machine": self.machine, "rounds": self.rounds}
        return super()._identity(parameters) | {"against": against} | paired
