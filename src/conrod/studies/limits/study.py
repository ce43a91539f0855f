"""All that `conrod limits` finds on one scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from conrod.studies.limits.determinism import Determinism
from conrod.studies.limits.float_results import FollowerFloat
from conrod.studies.limits.iteration_need import IterationNeed
from conrod.studies.limits.maps import LimitMap
from conrod.studies.limits.results import LongRun, Walk


@dataclass(frozen=True)
class LimitStudy:
    """What was found on a scene; parts that were not asked for are empty.

    Attributes:
        name, kind, title, parameters: of the scene.
        engines: name -> version.
        walks: of all axes, presets and engines, refused ones with their reason.
    """

    name: str
    kind: str
    title: str
    parameters: Mapping[str, float]
    engines: Mapping[str, str]
    walks: tuple[Walk, ...]
    long_runs: tuple[LongRun, ...]
    maps: tuple[LimitMap, ...]
    needs: tuple[IterationNeed, ...]
    determinism: tuple[Determinism, ...]
    floats: tuple[FollowerFloat, ...]

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> LimitStudy:
        """The inverse of `as_dict`."""
        parts: dict[str, Any] = {
            "walks": Walk,
            "long_runs": LongRun,
            "maps": LimitMap,
            "needs": IterationNeed,
            "determinism": Determinism,
            "floats": FollowerFloat,
        }
        return cls(**{**values, **{name: tuple(part.of(v) for v in values[name]) for name, part in parts.items()}})
