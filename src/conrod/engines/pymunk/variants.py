"""pymunk settings that studies vary: a sweep's grid, single parameters, lines to paste. Does not import the engine."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from conrod.engines.engine import Machine, recognise_preset, with_fields
from conrod.engines.pymunk import PYMUNK_PRESETS, STOCK_BIAS, PymunkSettings
from conrod.engines.variants import Grid, Knobs, SettingsRule, knob_combinations, knob_rules

# Share of an error left after a second: Chipmunk's default, its equivalent for a machine ten times as fast, none.
BIASES = {"stock": STOCK_BIAS, "stock^10": STOCK_BIAS**10, "0": 0.0}
AS_TUNED = "tuned"  # value of a knob: as the preset's rule sets it

# Usual values of the knobs of a machine whose links are held by joints, and of one with a cam.
JOINT_KNOBS: Knobs = {"iterations": "10", "error_bias": "stock"}
CONTACT_KNOBS: Knobs = {"slop": AS_TUNED, "bias": "0", "iterations": AS_TUNED, "vertices": 4000}

# Values that differ from the usual ones: in the presets and with fewer vertices; then all values of a full grid.
JOINT_BASES: tuple[Knobs, ...] = ({}, {"iterations": AS_TUNED, "error_bias": "0"})
JOINT_GRID: Knobs = {"iterations": ("1", "3", "10", "30", "100", AS_TUNED), "error_bias": BIASES}
CONTACT_BASES: tuple[Knobs, ...] = (
    {"slop": "stock", "bias": "stock", "iterations": "10"},
    {},
    {"vertices": 250},
    {"vertices": 1000},
)
CONTACT_GRID: Knobs = {"slop": ("stock", "0", AS_TUNED), "bias": ("stock", "0"), "iterations": ("1", "10", AS_TUNED)}
SLOP_TEXTS = {AS_TUNED: "slop half a fall a step", "stock": "slop 0.1 m", "0": "slop 0"}


def rules(machine: Machine, grid: Grid) -> tuple[SettingsRule, ...]:
    """All rules of a grid for a machine, without duplicates."""
    contact = bool(machine.kinematics.mechanism.cam_contacts)
    usual, bases, others = (
        (CONTACT_KNOBS, CONTACT_BASES, CONTACT_GRID) if contact else (JOINT_KNOBS, JOINT_BASES, JOINT_GRID)
    )
    return knob_rules(
        usual, bases if grid == "coarse" else (*bases, *knob_combinations(**others)), _rule_name, _settings_from_knobs
    )


def _settings_from_knobs(knobs: Knobs, machine: Machine, steps_per_revolution: int) -> PymunkSettings:
    """Settings of given knobs, with all other fields of the stock preset."""
    tuned, stock = (preset(machine, steps_per_revolution) for preset in (PymunkSettings.tuned, PymunkSettings.stock))
    count = tuned.iterations if knobs["iterations"] == AS_TUNED else int(knobs["iterations"])
    own: dict[str, Any] = {"iterations": count}
    if "slop" in knobs:
        bias = BIASES[knobs["bias"]]
        slop = {AS_TUNED: tuned.collision_slop, "stock": stock.collision_slop, "0": 0.0}[knobs["slop"]]
        own |= {"error_bias": bias, "collision_bias": bias, "collision_slop": slop, "cam_vertices": knobs["vertices"]}
    else:
        own["error_bias"] = BIASES[knobs["error_bias"]]
    # Contact fields are unused on a machine without contact, and must not keep it from being recognised as a preset.
    if knobs.get("error_bias") == "0":
        own |= {"collision_bias": 0.0, "collision_slop": tuned.collision_slop}
    return recognise_preset(replace(stock, preset="custom", **own), PYMUNK_PRESETS, machine)


def _rule_name(knobs: Knobs, usual: Knobs) -> str:
    """Name a rule by its knobs."""
    counted = "iterations as tuned" if knobs["iterations"] == AS_TUNED else f"{knobs['iterations']} iterations"
    if "slop" not in knobs:
        return f"error_bias {knobs['error_bias']}, {counted}"
    words = [SLOP_TEXTS[knobs["slop"]], f"collision_bias {knobs['bias']}", counted]
    return ", ".join(words + ([f"{knobs['vertices']} vertices"] if knobs["vertices"] != usual["vertices"] else []))


def with_time_constant(machine: Machine, settings: PymunkSettings, steps: float) -> PymunkSettings:
    """Set the time constant of joints or contacts to a number of steps.

    The share of an error left after a step is exp(-1 / steps); pymunk takes the share left after a second. With more
    than 745 time constants per second that underflows to zero, and a step corrects the whole error.
    """
    bias = math.exp(-1.0 / (steps * settings.timestep))
    if machine.kinematics.mechanism.cam_contacts:
        return with_fields(settings, collision_bias=bias)
    return with_fields(settings, error_bias=bias)


def with_regularisation(machine: Machine, settings: PymunkSettings, share: float) -> None:
    """Return None, as pymunk regularises neither joints nor contacts; a contact's slop is an overlap."""
    return


def paste(machine: Machine, settings: PymunkSettings) -> str:
    """Settings as Python statements on a `pymunk.Space` named space."""
    lines = [f"space.iterations = {settings.iterations}"]
    if machine.kinematics.mechanism.cam_contacts:
        lines += [
            f"space.collision_bias = {settings.collision_bias!r}",
            f"space.collision_slop = {settings.collision_slop!r}",
        ]
    lines += ["for constraint in space.constraints:", f"    constraint.error_bias = {settings.error_bias!r}"]
    return "\n".join([*lines, f"space.step({settings.timestep!r})"])
