"""Where each engine stops being trustworthy, how it fails there, and whether one would notice."""

from __future__ import annotations

from collections.abc import Sequence

from conrod.errors import InvalidInput, as_names, unknown_choice
from conrod.execution.resolve_arguments import (
    Engines,
    Scenes,
    choose_engines,
    engine_names_given,
    scenes_by_name,
    select_presets,
)
from conrod.execution.runner import Runner, Runs
from conrod.mechanism.units import check_number
from conrod.report.findings import Findings, text_of_call
from conrod.studies.limits.axes import AXES
from conrod.studies.limits.axis import Axis, scale_coordinate
from conrod.studies.limits.plan import SEARCHES, check_applicable, plan_limits, pursue_plans
from conrod.studies.limits.report import LIMITS_REPORT
from conrod.studies.limits.results import LimitStudy


def limits(
    scenes: Scenes = (),
    *,
    axes: str | Sequence[str] = (),
    span: tuple[float, float] | None = None,
    engines: Engines = None,
    preset: str | None = None,
    runs: Runs | None = None,
) -> Findings[LimitStudy]:
    """Walk along axes from a safe end to a failing one, and find the boundaries between to 2 %.

    Args:
        axes: names of axes or pairs of docs/limits.md; all where none is given.
        span: other ends of the one axis.
        scenes, engines, preset, runs: as in `validate`.

    Raises:
        InvalidInput: an argument cannot be used; says what can.
    """
    chosen, chosen_engines = scenes_by_name(scenes), choose_engines(engines)
    select_presets(chosen_engines, preset)
    axes = as_names(axes)
    for name in axes:
        if name not in SEARCHES:
            raise unknown_choice("axis", name, SEARCHES)
    if span is not None and (len(axes) != 1 or axes[0] not in AXES):
        raise InvalidInput(f"--range {span[0]:g}..{span[1]:g} needs one --axis to be the range of")
    ends = None if span is None else walk_ends(AXES[axes[0]], span)
    items = tuple(dict.fromkeys(axes))
    plans = [plan_limits(name, scene, chosen_engines, preset, items, ends) for name, scene in chosen.items()]
    check_applicable(plans)
    with Runner.open(runs or Runs()) as runner, runner.case_runner() as run:
        studies = pursue_plans(plans, run)
    call = text_of_call(
        "limits", list(chosen), axes=items, span=span, engines=engine_names_given(engines), preset=preset
    )
    return Findings(LIMITS_REPORT, {study.name: study for study in studies}, call)


def walk_ends(axis: Axis, ends: tuple[float, float]) -> tuple[float, float]:
    """Check the ends of a walk along an axis, and return them with the safe end first.

    Raises:
        InvalidInput: the axis has a list of values, the ends are equal, or an end is out of range.
    """
    text = f"{ends[0]:g}..{ends[1]:g}"
    if axis.listed:
        raise InvalidInput(f"--range {text} does not go with {axis.name}: its values are a list, all of which are run")
    for value in ends:
        check_number(f"--range of {axis.name}", value, *axis.allowed)
        if axis.scale.value == "count" and value != round(value):
            raise InvalidInput(f"--range of {axis.name}: {value:g} is not a whole number")
    if ends[0] == ends[1]:
        example = f"{axis.safe_end:g}..{axis.failing_end:g}"
        raise InvalidInput(f"--range {text!r}: give two different ends, for instance {example}")
    at_safe = scale_coordinate(axis.scale, axis.safe_end)
    safe, failing = sorted(ends, key=lambda value: abs(scale_coordinate(axis.scale, value) - at_safe))
    return safe, failing
