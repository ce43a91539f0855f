"""Rules on stepping: a step that is too long, and a solver that stops before the constraints act."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.edits import Edit, SetOption
from conrod.mjcf.lint.findings import Finding, Harm, Note
from conrod.mjcf.lint.runs import State

HALVINGS = 6
DOUBLINGS = 5
# A run in which something gets this many times farther, or opens this many times wider, than in one with finer steps
# is not a rough picture of the same motion.
OUT_OF_HAND = 10.0
OPEN = 0.1  # of the machine's size


def unstable_step(bench: Bench) -> Iterator[Finding | Note]:
    """Runs over the same time with half the step, and half of that, until two of them agree on where things are."""
    longest = longest_stable(bench)
    step = float(bench.model.opt.timestep)
    if longest is None:
        yield Finding(
            subjects=(),
            what="the model does not run, at no step that was tried",
            harm=Harm.WRONG,
            evidence={
                "step [s]": step,
                "finest step tried [s]": step / 2**HALVINGS,
                "steps before it breaks": bench.run.steps,
                "warnings": ", ".join(bench.run.warnings) or "none",
            },
            why="whatever is read from it is not the machine's motion",
            fix="look at the start pose, overlapping geoms, gains, and masses next to zero",
        )
    elif longest < step:
        yield _finding(bench, longest)
    else:
        yield Note(_margin(bench))


def _finding(bench: Bench, longest: float) -> Finding:
    step = float(bench.model.opt.timestep)
    return Finding(
        subjects=(),
        what=f"the step of {step:.4g} s is longer than the longest at which the model runs, {longest:.4g} s",
        harm=Harm.WRONG,
        evidence={
            "step [s]": step,
            "longest stable step [s]": longest,
            "steps made of those asked for": f"{bench.run.steps} of {bench.steps}",
            "warnings": ", ".join(bench.run.warnings) or "none",
        },
        fix=f'timestep="{longest:.4g}" or less: half of it leaves a margin',
        edits=(SetOption(("option",), "timestep", f"{0.5 * longest:.4g}"),),
    )


def longest_stable(bench: Bench) -> float | None:
    """The longest of the model's step, half of it, .. that is stable [s]; None where none is."""
    trial = bench
    for _ in range(HALVINGS):
        finer = trial.with_step(0.5 * float(trial.model.opt.timestep))
        if stable(trial, finer):
            return float(trial.model.opt.timestep)
        trial = finer
    return None


def stable(bench: Bench, finer: Bench) -> bool:
    """Return True where a run holds together, as one with finer steps over the same time does."""
    if bench.run.broke or finer.run.broke:
        return False
    room = max(finer.run.travel, 1e-3 * finer.size)
    if bench.run.travel > OUT_OF_HAND * room:
        return False
    wide, fine = (float(one.poses.openings.max(initial=0.0)) for one in (bench, finer))
    return wide <= max(OPEN * finer.size, OUT_OF_HAND * fine)


def _margin(bench: Bench) -> str:
    step = float(bench.model.opt.timestep)
    trial = bench
    for doubling in range(1, DOUBLINGS + 1):
        trial = bench.with_step(step * 2**doubling)
        if trial.steps < 2 or not stable(trial, bench):
            return f"the step of {step:.4g} s is stable, and so are longer ones below {step * 2**doubling:.4g} s"
    return f"the step of {step:.4g} s is stable, and so are longer ones up to {step * 2**DOUBLINGS:.4g} s at least"


# Of what the constraints have to do, in acceleration. Newton at MuJoCo's own tolerance of 1e-8 leaves 1e-6 or less.
LEFT = 1e-3
# A solver that fails at one pose has met a hard one; at one in twenty it is set wrongly.
OFTEN = 0.05
# Of the travel: ten times the tolerance that MuJoCo solves to by default.
MOVED = 1e-7
ITERATIONS = 100  # MuJoCo's default; Newton takes two or three
LOOKS = 40


def unsolved(bench: Bench) -> Iterator[Finding]:
    """Poses at which the solver leaves a share of its work, compared with Newton's method to the end."""
    model = bench.model
    edits: tuple[Edit, ...] = ()
    if model.opt.tolerance > 0.0:
        edits += (SetOption(("option",), "tolerance", "0"),)
    if model.opt.solver != mujoco.mjtSolver.mjSOL_NEWTON:
        edits += (SetOption(("option",), "solver", "Newton"),)
    if model.opt.iterations < ITERATIONS:
        edits += (SetOption(("option",), "iterations", str(ITERATIONS)),)
    if not edits:
        return
    states = bench.run.states[:: max(1, len(bench.run.states) // LOOKS)]
    looks = [_left(bench, bench.copy(edits), state) for state in states]
    left = np.array([share for share, _ in looks])
    share = float(np.mean(left > LEFT)) if len(left) else 0.0
    change = bench.change(edits) if share >= OFTEN else 0.0
    if change <= MOVED:
        return
    passes = int(np.median([count for left_over, count in looks if left_over > LEFT]))
    # Of the file: a drive brings an armature of its own, and a tolerance that makes up for it.
    written = bench.document.model
    heaviest = float(written.dof_armature.max(initial=0.0))
    at_once = passes == 0
    yield Finding(
        subjects=(),
        what="the solver stops before its first iteration: the constraints get the forces of an earlier step, or none"
        if at_once
        else "the solver stops before it is done",
        harm=Harm.WRONG,
        evidence={
            "tolerance": float(written.opt.tolerance),
            "poses looked at": len(looks),
            "poses with work left": int((left > LEFT).sum()),
            "iterations there, median": passes,
            "largest share of the work left": float(left.max()),
            "largest armature": heaviest,
            "mean inertia that the tolerance is scaled by": float(written.stat.meaninertia),
            "change of motion when solved": change,
        },
        why="MuJoCo scales its tolerance by the mean inertia: a large armature makes it so coarse that nothing is "
        "solved, without a warning"
        if at_once
        else "constraints get only a part of their forces, without a warning",
        fix=" ".join(edit.words for edit in edits),
        edits=edits,
        # The model as it is written, solved: nothing of the machine changes.
        safe=True,
        change=change,
        cost=bench.cost(edits),
    )


def _left(bench: Bench, solved: mujoco.MjModel, state: State) -> tuple[float, int]:
    """Share of the constraints' work that is left at a pose, and the iterations that were made."""
    answers = []
    for model in (bench.model, solved):
        data = bench.start.data(model)
        state.put(data)
        mujoco.mj_forward(model, data)
        answers.append(data)
    own, exact = answers
    if not exact.nefc or own.nefc != exact.nefc:
        return 0.0, 0
    rest, work = np.empty(own.nefc), np.empty(own.nefc)
    mujoco.mj_mulJacVec(bench.model, own, rest, own.qacc - exact.qacc)
    mujoco.mj_mulJacVec(bench.model, own, work, exact.qacc - exact.qacc_smooth)
    largest = float(np.abs(work).max())
    share = float(np.abs(rest).max()) / largest if largest > 0.0 else 0.0
    return share, int(own.solver_niter[: max(own.nisland, 1)].max())
