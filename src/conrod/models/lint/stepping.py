"""Rules on stepping: the step, the solver, and what MuJoCo does when a run diverges."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import mujoco
import numpy as np

from conrod.engines.mujoco import compat
from conrod.exact.motion import Array
from conrod.mjcf.equalities import handle_indices
from conrod.mjcf.runs import data_at_state
from conrod.models.lint.bench import UNCHANGED_SHARE, LintBench
from conrod.models.lint.findings import Finding, Severity

# -- the step --------------------------------------------------------------------------------------------------------

MAX_HALVINGS = 6
# A run in which something gets this many times farther, or opens this many times wider, than in one with finer steps
# is not a rough picture of the same motion.
MAX_GROWTH = 10.0
MAX_VIOLATION = 0.1  # of the machine's size


def step_too_long(bench: LintBench) -> Iterator[Finding]:
    """A step above the longest stable one."""
    longest, step = longest_stable(bench), bench.step
    if longest is bench:
        return
    found = Finding(
        what="the model does not run, at no step that was tried",
        severity=Severity.ERROR,
        evidence={
            "step [s]": step,
            "longest stable step [s]": longest.step if longest else f"none down to {step / 2**MAX_HALVINGS:.4g}",
            "steps made of those asked for": f"{bench.run.steps} of {bench.steps}",
            "the run ended": f"by {bench.run.broke}" if bench.run.broke else "at its last step",
        },
        why="the motion is the integrator's, not the machine's",
        fix="look at the start pose, overlapping geoms, gains, and masses next to zero",
    )
    if longest:
        what = f"the step of {step:.4g} s is longer than the longest at which the model runs, {longest.step:.4g} s"
        fix = f'timestep="{longest.step:.4g}" or less: half of it leaves a margin'
        found = replace(found, what=what, fix=fix, edits=(f'<option timestep="{0.5 * longest.step:.4g}"/>',))
    yield found


def longest_stable(bench: LintBench) -> LintBench | None:
    """The model with the longest stable step of h, h/2, h/4, .., from its step h; None if none is stable."""
    trial = bench
    for _ in range(MAX_HALVINGS):
        if is_stable(trial, trial.finer):
            return trial
        trial = trial.finer
    return None


def is_stable(bench: LintBench, finer: LintBench) -> bool:
    """True if a run holds together as one with finer steps does."""
    if bench.run.broke or finer.run.broke:
        return False
    if bench.run.travel > MAX_GROWTH * max(finer.run.travel, 1e-3 * finer.size):
        return False
    wide, fine = (float(one.constraint_violations.max(initial=0.0)) for one in (bench, finer))
    return wide <= max(MAX_VIOLATION * finer.size, MAX_GROWTH * fine)


# -- the solver ------------------------------------------------------------------------------------------------------

# Of what the constraints have to do, in acceleration. Newton at MuJoCo's own tolerance of 1e-8 leaves 1e-6 or less.
MAX_UNSOLVED_SHARE = 1e-3
# A solver that fails at one pose has met a hard one; at one in twenty it is set wrongly.
MIN_POSE_SHARE = 0.05
# Of the travel: ten times the tolerance that MuJoCo solves to by default.
MIN_CHANGE = 1e-7
MIN_ITERATIONS = 100  # MuJoCo's default; Newton takes two or three
CHECKED_STATES = 40


def solver_stops_early(bench: LintBench) -> Iterator[Finding]:
    """A solver tolerance that an armature makes void; too few iterations."""
    options = bench.model.opt
    wrong = {
        'tolerance="0"': options.tolerance > 0.0,
        'solver="Newton"': options.solver != mujoco.mjtSolver.mjSOL_NEWTON,
        f'iterations="{MIN_ITERATIONS}"': options.iterations < MIN_ITERATIONS,
    }
    if not any(wrong.values()):
        return
    edit = f"<option {' '.join(text for text, is_wrong in wrong.items() if is_wrong)}/>"
    states, solved = bench.run.states, bench.with_edits((edit,))
    left = np.array(
        [
            _unsolved_share(bench.model, solved.model, state)
            for state in states[:: max(1, len(states) // CHECKED_STATES)]
        ]
    )
    change = bench.change_to(solved.run) if len(left) and np.mean(left > MAX_UNSOLVED_SHARE) >= MIN_POSE_SHARE else 0.0
    if change <= MIN_CHANGE:
        return
    yield Finding(
        what="the solver stops before it is done, perhaps before its first iteration",
        severity=Severity.ERROR,
        evidence={
            "tolerance": float(options.tolerance),
            "poses with work left": f"{int((left > MAX_UNSOLVED_SHARE).sum())} of {len(left)}",
            "largest share of the work left": float(left.max()),
            "mean inertia that the tolerance is scaled by": float(bench.model.stat.meaninertia),
        },
        why="constraints get a part of their forces, or those of an earlier step, without a warning: MuJoCo scales its "
        "tolerance by the mean inertia, so that a large armature makes it void",
        fix="a solver that goes on until it is done",
        edits=(edit,),
        # The model as it is written, solved: nothing of the machine changes.
        safe=True,
        change=change,
    )


def _unsolved_share(model: mujoco.MjModel, solved: mujoco.MjModel, state: Array) -> float:
    """Share of the constraints' work that the solver leaves undone at a state."""
    own, exact = data_at_state(model, state), data_at_state(solved, state)
    mujoco.mj_forward(model, own)
    mujoco.mj_forward(solved, exact)
    if not exact.nefc or own.nefc != exact.nefc:
        return 0.0
    rest, work = np.empty(own.nefc), np.empty(own.nefc)
    mujoco.mj_mulJacVec(model, own, rest, own.qacc - exact.qacc)
    mujoco.mj_mulJacVec(model, own, work, exact.qacc - exact.qacc_smooth)
    largest = float(np.abs(work).max())
    return float(np.abs(rest).max()) / largest if largest > 0.0 else 0.0


# -- a run in which nothing happens ------------------------------------------------------------------------------------


def nothing_moves(bench: LintBench) -> Iterator[Finding]:
    """A run without motion, which shows nothing."""
    run = bench.run
    if run.broke or run.travel > UNCHANGED_SHARE * bench.size:
        return
    ways = ["--ctrl NAME=VALUE commands a motion"] if bench.model.nu else []
    ways.append("--keyframe KEY starts from a keyframe with rates (qvel)")
    # A drive needs a loop that follows, or an actuator.
    if bench.model.nu or len(handle_indices(bench.model)) < np.count_nonzero(bench.model.eq_active0):
        ways.append("`conrod check --drive JOINT=LAW` moves it")
    yield Finding(
        what="nothing moves in its own run",
        severity=Severity.NOTE,
        evidence={"travel [m]": run.travel, "steps": run.steps, "actuators": int(bench.model.nu)},
        why="the closures carry nothing but what rests on them: that they are not seen to open says nothing of the "
        "model in motion",
        fix="; ".join(ways),
    )


# -- a model that starts again by itself -----------------------------------------------------------------------------


def silent_reset(bench: LintBench) -> Iterator[Finding]:
    """Autoreset on."""
    if not (flag := compat.disable_bit("AUTORESET")) or int(bench.model.opt.disableflags) & flag:
        return
    yield Finding(
        what="when its numbers go wrong the model starts again by itself, and the run goes on",
        severity=Severity.ERROR if bench.run.broke else Severity.NOTE,
        evidence={"steps made of those asked for": f"{bench.run.steps} of {bench.steps}"},
        why="a run that diverged is finite, smooth and wrong: the machine is back in its first pose, and a warning is "
        "the only sign of it",
        fix="autoreset off, and look at the warnings or at the numbers",
        edits=('<option><flag autoreset="disable"/></option>',),
        safe=True,
    )
