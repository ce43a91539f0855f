"""Rules on stepping: the step, the solver, what MuJoCo does when a run diverges, and sensors."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco import older
from conrod.exact.motion import Array
from conrod.mjcf.lint.bench import Bench, rule
from conrod.mjcf.lint.findings import Change, Edit, Finding, Harm, SetOption
from conrod.mjcf.runs import data_at
from conrod.own.models.loading import listed, name_or_number

# -- the step --------------------------------------------------------------------------------------------------------

HALVINGS = 6
# A run in which something gets this many times farther, or opens this many times wider, than in one with finer steps
# is not a rough picture of the same motion.
OUT_OF_HAND = 10.0
OPEN = 0.1  # of the machine's size


@rule("the motion is the integrator's, not the machine's", needs_motion=False)
def step_too_long(bench: Bench) -> Iterator[Finding]:
    """A step above the longest stable one."""
    longest, step = longest_stable(bench), bench.step
    if longest == step:
        return
    found = Finding(
        what="the model does not run, at no step that was tried",
        harm=Harm.WRONG,
        evidence={
            "step [s]": step,
            "longest stable step [s]": longest or f"none down to {step / 2**HALVINGS:.4g}",
            "steps made of those asked for": f"{bench.run.steps} of {bench.steps}",
            "warnings": ", ".join(bench.run.warnings) or "none",
        },
        fix="look at the start pose, overlapping geoms, gains, and masses next to zero",
    )
    if longest:
        what = f"the step of {step:.4g} s is longer than the longest at which the model runs, {longest:.4g} s"
        fix = f'timestep="{longest:.4g}" or less: half of it leaves a margin'
        option = SetOption(("option",), "timestep", f"{0.5 * longest:.4g}")
        found = replace(found, what=what, fix=fix, edits=(option,))
    yield found


def longest_stable(bench: Bench) -> float | None:
    """The longest of the model's step, half of it, .. that is stable [s]; None where none is."""
    trial = bench
    for _ in range(HALVINGS):
        finer = trial.with_step(0.5 * trial.step)
        if stable(trial, finer):
            return trial.step
        trial = finer
    return None


def stable(bench: Bench, finer: Bench) -> bool:
    """Return True where a run holds together, as one with finer steps over the same time does."""
    if bench.run.broke or finer.run.broke:
        return False
    if bench.run.travel > OUT_OF_HAND * max(finer.run.travel, 1e-3 * finer.size):
        return False
    wide, fine = (float(one.openings.max(initial=0.0)) for one in (bench, finer))
    return wide <= max(OPEN * finer.size, OUT_OF_HAND * fine)


# -- the solver ------------------------------------------------------------------------------------------------------

# Of what the constraints have to do, in acceleration. Newton at MuJoCo's own tolerance of 1e-8 leaves 1e-6 or less.
LEFT = 1e-3
# A solver that fails at one pose has met a hard one; at one in twenty it is set wrongly.
OFTEN = 0.05
# Of the travel: ten times the tolerance that MuJoCo solves to by default.
MOVED = 1e-7
ITERATIONS = 100  # MuJoCo's default; Newton takes two or three
LOOKS = 40


@rule(
    "constraints get a part of their forces, or those of an earlier step, without a warning: MuJoCo scales its "
    "tolerance by the mean inertia, so that a large armature makes it void",
)
def solver_stops_early(bench: Bench) -> Iterator[Finding]:
    """A solver tolerance that an armature makes void; too few iterations."""
    options = bench.model.opt
    edits = tuple(
        SetOption(("option",), name, value)
        for name, value, is_wrong in (
            ("tolerance", "0", options.tolerance > 0.0),
            ("solver", "Newton", options.solver != mujoco.mjtSolver.mjSOL_NEWTON),
            ("iterations", str(ITERATIONS), options.iterations < ITERATIONS),
        )
        if is_wrong
    )
    if not edits:
        return
    states, solved = bench.run.states, bench.edited(edits).model
    left = np.array([_left(bench.model, solved, state) for state in states[:: max(1, len(states) // LOOKS)]])
    change = bench.change(edits) if len(left) and np.mean(left > LEFT) >= OFTEN else 0.0
    if change <= MOVED:
        return
    # Of the file: a drive brings an armature of its own, and a tolerance that makes up for it.
    written = bench.document.model
    yield Finding(
        what="the solver stops before it is done, perhaps before its first iteration",
        harm=Harm.WRONG,
        evidence={
            "tolerance": float(written.opt.tolerance),
            "poses with work left": f"{int((left > LEFT).sum())} of {len(left)}",
            "largest share of the work left": float(left.max()),
            "mean inertia that the tolerance is scaled by": float(written.stat.meaninertia),
        },
        fix=" ".join(edit.words for edit in edits),
        edits=edits,
        # The model as it is written, solved: nothing of the machine changes.
        safe=True,
        change=change,
    )


def _left(model: mujoco.MjModel, solved: mujoco.MjModel, state: Array) -> float:
    """Share of the constraints' work that is left at a state."""
    own, exact = data_at(model, state), data_at(solved, state)
    mujoco.mj_forward(model, own)
    mujoco.mj_forward(solved, exact)
    if not exact.nefc or own.nefc != exact.nefc:
        return 0.0
    rest, work = np.empty(own.nefc), np.empty(own.nefc)
    mujoco.mj_mulJacVec(model, own, rest, own.qacc - exact.qacc)
    mujoco.mj_mulJacVec(model, own, work, exact.qacc - exact.qacc_smooth)
    largest = float(np.abs(work).max())
    return float(np.abs(rest).max()) / largest if largest > 0.0 else 0.0


# -- a model that starts again by itself -----------------------------------------------------------------------------

NO_RESET = (SetOption(("option", "flag"), "autoreset", "disable"),)


@rule(
    "a run that diverged is finite, smooth and wrong: the machine is back in its first pose, and one warning is the "
    "only sign of it",
    needs_motion=False,
)
def silent_reset(bench: Bench) -> Iterator[Finding]:
    """Autoreset on."""
    if int(bench.model.opt.disableflags) & older.flag("AUTORESET"):
        return
    yield Finding(
        what="when its numbers go wrong the model starts again by itself, and the run goes on",
        harm=Harm.WRONG if bench.run.broke else Harm.HIDES,
        evidence={
            "runs at twice its step": "yes" if stable(bench.with_step(2.0 * bench.step), bench) else "no",
        },
        fix="autoreset off, and look at the warnings or at the numbers",
        edits=NO_RESET,
        safe=True,
        change=bench.change(NO_RESET) if not bench.run.broke else None,
    )


# -- sensors ---------------------------------------------------------------------------------------------------------

# Of the largest value that the sensor gives in the run; the same sums in the same order give the same last digit.
SAME_VALUE = 1e-12
AT_ONCE = {"delay": "0", "interval": "0 0", "nsample": "0"}


@rule("values that are paired with the state of the same step are off by what happens in the delay")
def late_sensor(bench: Bench) -> Iterator[Finding]:
    """A delay or an interval set on a sensor."""
    model = bench.model
    delays = getattr(model, "sensor_history", np.zeros((model.nsensor, 1)))  # older releases of MuJoCo have none
    held = [i for i in range(model.nsensor) if delays[i, 0] and bench.document.can_edit("sensor", i)]
    if not held:
        return
    prompt, late = bench.edited(_read_at_once(model, held)).run.sensors, dict[int, float]()
    for index in held:
        values = slice(model.sensor_adr[index], model.sensor_adr[index] + model.sensor_dim[index])
        length = min(len(prompt), len(bench.run.sensors))
        now, then = prompt[:length, values], bench.run.sensors[:length, values]
        largest = float(np.abs(now).max(initial=0.0))
        if largest > 0.0 and float(np.abs(now - then).max()) > SAME_VALUE * largest:
            late[index] = float(np.abs(now - then).max()) / largest
    if not late:
        return
    names = tuple(name_or_number(model, "sensor", index) for index in late)
    worst = max(late, key=lambda index: late[index])
    delay, edits = float(model.sensor_delay[worst]), _read_at_once(model, list(late))
    yield Finding(
        subjects=names,
        what=f"{len(late)} sensors report an earlier instant: {listed(names)}",
        harm=Harm.LATENT,
        evidence={
            "delay [s]": delay,
            "period of new values [s]": float(model.sensor_interval[worst, 0]),
            "largest difference over the largest value": late[worst],
        },
        fix="no delay, unless the delay of a real sensor is meant: then pair its values with the time less the delay",
        edits=edits,
        change=bench.change(edits),
    )


def _read_at_once(model: mujoco.MjModel, sensors: list[int]) -> tuple[Edit, ...]:
    """Sensors without delay and history."""
    return tuple(
        Change("sensor", index, name_or_number(model, "sensor", index), attribute, value)
        for index in sensors
        for attribute, value in AT_ONCE.items()
    )
