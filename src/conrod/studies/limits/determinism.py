"""Whether an engine does the same thing twice, to the last bit: in one process, and in another one."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, replace
from typing import Any

from conrod.engines import engine_named
from conrod.scenes import Saw, Scene, ShearPress
from conrod.studies.execution.isolation import Ended, isolated_once
from conrod.studies.frame.measurement import Measurement
from conrod.studies.frame.study import Study
from conrod.studies.limits.case import Case
from conrod.studies.limits.cell import LimitCell
from conrod.studies.limits.extremes import Extremes
from conrod.studies.limits.stream_run import watch

# Which runs a cell of this kind is made of, in their order.
RUNS = ("first", "again", "after another machine", "in another process")
BETWEEN_STEPS = 200  # a revolution of the machine that runs in between

Task = Callable[[LimitCell], Measurement]


@dataclass(frozen=True)
class RepeatedCell(LimitCell):
    """A run that is made four times, see `RUNS`; its measurement is the first one's, with the others' fingerprints."""

    def _identity(self, parameters: dict[str, float] | None) -> dict[str, Any]:
        return super()._identity(parameters) | {"repeated": RUNS}

    def perform(self) -> Measurement:
        return repeated(self)

    @property
    def once(self) -> LimitCell:
        """One of its runs."""
        return LimitCell(
            self.name,
            self.scene,
            self.settings,
            self.revolutions,
            self.start_angle,
            self.signed_angles,
            self.declaration,
        )


@dataclass(frozen=True)
class Determinism:
    """Whether the runs of an engine with a preset on a scene were the same.

    Attributes:
        outcome, reason: of the run itself, or, where the other process had none, how that one ended.
        fingerprints: of all states and observed points, by the names of `RUNS`; empty where there is no run.
        identical: whether each of the other runs was the first one bit for bit; empty where there is no run.
    """

    scene: str
    engine: str
    preset: str
    outcome: str
    reason: str
    fingerprints: Mapping[str, str]
    identical: Mapping[str, bool] = field(init=False)

    def __post_init__(self) -> None:
        others = RUNS[1:] if self.fingerprints else ()
        same = {run: self.fingerprints[run] == self.fingerprints[RUNS[0]] for run in others}
        object.__setattr__(self, "identical", same)

    @property
    def identical_in_process(self) -> bool | None:
        """Whether the second run was the first one; None without runs."""
        return self.identical.get("again")

    @property
    def identical_after_another(self) -> bool | None:
        """Whether nothing of another machine's run in the same engine was left over; None without runs."""
        return self.identical.get("after another machine")

    @property
    def identical_across(self) -> bool | None:
        """Whether another process gave the same bits; None without runs."""
        return self.identical.get("in another process")

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Determinism:
        """The inverse of `as_dict`."""
        return cls(**{name: value for name, value in values.items() if name != "identical"})


def determinism_search(case: Case) -> Study[Determinism]:
    """The runs of a case, at its usual steps, made again and again."""
    cell = RepeatedCell(case.name, case.scene, case.settings())
    answers = yield (cell,)
    return determinism(case, answers[cell.key])


def determinism(case: Case, measurement: Measurement) -> Determinism:
    """What the measurement of a repeated run of a case tells."""
    watched = Extremes.of(measurement)
    prints = () if watched is None else (watched.fingerprint, *watched.again)
    return Determinism(
        scene=case.name,
        engine=case.engine,
        preset=case.preset,
        outcome=measurement.outcome,
        reason=measurement.reason,
        fingerprints=dict(zip(RUNS, prints, strict=True)) if prints else {},
    )


def repeated(cell: RepeatedCell, task: Task = watch) -> Measurement:
    """The measurement of a run that is made again and again.

    Args:
        task: what makes one run; a function that can be pickled.
    """
    once = cell.once
    first, again = task(once), task(once)
    task(_another(once))
    after = task(once)
    elsewhere = isolated_once(task, once)
    if isinstance(elsewhere, Ended):
        return Measurement(elsewhere.outcome.slug, f"in another process: {elsewhere.reason}")
    watched = Extremes.of(first)
    if watched is None:
        return first
    others = tuple(_fingerprint(run) for run in (again, after, elsewhere))
    return replace(first, extremes=replace(watched, again=others).as_dict())


def _fingerprint(measurement: Measurement) -> str:
    watched = Extremes.of(measurement)
    return "" if watched is None else watched.fingerprint


def _another(cell: LimitCell) -> LimitCell:
    """A run of another machine in the same engine: what it leaves behind there is not that machine's own."""
    scene: Scene = Saw() if not isinstance(cell.scene, Saw) else ShearPress()
    # Whatever preset the engine names first: every machine can be run with it.
    preset = next(iter(engine_named(cell.settings.engine).presets.values()))
    return LimitCell("another", scene, preset(scene, BETWEEN_STEPS), revolutions=1.0)
