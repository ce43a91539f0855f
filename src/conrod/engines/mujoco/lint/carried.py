"""What a model carries on purpose: sensors that are read, geoms that are seen. Their cost, and no finding."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.lint.bench import Bench
from conrod.engines.mujoco.lint.edits import Edit, Remove
from conrod.engines.mujoco.lint.finding import Note
from conrod.engines.mujoco.lint.rule import Rule
from conrod.engines.mujoco.lint.touching import may_collide
from conrod.engines.mujoco.user_model.loading import name_or_number
from conrod.paired_timing import PairedCost


def judge_sensors(bench: Bench) -> Iterator[Note]:
    """How many, and what they cost together."""
    model = bench.model
    if model.nsensor:
        named = sum(bool(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i)) for i in range(model.nsensor))
        text = f"{model.nsensor} sensors, {named} of them named, {model.nsensordata} values a step"
        yield Note(SENSORS.name, text, _cost_of(bench, "sensor", list(range(model.nsensor))))


def judge_seen(bench: Bench) -> Iterator[Note]:
    """Geoms that no other can collide with."""
    model = bench.model
    named = set(model.pair_geom1.tolist()) | set(model.pair_geom2.tolist())
    if int(model.opt.disableflags) & mujoco.mjtDisableBit.mjDSBL_CONTACT:
        named = set()
    seen = sorted(set(range(model.ngeom)) - may_collide(model) - named)
    if seen:
        text = f"{len(seen)} of {model.ngeom} geoms cannot collide with anything"
        yield Note(SEEN.name, text, _cost_of(bench, "geom", seen))


def _cost_of(bench: Bench, kind: str, indices: list[int]) -> PairedCost | None:
    """What elements cost together; None where they cannot be left out without making another machine."""
    if bench.run.broke or not all(bench.document.can_edit(kind, index) for index in indices):
        return None
    edits: tuple[Edit, ...] = tuple(Remove(kind, i, name_or_number(bench.model, kind, i)) for i in indices)
    try:
        without = bench.copy(edits)
    except ValueError:
        return None
    if not np.array_equal(without.body_inertia, bench.model.body_inertia) or bench.change(edits) > 0.0:
        return None
    return bench.cost(edits)


SENSORS = Rule("sensors", judge_sensors)
SEEN = Rule("geoms-seen", judge_seen)
