"""What a study of limits looks at that is no axis and no pair of axes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

from conrod.engines.engine import judged_preset
from conrod.studies.frame.study import Study
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axes.cams import FollowerFloat
from conrod.studies.limits.axes.machine import MassRatio
from conrod.studies.limits.case import Case
from conrod.studies.limits.determinism import determinism_search
from conrod.studies.limits.follower_float import float_search, most_float_runs
from conrod.studies.limits.iteration_need import ITERATIONS, most_need_runs, need_search


@dataclass(frozen=True)
class Part:
    """One of them.

    Attributes:
        name: on the command line.
        kind: field of `LimitStudy` that keeps what its searches find.
        refusal: None, or why a case does not have it.
        searches: those of a case.
        most: how many runs each of them can ask for.
    """

    name: str
    kind: str
    refusal: Callable[[Case], str | None]
    searches: Callable[[Case], Sequence[Callable[[], Study[Any]]]]
    most: Callable[[Case], int]


def _no_rule_to_replace(case: Case) -> str | None:
    # An engine as it comes is off whatever its iterations leave; later presets are the first judged one, changed.
    preset = judged_preset(case.made_by)
    if case.preset != preset:
        return f"iterations that stay are looked at with the preset {preset} alone"
    return AXES[MassRatio.name].refusal(case)


def _no_follower(case: Case) -> str | None:
    if case.contact and not case.scene.closed_form:
        return AXES[FollowerFloat.name].refusal(case)
    return None if case.contact else f"the {case.scene.kind} has no cam: there is no follower to fly"


PARTS = {
    part.name: part
    for part in (
        Part(
            "mass-ratio-at-iterations",
            "needs",
            _no_rule_to_replace,
            lambda case: [partial(need_search, case, iterations) for iterations in ITERATIONS],
            most_need_runs,
        ),
        # One cell, in which the run is made again and again.
        Part(
            "determinism", "determinism", lambda _: None, lambda case: [partial(determinism_search, case)], lambda _: 1
        ),
        Part("flight", "floats", _no_follower, lambda case: [partial(float_search, case)], lambda _: most_float_runs()),
    )
}
