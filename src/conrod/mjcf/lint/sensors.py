"""What a model carries on purpose: sensors that are read, geoms that are seen. Their cost, and no finding.

Sensors that tell of an instant that is over.
"""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.edits import Edit, Remove, SetAttribute
from conrod.mjcf.lint.finding import Finding, Harm, Note
from conrod.mjcf.lint.rule import Rule
from conrod.mjcf.lint.touching import may_collide
from conrod.own.models.loading import listed, name_or_number
from conrod.studies.frame.paired_timing import PairedCost


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


# Of the largest value that the sensor gives in the run; the same sums in the same order give the same last digit.
SAME_VALUE = 1e-12


def judge(bench: Bench) -> Iterator[Finding]:
    """Each sensor in two runs: as it is, and read at once in every step."""
    model = bench.model
    held = [i for i in range(model.nsensor) if model.sensor_history[i, 0] and bench.document.can_edit("sensor", i)]
    if not held:
        return
    edits = {index: at_once(index, name_or_number(model, "sensor", index)) for index in held}
    all_edits = tuple(edit for index in held for edit in edits[index])
    prompt = bench.run_of(all_edits)
    late = {}
    for index in held:
        values = slice(model.sensor_adr[index], model.sensor_adr[index] + model.sensor_dim[index])
        length = min(len(prompt.sensors), len(bench.run.sensors))
        now, then = prompt.sensors[:length, values], bench.run.sensors[:length, values]
        largest = float(np.abs(now).max(initial=0.0))
        if largest > 0.0 and float(np.abs(now - then).max()) > SAME_VALUE * largest:
            late[index] = float(np.abs(now - then).max()) / largest
    if not late:
        return
    names = tuple(name_or_number(model, "sensor", index) for index in late)
    worst = max(late, key=lambda index: late[index])
    step, delay = float(model.opt.timestep), float(model.sensor_delay[worst])
    chosen: tuple[Edit, ...] = tuple(edit for index in late for edit in edits[index])
    yield Finding(
        rule=RULE.name,
        subjects=names,
        what=f"{len(late)} sensors tell of an instant that is over: {listed(names)}",
        harm=Harm.LATENT,
        evidence=(
            ("delay [s]", delay),
            ("delay in steps", round(delay / step, 3)),
            ("period of new values [s]", float(model.sensor_interval[worst, 0])),
            ("largest difference over the largest value", late[worst]),
        ),
        why="values that are paired with the state of the same step are off by what happens in the delay",
        fix="no delay, unless the delay of a real sensor is meant: then pair its values with the time less the delay",
        edits=chosen,
        change=bench.change(chosen),
        cost=bench.cost(chosen),
    )


def at_once(index: int, name: str) -> tuple[Edit, ...]:
    """A sensor without delay and history."""
    values = {"delay": "0", "interval": "0 0", "nsample": "0"}
    return tuple(SetAttribute("sensor", index, name, attribute, value) for attribute, value in values.items())


RULE = Rule("late-sensor", judge)
