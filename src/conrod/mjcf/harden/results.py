"""Request and findings of `conrod harden`, as plain values."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from conrod.own.models.request import Controls
from conrod.runs.plain import plain
from conrod.studies.frame.paired_timing import PairedCost

SCHEMA = 1


@dataclass(frozen=True)
class Request:
    """Way in which a model is to be hardened, and the motion on which that is shown.

    Attributes:
        keyframe: name or number of the keyframe that the runs start from; None for the first, or the model's own pose.
        seconds: how long the runs are [s].
        solref: time constant of the closures [s]; "auto" for at least so many steps as RK4 needs, "keep" for the
            model's own.
        integrator: "RK4", or "keep" for the model's own.
        force: harden what seems to be soft on purpose.
        controls: inputs of actuators in place of the keyframe's, held through the runs.
        content: whether the hardened model is asked for, not only its figures.
    """

    keyframe: str | None = None
    seconds: float = 1.0
    solref: str | float = "auto"
    integrator: str = "RK4"
    force: bool = False
    content: bool = True
    controls: Controls = ()


@dataclass(frozen=True)
class Loop:
    """One measure of one closure.

    Attributes:
        name: of the equality constraint, or its number.
        kind: connect, weld, joint, tendon.
        unit: "m" or "rad".
    """

    name: str
    kind: str
    unit: str


@dataclass(frozen=True)
class Orders:
    """Values at three steps, and the order at which they shrink.

    Attributes:
        values: at the model's step, half of it and a quarter [m].
        claimed: observed order; None where the pairs do not agree.
        pairs: order from each step to the next, None where one is zero.
    """

    values: tuple[float, ...]
    claimed: float | None
    pairs: tuple[float | None, ...]


@dataclass(frozen=True)
class Touching:
    """Contacts and joint limits in a run, in the poses that were looked at.

    Attributes:
        contacts: the most that acted at once.
        penetration: deepest [m].
        limits: the most limits that were passed at once.
        excess: furthest beyond a limit [rad or m].
    """

    contacts: int
    penetration: float
    limits: int
    excess: float


@dataclass(frozen=True)
class Variant:
    """One way to run the model.

    Attributes:
        name: of the way.
        steps: that it completed at the model's own step, of those asked for.
        broke: the engine's warning that ended it; None where it completed. The rest is None then.
        openings: largest of each loop, in the order and units of the study's loops.
        opening_over_size: the largest in metres, over the model's size.
        closing: order of the largest opening, of those in metres where there are any.
        drift: largest distance of a body from where the reference has it [m], at three steps.
        energy: largest change of the energy over the kinetic energy exchanged; None where that says nothing.
        touching: contacts and limits.
        iterations: of the solver, mean over the steps that were looked at.
    """

    name: str
    steps: int
    broke: str | None = None
    openings: tuple[float, ...] | None = None
    opening_over_size: float | None = None
    closing: Orders | None = None
    drift: Orders | None = None
    energy: float | None = None
    touching: Touching | None = None
    iterations: float | None = None


@dataclass(frozen=True)
class HardenedModel:
    """Findings on one model.

    Attributes:
        refusals: why it is not hardened; empty where it is.
        warnings: what a user should know.
        size: of the model, MuJoCo's `stat.extent` [m].
        timestep, seconds: of the runs [s].
        start: what they started from.
        start_opening: largest opening of the start pose as given, by unit.
        start_closed: whether the runs start with the loops closed; where no near pose closes them, as given.
        loops: what is measured of the closures.
        factor: on the inverse weights.
        scaled: what has these weights: names of bodies, joints, tendons.
        lines: Python that does it.
        variants: as it is, weights alone, hardened.
        travel: the longest way of a body in the reference [m].
        reference_known_to: how far the two references are apart [m], or the rounding of a position where that is more;
            None where one of them broke.
        energy_without: what was left out of the copies whose energy was looked at.
        energy_note: why the energy says nothing; empty where it does.
        touching_scaled: geoms that can collide and limits that harden with the loops.
        cost: of a hardened step over one as it is; None where one of them broke.
        content: the binary model; None where none was asked for or it was refused.
    """

    path: str
    mujoco: str
    refusals: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    size: float = 0.0
    timestep: float = 0.0
    seconds: float = 0.0
    start: str = ""
    start_opening: dict[str, float] | None = None
    start_closed: bool = True
    loops: tuple[Loop, ...] = ()
    factor: float | None = None
    scaled: tuple[str, ...] = ()
    lines: str = ""
    variants: tuple[Variant, ...] = ()
    travel: float | None = None
    reference_known_to: float | None = None
    energy_without: tuple[str, ...] = ()
    energy_note: str = ""
    touching_scaled: tuple[str, ...] = ()
    cost: PairedCost | None = None
    content: bytes | None = None

    def document(self) -> dict[str, Any]:
        """All but the binary model, as values that JSON has."""
        values = plain(replace(self, content=None))
        del values["content"]
        return {"schema": SCHEMA, **values}
