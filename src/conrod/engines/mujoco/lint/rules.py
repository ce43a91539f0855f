"""All rules. A new one is a module that has it and a line here."""

from __future__ import annotations

from conrod.engines.mujoco.lint import (
    carried,
    delayed,
    freedoms,
    gravity,
    inertias,
    redundant,
    resetting,
    soft,
    stability,
    starting,
    touching,
    unsolved,
)
from conrod.engines.mujoco.lint.rule import Rule

RULES: tuple[Rule, ...] = (
    stability.RULE,
    unsolved.RULE,
    soft.RULE,
    starting.POSE,
    starting.SPEEDS,
    touching.JOINED,
    touching.APART,
    freedoms.RULE,
    redundant.RULE,
    gravity.RULE,
    inertias.RULE,
    delayed.RULE,
    resetting.RULE,
    carried.SENSORS,
    carried.SEEN,
)
