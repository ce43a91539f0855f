"""`conrod limits`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import click

from conrod.cli import options
from conrod.cli.options import StudyOptions, option
from conrod.errors import InvalidInput, unknown_choice
from conrod.mechanism.units import check_number, parse_quantity

if TYPE_CHECKING:
    from conrod.report.terminal import Part
    from conrod.studies.limits.axis import Axis
    from conrod.studies.limits.results import LimitStudy

SEPARATOR = ".."


@dataclass(frozen=True)
class Asked(StudyOptions):
    """Request to `conrod limits`, as typed; None or empty where nothing was given."""

    axes: tuple[str, ...] = option(
        "--axis", multiple=True, metavar="AXIS", help="One axis or pair of docs/limits.md, again for others [all]."
    )
    span: str | None = option("--range", metavar="FROM..TO", help="Other ends of the one axis, e.g. 200..2.")
    preset: str | None = option("--preset")


@options.verb(Asked)
@click.argument("scenes", nargs=-1, metavar="[SCENE]...")
def limits(scenes: tuple[str, ...], asked: Asked) -> None:
    """Find where each engine stops being trustworthy, how it fails there, and whether one would notice.

    Each axis is walked from its safe end to its failing one, and its boundaries are found to 2 %. Finished runs are
    kept in the ledger: an interrupted study goes on where it stopped.
    """
    from conrod.cli.outputs import outputs
    from conrod.cli.runner import Runner
    from conrod.report.limits.report import KIND
    from conrod.studies.frame.resolve_arguments import select_presets, select_scenes
    from conrod.studies.limits.plan import check_asked, plan_limits, pursue_plans

    chosen, engines = select_scenes(scenes, asked.assignments), options.chosen_engines(asked.engine)
    select_presets(engines, asked.preset)
    items, span = _request(asked.axes, asked.span)
    files = outputs(KIND, chosen, asked)
    plans = [plan_limits(name, scene, engines, asked.preset, items, span) for name, scene in chosen.items()]
    check_asked(plans)
    with Runner.of(asked) as runner, runner.answering() as run:
        studies = pursue_plans(plans, run)
    # Limits of a run are given too: they decide how some end.
    ended = {"--cell-timeout": asked.cell_timeout, "--cell-memory": asked.cell_memory}
    files.answer({study.name: study for study in studies}, limits_found(studies), "limits", scenes, ended)


def limits_found(studies: Sequence[LimitStudy]) -> Iterator[Part]:
    """For each scene and axis, how far each engine and preset can be relied on, and how it fails beyond."""
    from conrod.report.limits.tables import limits_table, refusals
    from conrod.report.numbers import lengths

    for study in studies:
        title = f"{study.name}: holds up to (undetected: finite numbers, no warning, wrong motion)"
        yield limits_table(study.walks, title)
        yield f"10 % and 1 % are shares of the travel L{lengths(study.lengths)}"
        yield from (f"Not walked: {line}" for line in refusals(study.walks))


# -- the request ------------------------------------------------------------------------------------------------------


def _request(names: Sequence[str], span: str | None) -> tuple[tuple[str, ...], tuple[float, float] | None]:
    """Return the items and their range; none where nothing is named. InvalidInput where options do not go together."""
    from conrod.studies.limits.axes import AXES
    from conrod.studies.limits.plan import ITEMS

    for name in names:
        if name not in ITEMS:
            raise unknown_choice("axis", name, ITEMS)
    if span is not None and (len(names) != 1 or names[0] not in AXES):
        raise InvalidInput(f"--range {span} needs one --axis to be the range of")
    return tuple(dict.fromkeys(names)), None if span is None else _span(span, AXES[names[0]])


def _span(text: str, axis: Axis) -> tuple[float, float]:
    from conrod.studies.limits.axis import measure_of

    if axis.listed:
        raise InvalidInput(f"--range {text} does not go with {axis.name}: its values are a list, all of which are run")
    ends = [_end(axis, part) for part in text.split(SEPARATOR) if part.strip()]
    if len(set(ends)) != 2:
        example = f"{axis.safe_end:g}{SEPARATOR}{axis.failing_end:g}"
        raise InvalidInput(f"--range {text!r}: give two different ends, for instance {example}")
    # Whichever way it was typed, a walk begins at the safe end.
    at_safe = measure_of(axis.scale, axis.safe_end)
    safe, failing = sorted(ends, key=lambda value: abs(measure_of(axis.scale, value) - at_safe))
    return safe, failing


def _end(axis: Axis, text: str) -> float:
    value = parse_quantity("--range", text, "")
    check_number(f"--range of {axis.name}", value, *axis.allowed)
    if axis.scale.value == "count" and value != round(value):
        raise InvalidInput(f"--range of {axis.name}: {value:g} is not a whole number")
    return value
