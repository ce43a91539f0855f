"""Findings on the releases of an engine: plain, frozen data that report and command line read."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

# A change of a normalised position up to this is of last digits; so is one of a velocity or an acceleration that such
# a one makes when it is differentiated over a step.
LAST_DIGITS = 1e-12
STATES = "bodies "  # what begins the names of a body's states, as against outputs that are read of them


@dataclass(frozen=True)
class Change:
    """A change of a run from one release to the next one that was run.

    Attributes:
        version, before: the release with the change, and the one before.
        outcomes, errors: before and after; the largest position error, normalised, or None unless it completed.
        differ: names of the states and outputs that are not the same to the last bit.
        size: by quantity, the largest difference of the two motions at twenty angles of the last turn, normalised as
            errors are; empty unless both completed.
        last_digits: whether nothing but these changed; True also where the size of other bits is not known.
        explained: what the engine's own changelog says of the release that can be the cause; empty where nothing is.
    """

    version: str
    before: str
    outcomes: tuple[str, str]
    errors: tuple[float | None, float | None]
    differ: tuple[str, ...]
    size: Mapping[str, float]
    last_digits: bool
    explained: tuple[str, ...] = ()

    @property
    def in_outputs_alone(self) -> bool:
        """True if the states are the same to the last bit, and what is read of them is not."""
        return not any(name.startswith(STATES) for name in self.differ)


@dataclass(frozen=True)
class History:
    """A scene with some settings through the releases.

    Attributes:
        changes: where a run is not that of the release before, to the last bit.
    """

    scene: str
    settings: str
    steps_per_revolution: int
    changes: tuple[Change, ...]

    def change_at(self, version: str) -> Change | None:
        """The change of a release; None where it is the same as the one before to the last bit."""
        return next((change for change in self.changes if change.version == version), None)


@dataclass(frozen=True)
class VersionStudy:
    """Releases of an engine on the same runs.

    Attributes:
        source: where the engine's own changelog is.
        measured: versions that could be had, the oldest first.
        unsupported: why others could not.
    """

    engine: str
    source: str
    measured: tuple[str, ...]
    unsupported: Mapping[str, str]
    histories: tuple[History, ...]

    def changes_at(self, version: str) -> tuple[tuple[History, Change], ...]:
        """What changed with a release."""
        return tuple((one, change) for one in self.histories if (change := one.change_at(version)) is not None)
