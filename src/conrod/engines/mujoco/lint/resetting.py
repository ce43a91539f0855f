"""A model that starts again by itself when its numbers go wrong."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.lint.bench import Bench
from conrod.engines.mujoco.lint.edits import SetOption
from conrod.engines.mujoco.lint.finding import Finding, Harm
from conrod.engines.mujoco.lint.rule import Rule
from conrod.engines.mujoco.lint.stability import stable
from conrod.engines.mujoco.recorder import warnings_kept_quiet

TOO_FAST = 1e11  # mjMAXVAL is 1e10: what is beyond it counts as divergence


def judge(bench: Bench) -> Iterator[Finding]:
    """A speed that no machine has is put into a copy: it must be there, or an error, after the next step."""
    if not resets(bench):
        return
    model = bench.model
    twice = stable(bench.with_step(2.0 * float(model.opt.timestep)), bench)
    yield Finding(
        rule=RULE.name,
        subjects=(),
        what="when its numbers go wrong the model starts again by itself, and the run goes on",
        harm=Harm.WRONG if bench.run.broke else Harm.LATENT,
        evidence=(
            ("speed put in", TOO_FAST),
            ("time after the next step [s]", float(model.opt.timestep)),
            ("runs at twice its step", "yes" if twice else "no"),
        ),
        why="a run that diverged is finite, smooth and wrong: the machine is back in its first pose, and but for one "
        "warning nothing says so",
        fix="autoreset off, and look at the warnings or at the numbers",
        edits=(SetOption(("option", "flag"), "autoreset", "disable"),),
        safe=True,
        change=bench.change((SetOption(("option", "flag"), "autoreset", "disable"),)) if not bench.run.broke else None,
    )


def resets(bench: Bench) -> bool:
    """Whether the time starts again after a speed that is none."""
    model = bench.model
    if not model.nv:
        return False
    data = bench.start.data(model)
    with warnings_kept_quiet():
        mujoco.mj_step(model, data, 2)
        before = float(data.time)
        data.qvel[:] = TOO_FAST
        mujoco.mj_step(model, data)
    return bool(data.time < before and np.isfinite(data.qpos).all())


RULE = Rule("silent-reset", judge, needs_motion=False)
