"""What a look at a model is asked to do. Imports no engine."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.user_model import Place

DEFAULT_STEPS = 2000  # two revolutions of a machine that takes 1000 steps for one
MOST_STEPS = 1_000_000


@dataclass(frozen=True)
class Request:
    """How a model is run and what of it is observed.

    Attributes:
        keyframe: name or number of the keyframe that it starts from; None for the first, or the model's own pose.
        seconds: how long [s]; None for so many steps.
        crank: hinge that is driven; needs a speed.
        speed: of the crank [rad/s]; None for a free run.
        points: what is observed; every body where there is none.
        ignored: names of rules that are not asked.
        fix_folder: where a fixed model will be; None where none is asked for.
    """

    keyframe: str | None = None
    seconds: float | None = None
    crank: str | None = None
    speed: float | None = None
    points: tuple[Place, ...] = ()
    ignored: tuple[str, ...] = ()
    fix_folder: str | None = None
