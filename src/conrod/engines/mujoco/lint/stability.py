"""A step that is longer than the longest at which the model runs."""

from __future__ import annotations

from collections.abc import Iterator

from conrod.engines.mujoco.lint.bench import Bench
from conrod.engines.mujoco.lint.edits import SetOption
from conrod.engines.mujoco.lint.finding import Finding, Harm, Note
from conrod.engines.mujoco.lint.rule import Rule

HALVINGS = 6
DOUBLINGS = 5
# A run in which something gets this many times farther, or opens this many times wider, than in one with finer steps
# is not a rough picture of the same motion.
OUT_OF_HAND = 10.0
OPEN = 0.1  # of the machine's size


def judge(bench: Bench) -> Iterator[Finding | Note]:
    """Runs over the same time with half the step, and half of that, until two of them agree on where things are."""
    longest = longest_stable(bench)
    step = float(bench.model.opt.timestep)
    if longest is None:
        yield Finding(
            rule=RULE.name,
            subjects=(),
            what="the model does not run, at no step that was tried",
            harm=Harm.WRONG,
            evidence=(
                ("step [s]", step),
                ("finest step tried [s]", step / 2**HALVINGS),
                ("steps before it breaks", bench.run.steps),
                ("warnings", ", ".join(bench.run.warnings) or "none"),
            ),
            why="whatever is read from it is not the machine's motion",
            fix="look at the start pose, overlapping geoms, gains, and masses next to zero",
        )
    elif longest < step:
        yield _finding(bench, longest)
    else:
        yield Note(RULE.name, _margin(bench))


def _finding(bench: Bench, longest: float) -> Finding:
    step = float(bench.model.opt.timestep)
    return Finding(
        rule=RULE.name,
        subjects=(),
        what=f"the step of {step:.4g} s is longer than the longest at which the model runs, {longest:.4g} s",
        harm=Harm.WRONG,
        evidence=(
            ("step [s]", step),
            ("longest stable step [s]", longest),
            ("steps made of those asked for", f"{bench.run.steps} of {bench.steps}"),
            ("warnings", ", ".join(bench.run.warnings) or "none"),
        ),
        why="the motion is the integrator's, not the machine's",
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
    """Whether a run holds together, where one with finer steps over the same time does."""
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


RULE = Rule("step-too-long", judge, needs_motion=False)
