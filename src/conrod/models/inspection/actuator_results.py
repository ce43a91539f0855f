"""Results of trying a model's actuators, as plain data that need no engine, with the words that say them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from conrod.report.numbers import measured_text, quantity

REACHED_SHARE = 0.05  # of a commanded move that may be missing where it is reached
MAX_OVERSHOOT = 0.25  # of a move; a damping ratio of 0.4 overshoots by that much
SAME_RESPONSE = 0.05  # of a response's range, that half the step may change of what is called the same
MAX_STEP_CHANGE = 0.2  # of a response's range, that half the step may change
MISSED_SHARE = 0.2  # of a commanded move; what misses by more has not done what it was told
AT_LIMIT_SHARE = 0.999  # of a force limit from which on a force is at the limit
NO_SAG_SHARE = 1e-3  # of a move, below which a sag is not worth a word

# SI unit -> the unit shown, and the factor to it.
SHOWN_UNITS = {
    "rad": ("deg", 180.0 / math.pi),
    "m": ("mm", 1e3),
    "rad/s": ("rpm", 30.0 / math.pi),
    "m/s": ("mm/s", 1e3),
}
FORCE_UNITS = {"rad": "N m", "m": "N"}
# Kinds of actuators that a law of the position, or of the speed, can be commanded of.
SERVOS, SPEEDS = ("position",), ("velocity", "intvelocity")


def shown_value(value: float, unit: str) -> str:
    """Return a value [SI] in the unit that engineers write, such as '68.75 deg'."""
    name, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    return f"{quantity(value * factor, 3)} {name}"


def _shown_size(value: float, unit: str) -> str:
    """Return the size of a measured value [SI] in two digits, such as '3.2 deg'."""
    name, factor = SHOWN_UNITS.get(unit, (unit, 1.0))
    return f"{measured_text(abs(value) * factor)} {name}"


def percent_text(share: float) -> str:
    """Return a share in two digits of a per cent, such as '1.1 %'."""
    return "< 0.1 %" if abs(share) < 1e-3 else f"{measured_text(100.0 * abs(share))} %"


@dataclass(frozen=True)
class StepResponse:
    """The response to a command that jumps from one value to another.

    Attributes:
        begin, target, final: what was reached before, what is commanded, and the mean that is reached [rad or m, /s].
        move: length of the commanded move [rad or m, /s], that shares are of; never 0.
        overshoot: share of the move by which the response goes beyond its final value.
        settling: time [s] after which the response stays within 2 % of its final value; None if it does not settle.
        swing: share of the move by which the response still swings at the end.
        seconds: length of the run after the jump [s].
        peak, last: largest and last force of the actuator [N or N m, before its gear].
        obstacles: limits and contacts that bear a part of its last force.
        creeps: whether it still moves on towards its target at the end, without a swing.
    """

    begin: float
    target: float
    final: float
    move: float
    overshoot: float
    settling: float | None
    swing: float
    seconds: float
    peak: float
    last: float
    obstacles: tuple[str, ...] = ()
    creeps: bool = False

    @property
    def error(self) -> float:
        """Steady-state error [rad or m, /s]: final value less commanded value."""
        return self.final - self.target

    @property
    def missing_share(self) -> float:
        """Share of the move that is missing, or too much, in the end."""
        return abs(self.error) / self.move

    @property
    def is_reached(self) -> bool:
        """True if the response ends near its target."""
        return self.missing_share <= REACHED_SHARE


@dataclass(frozen=True)
class StepBounds:
    """Largest time steps at which halving the step leaves an actuator's response the same.

    Attributes:
        own: step of the model [s].
        integrator: integrator of the model.
        largest: largest tried step [s] whose response is that of half the step; None if none is.
        implicitfast: the same with `implicitfast`; None if none is, or it was not tried.
        diverges: whether the response diverges at the model's own step.
        change: share of its range by which half of the model's own step changes the response; None where it diverges.
        tried: least and largest step [s] whose response was compared with that of half the step.
    """

    own: float
    integrator: str
    largest: float | None
    implicitfast: float | None
    diverges: bool
    change: float | None
    tried: tuple[float, float]

    @property
    def bears_own(self) -> bool:
        """True if the response stays the same when the model's own step is halved."""
        return self.largest is not None and self.largest >= self.own * (1.0 - 1e-9)

    @property
    def fails_own(self) -> bool:
        """True if the response diverges at the model's own step, or changes much when it is halved."""
        return self.change is None or self.change > MAX_STEP_CHANGE

    @property
    def words(self) -> str:
        """Describe the largest steps, and any failure at the model's own step."""
        own, implicit = _step_text(self.own), self.implicitfast
        other = f", with implicitfast {_step_text(implicit)}" if implicit and implicit > (self.largest or 0.0) else ""
        if not self.bears_own and not self.fails_own:
            return f"with half its step of {own} it changes by {percent_text(self.change or 0.0)}{other}"
        if not self.bears_own:
            what = "diverges" if self.change is None else f"changes by {percent_text(self.change)} with half the step,"
            bears = None if self.largest is None else f"the largest that it bears is {_step_text(self.largest)}"
            least = bears or f"none down to {_step_text(self.tried[0])} is small enough"
            return f"{what} at its step of {own}: {least} ({self.integrator}){other}"
        assert self.largest is not None
        at_least = "at least " if self.largest >= self.tried[1] * (1.0 - 1e-9) else ""
        return f"{largest_step_words(f'{at_least}{_step_text(self.largest)}')}{other}"


def largest_step_words(size: str) -> str:
    """Say how large the largest stable step is, and which response at half of it makes it stable."""
    return f"largest stable step {size} (half of it has the same response within {percent_text(SAME_RESPONSE)})"


def _step_text(seconds: float) -> str:
    """Return a time step [s] as text."""
    return f"{quantity(1e3 * seconds, 3)} ms"


@dataclass(frozen=True)
class ActuatorResult:
    """Measured behaviour of an actuator in its trial.

    Attributes:
        kind: position, velocity, intvelocity, motor, cylinder, muscle, damper, adhesion, general, or another.
        drives: what it acts on, in words, such as 'joint crank'.
        unit: unit of what it moves: rad or m.
        inertia: inertia that it moves, along its joint or length [kg m^2 or kg]; None where it moves nothing.
        load: force [N or N m, before its gear] that holds the start against weight and springs.
        limit: largest force of the actuator to the weaker side; None without one.
        sag: how far it is off its command at rest [rad or m; rad/s or m/s of a speed]; None where not tried.
        responses: responses to jumps of its command, in the order of time.
        broke: why its run broke off; empty if it did not.
        steps: time steps that it bears; None where not searched.
        acceleration: at its largest control [rad/s^2 or m/s^2]; None where a position or speed is commanded.
        full: its largest control, that `acceleration` is of.
        holds: values [rad or m] between which its force holds the joint at rest, of a range; None where not looked at.
        span: the whole range of values that `holds` is a part of.
        damping_hint: damping gain of a servo with which it would not overshoot; None where none helps.
        remark: how it was tried, or why not, in words.
    """

    name: str
    kind: str
    drives: str
    unit: str
    inertia: float | None = None
    load: float = 0.0
    limit: float | None = None
    sag: float | None = None
    responses: tuple[StepResponse, ...] = ()
    broke: str = ""
    steps: StepBounds | None = None
    acceleration: float | None = None
    full: float | None = None
    holds: tuple[float, float] | None = None
    span: tuple[float, float] | None = None
    damping_hint: float | None = None
    remark: str = ""

    @property
    def moved_unit(self) -> str:
        """Unit of commands and responses: of the coordinate, or of its rate where a speed is commanded."""
        return f"{self.unit}/s" if self.kind in ("velocity", "intvelocity", "damper") else self.unit

    @property
    def force_unit(self) -> str:
        """Unit of its force."""
        return FORCE_UNITS[self.unit]

    @property
    def overshoot(self) -> float:
        """Largest overshoot, as a share of the move."""
        return max((one.overshoot for one in self.responses), default=0.0)

    @property
    def is_too_weak(self) -> bool:
        """True if it stays at its force limit short of its command, with nothing in its way, or its load is larger."""
        if self.limit is None or self.sag is None:
            return False
        return abs(self.load) > self.limit or self._weakest is not None

    @property
    def _weakest(self) -> StepResponse | None:
        """The response that remains furthest off at the force limit with nothing in its way; None if none does."""
        if (limit := self.limit) is None or self.sag is None:
            return None
        free = (one for one in self.responses if not one.is_reached and not one.obstacles)
        held = (one for one in free if abs(one.last) >= AT_LIMIT_SHARE * limit)
        return max(held, key=lambda one: one.missing_share, default=None)

    @property
    def misses_command(self) -> bool:
        """True if a servo ends further off than `MISSED_SHARE` of a move, with nothing in its way."""
        missed = (one.missing_share > MISSED_SHARE and not one.obstacles for one in self.responses)
        return self.kind in (*SERVOS, *SPEEDS) and any(missed)

    @property
    def alarms(self) -> tuple[str, ...]:
        """Faults of the actuator, each in words that follow its name; empty for a healthy one."""
        return tuple(self._alarms())

    def _alarms(self) -> Iterator[str]:
        """Yield each fault of the actuator, in a clause."""
        if self.broke:
            yield self.steps.words if self.steps is not None and self.steps.diverges else f"diverges: {self.broke}"
            return
        if self.is_too_weak:
            given, short = f"it gives {measured_text(self.limit)} {self.force_unit}", self._weakest
            takes = f"holding its start takes {measured_text(abs(self.load))} {self.force_unit}"
            yield f"is too weak: {given}, and {takes if short is None else self._ends_words(short)}"
        elif worst := max((r for r in self.responses if not r.is_reached), key=lambda r: r.missing_share, default=None):
            yield self._missing_words(worst)
        unsettled = [one for one in self.responses if one.settling is None and not one.creeps]
        if self.overshoot > MAX_OVERSHOOT or unsettled:
            hint = f"; {self.damping_hint_words}" if self.damping_hint is not None else ""
            does = f"overshoots by {percent_text(self.overshoot)}"
            if unsettled:
                worst = max(unsettled, key=lambda one: one.swing)
                still = f"still swings by {percent_text(worst.swing)} of its move after {quantity(worst.seconds, 2)} s"
                does = f"{does} and {still}" if self.overshoot > MAX_OVERSHOOT else still
            yield f"{does}{hint}"
        if self.steps is not None and self.steps.fails_own:
            yield self.steps.words

    def _missing_words(self, worst: StepResponse) -> str:
        """Say how far the worst response to a step remains from its command."""
        off = _shown_size(worst.error, self.moved_unit)
        if worst.creeps and not worst.obstacles:
            target = shown_value(worst.target, self.moved_unit)
            return f"is slow: after {quantity(worst.seconds, 2)} s it is still {off} off {target}, and moves on"
        where = self._ends_words(worst)
        if worst.obstacles:
            return f"{where}: {' and '.join(worst.obstacles)} in the way"
        if abs(self.load) > 0.0 and self.sag is not None and abs(self.sag) > 0.5 * abs(worst.error):
            # The load where it ends, which is not that of the start.
            return f"{where}, under a load of {measured_text(abs(worst.last))} {self.force_unit} there: its gain is low"
        return where

    def _ends_words(self, response: StepResponse) -> str:
        """Say how far off its command a response ends."""
        off, unit = _shown_size(response.error, self.moved_unit), self.moved_unit
        return f"ends {off} off the {shown_value(response.target, unit)} that are commanded"

    @property
    def damping_hint_words(self) -> str:
        """The damping gain that avoids an overshoot, in words."""
        return f'kv={quantity(self.damping_hint or 0.0, 3)} would not (dampratio="1")'

    def words(self) -> str:
        """Describe the actuator's behaviour in one or two sentences that begin with its name."""
        said = list(self._clauses())
        alarms = "; ".join(self.alarms)
        parts = [part for part in (alarms and f"it {alarms}", ", ".join(said)) if part]
        remark = f" ({self.remark})" if parts and self.remark else ""
        return f"{self.name} ({self.kind}, {self.drives}): {'; '.join(parts) or self.remark}{remark}"

    def _clauses(self) -> Iterator[str]:
        """Yield clauses on the actuator's responses or acceleration, its force and its stable steps."""
        unit = self.moved_unit
        if self.broke:
            return
        if self.responses:
            far, worst = (
                max(self.responses, key=lambda one: one.move),
                max(self.responses, key=lambda one: one.missing_share),
            )
            brakes = "brakes " if self.kind == "damper" else ""
            yield f"{brakes}from {shown_value(far.begin, unit)} to {shown_value(far.target, unit)}"
            if worst.is_reached:
                yield f"reached within {percent_text(worst.missing_share)}"
                times = [one.settling for one in self.responses]
                if all(time is not None for time in times):
                    yield f"settles in {quantity(max(t for t in times if t is not None), 2)} s"
                yield f"overshoots {percent_text(self.overshoot)}" if self.overshoot > 1e-3 else "no overshoot"
            if self.sag is not None and not self.is_too_weak and abs(self.sag) > NO_SAG_SHARE * far.move:
                verb = "drifts" if self.moved_unit.endswith("/s") else "sags"
                yield f"{verb} by {_shown_size(self.sag, unit)} at rest"
            yield self._peak_words(max(abs(one.peak) for one in self.responses))
        elif self.acceleration is not None:
            yield from self._force_words()
        if self.steps is not None and not self.steps.fails_own:
            yield self.steps.words

    def _peak_words(self, peak: float) -> str:
        """Say the largest force of the trial, and the actuator's limit if it has one."""
        of = "" if self.limit is None else f" of {measured_text(self.limit)}"
        return f"peak {measured_text(peak)}{of} {self.force_unit}"

    def _force_words(self) -> Iterator[str]:
        """Yield clauses on a force actuator: its acceleration, its load, and where it holds the load."""
        full, rate = quantity(self.full or 0.0, 3), f"{measured_text(abs(self.acceleration or 0.0))} {self.unit}/s²"
        yield f"a force: no position is reached, at control {full} it accelerates by {rate}"
        if self.load:
            yield f"holding its start takes {measured_text(abs(self.load))} {self.force_unit}"
        if self.holds is not None and self.span is not None:
            if self.holds == self.span:
                yield "it holds its load in the whole range"
            else:
                low, high = (shown_value(end, self.unit) for end in self.holds)
                yield f"it holds its load from {low} to {high} only" if low != high else "it holds its load nowhere"
