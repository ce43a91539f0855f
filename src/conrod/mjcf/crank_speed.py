"""Speed of a crank over the last turn of a run, and what is allowed of it."""

from __future__ import annotations

import math
from dataclasses import dataclass

# A mean speed that is off by more than a per cent is another speed; `conrod lint` drives no worse. The roughest drives
# that handbooks allow, those of crushers, swing by a fifth of their speed from the slowest to the fastest.
MAX_MEAN_SPEED_ERROR, MAX_SPEED_SWING = 0.01, 0.1
# A crank that stays within this share of its turns does not turn.
STANDSTILL_TURNS = 0.01


@dataclass(frozen=True)
class CrankSpeed:
    """Speed of the crank in the last part of a run, as long as a turn at the scene's speed.

    Attributes:
        mean, least, most: mean, smallest and largest speed of the crank [rad/s].
        farthest: largest angle from where it starts, in the whole run [turns].
    """

    mean: float
    least: float
    most: float
    farthest: float = math.inf

    @property
    def is_still(self) -> bool:
        """True if the crank does not turn."""
        return self.farthest <= STANDSTILL_TURNS

    def strays(self, speed: float, allowed: float = MAX_MEAN_SPEED_ERROR) -> bool:
        """True if the mean speed is not the scene's [rad/s], or the speed was ever off by more than a tenth.

        Args:
            allowed: share of the speed that the mean may be off by.
        """
        mean, *ends = (abs(own / speed - 1.0) for own in (self.mean, self.least, self.most))
        return not (mean <= allowed and all(end <= max(MAX_SPEED_SWING, allowed) for end in ends))
