"""pymunk's settings varied: by a grid, one at a time, and as lines of a user's own program. Imports no engine."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Any

from conrod.engines.engine import Machine, as_preset, with_fields
from conrod.engines.massless_rod import BODY, DISTANCE_JOINT, ROD_FORMS
from conrod.engines.pymunk.settings import PRESETS, STOCK_BIAS, PymunkSettings
from conrod.engines.variants import Grid, Rule

# Share of an error that is left after a second: Chipmunk's default, the same for a machine ten times as fast, none.
BIASES = {"stock": STOCK_BIAS, "stock^10": STOCK_BIAS**10, "0": 0.0}
STOCK_SLOP = 0.1  # [m]
AS_TUNED = "tuned"  # a knob that stands where the preset's rule puts it


@dataclass(frozen=True)
class JointKnobs:
    """Knobs of a machine whose links are held by joints."""

    iterations: str = "10"
    error_bias: str = "stock"
    rod: str = BODY


@dataclass(frozen=True)
class ContactKnobs:
    """Knobs of a machine with a cam that its follower is kept on by contact."""

    slop: str = AS_TUNED  # overlap that a contact may keep
    bias: str = "0"
    iterations: str = AS_TUNED
    vertices: int = 4000


def rules(machine: Machine, grid: Grid) -> tuple[Rule, ...]:
    """All rules of a grid, without repetition."""
    if machine.kinematics.mechanism.cam_contacts:
        return tuple(_contact_rule(knobs) for knobs in dict.fromkeys(_contact_grid(grid)))
    return tuple(_joint_rule(knobs) for knobs in dict.fromkeys(_joint_grid(grid)))


def _joint_rule(knobs: JointKnobs) -> Rule:
    def settings(machine: Machine, steps_per_revolution: int) -> PymunkSettings:
        fields = {"error_bias": BIASES[knobs.error_bias], "rod": knobs.rod}
        # What concerns contact has no part in a machine without one, and must not keep it from being a preset.
        if knobs.error_bias == "0":
            slop = PymunkSettings.tuned(machine, steps_per_revolution).collision_slop
            fields |= {"collision_bias": 0.0, "collision_slop": slop}
        return _settings(machine, steps_per_revolution, knobs.iterations, fields)

    words = [f"error_bias {knobs.error_bias}", _iterations(knobs.iterations)]
    name = ", ".join(words + ([f"rod as {knobs.rod}"] if knobs.rod != BODY else []))
    # Without a bias a joint is mended whole at every step, so its softness is the step's; a bias is per second.
    return Rule(name, settings)


def _contact_rule(knobs: ContactKnobs) -> Rule:
    def settings(machine: Machine, steps_per_revolution: int) -> PymunkSettings:
        tuned = PymunkSettings.tuned(machine, steps_per_revolution).collision_slop
        slop, bias = {AS_TUNED: tuned, "stock": STOCK_SLOP, "0": 0.0}[knobs.slop], BIASES[knobs.bias]
        fields = {"error_bias": bias, "collision_bias": bias, "collision_slop": slop, "cam_vertices": knobs.vertices}
        return _settings(machine, steps_per_revolution, knobs.iterations, fields)

    slop = {AS_TUNED: "slop half a fall a step", "stock": "slop 0.1 m", "0": "slop 0"}[knobs.slop]
    words = [slop, f"collision_bias {knobs.bias}", _iterations(knobs.iterations)]
    name = ", ".join(words + ([f"{knobs.vertices} vertices"] if knobs.vertices != ContactKnobs.vertices else []))
    return Rule(name, settings)


def _settings(machine: Machine, steps_per_revolution: int, iterations: str, fields: dict[str, Any]) -> PymunkSettings:
    """Settings with some fields; all that is not a knob is that of the stock preset."""
    tuned = PymunkSettings.tuned(machine, steps_per_revolution).iterations
    count = tuned if iterations == AS_TUNED else int(iterations)
    stock = PymunkSettings.stock(machine, steps_per_revolution)
    return as_preset(replace(stock, preset="custom", iterations=count, **fields), PRESETS, machine)


def _joint_grid(grid: Grid) -> Sequence[JointKnobs]:
    presets = (JointKnobs(), JointKnobs(AS_TUNED, "0"))
    if grid == "coarse":
        return presets
    counts = ("1", "3", "10", "30", "100", AS_TUNED)
    found = [JointKnobs(*knobs) for knobs in product(counts, BIASES, ROD_FORMS)]
    return [*presets, *found]


def _contact_grid(grid: Grid) -> Sequence[ContactKnobs]:
    tuned = ContactKnobs()
    presets = (ContactKnobs("stock", "stock", "10"), tuned, *(replace(tuned, vertices=n) for n in (250, 1000)))
    if grid == "coarse":
        return presets
    counts = ("1", "10", AS_TUNED)
    found = [ContactKnobs(*knobs) for knobs in product(("stock", "0", AS_TUNED), ("stock", "0"), counts)]
    return [*presets, *found]


def _iterations(text: str) -> str:
    return "iterations as tuned" if text == AS_TUNED else f"{text} iterations"


def stabilised(machine: Machine, settings: PymunkSettings, steps: float) -> PymunkSettings:
    """The share left after a step is e^(-1 / steps), which the engine wants as that left after a second.

    That one is no number any more where the second has very many time constants (745): it becomes zero, and a step
    mends all.
    """
    bias = math.exp(-1.0 / (steps * settings.timestep))
    if machine.kinematics.mechanism.cam_contacts:
        return with_fields(settings, collision_bias=bias)
    return with_fields(settings, error_bias=bias)


def regularised(machine: Machine, settings: PymunkSettings, share: float) -> None:
    """Neither joints nor contacts have any; a contact's slop is an overlap that is left, not a softness."""
    return


def paste(machine: Machine, settings: PymunkSettings) -> str:
    """Statements on a `pymunk.Space` called space."""
    lines = [f"space.iterations = {settings.iterations}"]
    if machine.kinematics.mechanism.cam_contacts:
        lines += [
            f"space.collision_bias = {settings.collision_bias!r}",
            f"space.collision_slop = {settings.collision_slop!r}",
        ]
    lines += ["for constraint in space.constraints:", f"    constraint.error_bias = {settings.error_bias!r}"]
    if settings.rod == DISTANCE_JOINT:
        lines.append("# the connecting rod is a pymunk.PinJoint of its length, not a body")
    return "\n".join([*lines, f"space.step({settings.timestep!r})"])
