"""Results on what moves a model, as plain data that need no engine, with the words that say them."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from conrod.errors import list_names
from conrod.models.inspection.actuator_results import FORCE_UNITS, percent_text, shown_value
from conrod.report.numbers import measured_text, quantity

STAYS = 0.01  # of the model's extent, that a keyframe which stays may move
MAX_GROWTH = 0.01  # of the largest kinetic energy, that a step may add in the run
MAX_NAMES = 4  # in a sentence
GROWS_STILL = f"and grows by more than {100.0 * MAX_GROWTH:g} % at all smaller ones that were tried"


@dataclass(frozen=True)
class ModelMobility:
    """Degrees of freedom of a model at a closed pose, and what drives them.

    Attributes:
        joints: degrees of freedom of all joints.
        rows, rank: scalar equations of the closures, and how many are independent.
        redundant: number of equations of each closure that those before it imply.
        actuators: number of actuators that move something.
        driven: degrees of freedom that actuators can push independently.
        undriven: joints that move where all that is driven is held.
        handles: connects and welds that drag a body after a mocap body, in words; they close no loop.
        closed: whether the pose could be closed; the rank is of the open pose otherwise.
    """

    joints: int
    rows: int
    rank: int
    redundant: Mapping[str, int]
    actuators: int
    driven: int
    undriven: tuple[str, ...]
    handles: str = ""
    closed: bool = True

    @property
    def freedom(self) -> int:
        """Degrees of freedom that the closures leave."""
        return self.joints - self.rank

    @property
    def is_stuck(self) -> bool:
        """True if the closures leave joints that nothing can move."""
        return self.joints > 0 and self.freedom == 0

    @property
    def words(self) -> str:
        """The mobility and what drives it, in a sentence."""
        return "; ".join(self._clauses())

    def _clauses(self) -> Iterator[str]:
        """Yield the clauses of the sentence."""
        if not self.joints:
            yield "nothing: it has no joint"
            return
        many = "degree of freedom" if self.freedom == 1 else "degrees of freedom"
        of = (
            f" ({self.joints} of the joints less {self.rank} of {self.rows} equations of closures)" if self.rows else ""
        )
        driven = f"{self.driven} driven by {self.actuators} actuator{'s' if self.actuators != 1 else ''}"
        if not self.actuators:
            driven = "no actuator drives it" if self.freedom == 1 else "no actuator drives them"
        elif self.driven == self.freedom:
            driven = f"driven by {self.actuators} actuator{'s' if self.actuators != 1 else ''}"
        yield f"{self.freedom} {many}{of}, {driven}" if self.freedom else f"nothing: no degree of freedom is left{of}"
        if self.actuators and self.undriven:
            yield f"{self.freedom - self.driven} undriven: {list_names(self.undriven, MAX_NAMES)}"
        if self.redundant:
            spare = list_names((f"{number} of {name}" for name, number in self.redundant.items()), MAX_NAMES)
            yield f"redundant equations: {spare}"
        if self.handles:
            yield self.handles
        if not self.closed:
            yield "counted at a pose that is not closed"


@dataclass(frozen=True)
class KeyframeHold:
    """Motion of a model that starts at a keyframe with the keyframe's controls.

    Attributes:
        seconds: length of the run [s].
        commanded: whether the keyframe has a control other than 0.
        moved: largest distance of a body from where the keyframe has it, at the end [m].
        share: that distance over the model's extent.
        joint, turned, unit: joint that moved most, by how much [rad or m]; empty of a model without hinges and slides.
        pulled: servos that are told to go elsewhere than where the keyframe has them.
        broke: why the run broke off; empty if it did not.
    """

    name: str
    seconds: float
    commanded: bool
    moved: float
    share: float
    joint: str
    turned: float
    unit: str
    pulled: tuple[str, ...]
    broke: str

    @property
    def stays(self) -> bool:
        """True if the model stays at the keyframe."""
        return not self.broke and self.share <= STAYS

    @property
    def words(self) -> str:
        """Say whether the model stays at the keyframe, or how far and why it moves."""
        control = "its controls" if self.commanded else "all controls 0"
        if self.broke:
            return f"keyframe {self.name} with {control}: {self.broke}"
        within = f"within {measured_text(1e3 * self.moved)} mm"
        if self.stays:
            return f"keyframe {self.name} stays with {control} ({within} after {quantity(self.seconds, 2)} s)"
        turned = f" ({self.joint} by {shown_value(abs(self.turned), self.unit)})" if self.joint else ""
        why = f": {', '.join(self.pulled[:3])} {'is' if len(self.pulled) == 1 else 'are'} told to go elsewhere"
        off = f"is {measured_text(1e3 * self.moved)} mm{turned} away after {quantity(self.seconds, 2)} s"
        return f"keyframe {self.name} does not stay: with {control} it {off}{why if self.pulled else ''}"


@dataclass(frozen=True)
class FreeEnergy:
    """Energy of a free swing, without actuators, contacts, limits, damping and dry friction.

    Attributes:
        step: time step of the model [s], and `integrator` its name.
        seconds: length of the run [s].
        growth: energy gained (or lost, below 0) over the largest kinetic energy; None where the run broke off.
        broke: why it broke off; empty if it did not.
        steady_step: largest step [s] tried at which it gains at most `MAX_GROWTH`; None if none does.
        rk4: the same share with RK4 at the model's own step; None where it was not tried or broke off.
        pushed: whether it was given rates, as nothing else moves it.
        damped: whether the model has dampers, dry friction or damped servos, which take energy out of its own runs.
    """

    step: float
    integrator: str
    seconds: float
    growth: float | None
    broke: str = ""
    steady_step: float | None = None
    rk4: float | None = None
    pushed: bool = False
    damped: bool = False

    @property
    def grows(self) -> bool:
        """True if the step adds energy to the swing."""
        return self.growth is None or self.growth > MAX_GROWTH

    @property
    def words(self) -> str:
        """Say by how much the energy of a free swing changes, and at which step it stops growing."""
        begin = f"swinging freely for {quantity(self.seconds, 2)} s without loads"
        if not self.grows:
            change = "loses" if self.growth is not None and self.growth < 0.0 else "gains"
            return f"{begin} its energy {change} {measured_text(100.0 * abs(self.growth or 0.0))} %"
        grown = f"its energy grows by {measured_text(100.0 * (self.growth or 0.0))} %"
        grown = grown if self.growth is not None else f"it breaks off: {self.broke}"
        own = f"{quantity(1e3 * self.step, 3)} ms"
        less = f"not at {quantity(1e3 * self.steady_step, 3)} ms" if self.steady_step else GROWS_STILL
        change = "" if self.rk4 is None else f"{measured_text(100.0 * abs(self.rk4))} %"
        rk4 = change and f"; with RK4 at {own} its energy changes by {change}"
        return f"{begin} {grown} at its step of {own} ({self.integrator}), {less}{rk4}"


@dataclass(frozen=True)
class LawResponse:
    """The motion of an actuator whose control follows a law, and the force that a law needs.

    Attributes:
        name, law: what is driven, an actuator or a joint, and its law, as typed.
        drives: what the actuator acts on, in words; the joint.
        unit: rad or m, or their rates where the control is a speed.
        seconds: length of the run [s]; 0 where none was made.
        error, end_error: largest difference from the law in what is compared, and the last one [unit].
        size: range of the law [unit].
        lag: time by which the motion lags behind the law [s].
        gain: amplitude over the law's, of a sine; None of others.
        peak: largest force of the actuator [N or N m, before its gear].
        needed: largest force that the law needs at the joint [N or N m]; None where loops carry a part of it.
        available: what the actuators of the joint give together [N or N m]; None without a limit, or without one.
        broke: why the run broke off.
        follows: whether a control followed the law.
    """

    name: str
    law: str
    drives: str
    unit: str
    seconds: float = 0.0
    error: float = 0.0
    end_error: float = 0.0
    size: float = 0.0
    lag: float = 0.0
    gain: float | None = None
    peak: float = 0.0
    needed: float | None = None
    available: float | None = None
    broke: str = ""
    follows: bool = True

    @property
    def is_too_weak(self) -> bool:
        """True if the law needs more force than the actuators give."""
        return self.needed is not None and self.available is not None and self.needed > self.available

    @property
    def words(self) -> str:
        """The response in words."""
        return f"{self.name} = {self.law}: {', '.join(self._clauses())}"

    def _clauses(self) -> Iterator[str]:
        force = FORCE_UNITS[self.unit.removesuffix("/s")]
        if self.broke:
            yield f"its run ends: {self.broke}"
        elif self.follows:
            yield f"{self.drives} follows within {shown_value(self.error, self.unit)}"
            yield f"{percent_text(self.error / max(self.size, 1e-300))} of the law's range"
            yield f"lags by {quantity(1e3 * self.lag, 2)} ms"
            if self.gain is not None:
                yield f"with {measured_text(self.gain)} of its amplitude"
            yield f"peak {measured_text(self.peak)} {force}"
        if self.needed is not None:
            of = "no actuator drives it" if not self.follows and self.available is None else ""
            given = f"its actuator gives {measured_text(self.available)}" if self.available is not None else of
            yield f"the law needs up to {measured_text(self.needed)} {force}{f', {given}' if given else ''}"
