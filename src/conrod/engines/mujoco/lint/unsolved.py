"""A solver that stops before the constraints act: above all one whose tolerance an armature has made void."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.lint.bench import Bench
from conrod.engines.mujoco.lint.edits import Edit, SetOption
from conrod.engines.mujoco.lint.finding import Finding, Harm
from conrod.engines.mujoco.lint.motion import State
from conrod.engines.mujoco.lint.poses import load
from conrod.engines.mujoco.lint.rule import Rule

# Of what the constraints have to do, in acceleration. Newton at MuJoCo's own tolerance of 1e-8 leaves 1e-6 or less.
LEFT = 1e-3
# A solver that fails at one pose has met a hard one; at one in twenty it is set wrongly.
OFTEN = 0.05
# Of the travel: ten times the tolerance that MuJoCo solves to by default.
MOVED = 1e-7
ITERATIONS = 100  # MuJoCo's default; Newton takes two or three
LOOKS = 40


def judge(bench: Bench) -> Iterator[Finding]:
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
        rule=RULE.name,
        subjects=(),
        what="the solver stops before its first iteration: the constraints get the forces of an earlier step, or none"
        if at_once
        else "the solver stops before it is done",
        harm=Harm.WRONG,
        evidence=(
            ("tolerance", float(written.opt.tolerance)),
            ("poses looked at", len(looks)),
            ("poses with work left", int((left > LEFT).sum())),
            ("iterations there, median", passes),
            ("largest share of the work left", float(left.max())),
            ("largest armature", heaviest),
            ("mean inertia that the tolerance is scaled by", float(written.stat.meaninertia)),
            ("change of motion when solved", change),
        ),
        why="MuJoCo scales its tolerance by the mean inertia: a large armature makes it so coarse that nothing is "
        "solved, without a warning"
        if at_once
        else "constraints get only a part of their forces, without a warning",
        fix=" ".join(edit.told for edit in edits),
        edits=edits,
        # The model as it is written, solved: nothing of the machine changes.
        safe=True,
        change=change,
        cost=bench.cost(edits),
    )


def _left(bench: Bench, solved: mujoco.MjModel, state: State) -> tuple[float, int]:
    """How much of what the constraints have to do is left at a pose, and how many iterations were made."""
    answers = []
    for model in (bench.model, solved):
        data = bench.start.data(model)
        load(data, state)
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


RULE = Rule("solver-stops-early", judge)
