"""Rules on sensors: their cost, and those whose values belong to an earlier instant."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.edits import Edit, SetAttribute
from conrod.mjcf.lint.findings import Finding, Harm, Note
from conrod.own.models.loading import listed, name_or_number

# Of the largest value that the sensor gives in the run; the same sums in the same order give the same last digit.
SAME_VALUE = 1e-12


def late_sensors(bench: Bench) -> Iterator[Finding]:
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
        subjects=names,
        what=f"{len(late)} sensors report an earlier instant: {listed(names)}",
        harm=Harm.LATENT,
        evidence={
            "delay [s]": delay,
            "delay in steps": round(delay / step, 3),
            "period of new values [s]": float(model.sensor_interval[worst, 0]),
            "largest difference over the largest value": late[worst],
        },
        fix="no delay, unless the delay of a real sensor is meant: then pair its values with the time less the delay",
        edits=chosen,
        change=bench.change(chosen),
        cost=bench.cost(chosen),
    )


def at_once(index: int, name: str) -> tuple[Edit, ...]:
    """A sensor without delay and history."""
    values = {"delay": "0", "interval": "0 0", "nsample": "0"}
    return tuple(SetAttribute("sensor", index, name, attribute, value) for attribute, value in values.items())


def sensor_cost(bench: Bench) -> Iterator[Note]:
    """Number of all sensors, and their cost together."""
    model = bench.model
    if model.nsensor:
        named = sum(bool(mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_SENSOR, i)) for i in range(model.nsensor))
        text = f"{model.nsensor} sensors, {named} of them named, {model.nsensordata} values a step"
        yield Note(text, bench.cost_of("sensor", list(range(model.nsensor))))
