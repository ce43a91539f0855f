"""The rule on closures that give way."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from conrod.engines.mujoco.settings import STIFF_SOLIMP, STOCK_SOLIMP, STOCK_SOLREF
from conrod.exact.motion import Array
from conrod.mjcf.equalities import closure_name, ties_bodies
from conrod.mjcf.lint.bench import Bench
from conrod.mjcf.lint.edits import Edit, SetAttribute
from conrod.mjcf.lint.findings import Finding, Harm, Value

# Of the machine's size. A bearing's play is a ten-thousandth of a small machine (30 micrometres in 0.3 m): closures
# that give way by more are worse than a real joint.
PLAY = 1e-4
# A closure that opens ten times less when it is made stiff opens because it was soft, and for no other reason.
TENFOLD = 0.1
REFINEMENTS = 3  # halvings of the step; where a stiff closure still opens then, it is not the softness that is seen
# Time constants [steps] at which conrod's preset `tuned` closes loops: RK4 loses its order below.
STIFF_STEPS = {int(mujoco.mjtIntegrator.mjINT_RK4): 8.0}
LEAST_STEPS = 2.0  # MuJoCo admits no less


def soft_closures(bench: Bench) -> Iterator[Finding]:
    """Connects and welds that open in the run, and would not if they were stiff."""
    model = bench.model
    before = _worst(bench, ())
    loose = [i for i in range(model.neq) if before[i] > PLAY * bench.size and bench.document.can_edit("equality", i)]
    looks = [_Look(bench, loose)]
    # With few steps a turn a stiff closure opens as well, by what the step leaves: looked at again with finer ones.
    while looks[-1].undecided and len(looks) <= REFINEMENTS:
        looks.append(_Look(bench.with_step(0.5 * looks[-1].step), looks[-1].undecided))
    found = [(look, look.soft) for look in looks if look.soft]
    if found:
        yield _finding(bench, before, *found[0])


class _Look:
    """Closures as they are and as stiff as they can be, at one step."""

    def __init__(self, bench: Bench, loose: list[int]) -> None:
        self.step = float(bench.model.opt.timestep)
        edits = tuple(edit for index in loose for edit in stiff(bench.model, index))
        self.soft: list[int] = []
        self.undecided: list[int] = []
        if not loose or bench.run_of(edits).broke:
            return
        self.before, self.after = _worst(bench, ()), _worst(bench, edits)
        self.soft = [index for index in loose if self.after[index] <= TENFOLD * self.before[index]]
        if not self.soft:
            self.undecided = [index for index in loose if self.before[index] > PLAY * bench.size]


def _finding(bench: Bench, before: Array, look: _Look, loose: list[int]) -> Finding:
    model = bench.model
    edits = tuple(edit for index in loose for edit in stiff(model, index))
    change = bench.change(edits)
    worst = max(loose, key=lambda index: before[index])
    stock = sum(_is_stock(model, index) for index in loose)
    finer: dict[str, Value] = {}
    if look.step < float(model.opt.timestep):
        finer = {
            "with a step of [s]": look.step,
            "opening then [m]": float(look.before[worst]),
            "opening then when stiff [m]": float(look.after[worst]),
        }
    return Finding(
        subjects=tuple(closure_name(model, index) for index in loose),
        what=f"closures give way: {closure_name(model, worst)} opens by {1e3 * before[worst]:.3g} mm",
        harm=Harm.WRONG,
        evidence={
            "opening [m]": float(before[worst]),
            "opening over size": float(before[worst] / bench.size),
            "opening when stiff [m]": float(_worst(bench, edits)[worst]),
            **finer,
            "closures with the stock solref and solimp": f"{stock} of {len(loose)}",
            "change of motion when stiff": change,
        },
        fix="stiffer closures, as here, unless they are meant to give way; `conrod harden` takes out what no file can",
        edits=edits,
        change=change,
    )


def stiff(model: mujoco.MjModel, index: int) -> tuple[Edit, ...]:
    """A closure as stiff as a model file can make it."""
    name = closure_name(model, index)
    steps = STIFF_STEPS.get(int(model.opt.integrator), LEAST_STEPS)
    return (
        SetAttribute("equality", index, name, "solref", f"{steps * float(model.opt.timestep):.6g} 1"),
        SetAttribute("equality", index, name, "solimp", " ".join(f"{value:g}" for value in STIFF_SOLIMP)),
    )


def _worst(bench: Bench, edits: tuple[Edit, ...]) -> Array:
    """The widest opening (neq,) [m] of each; where one is open at the start, after the first quarter of the run."""
    openings = bench.poses_of(edits).openings
    settled = openings[len(openings) // 4 :].max(axis=0)
    return np.asarray(np.where(openings[0] <= PLAY * bench.size, openings.max(axis=0), settled))


def _is_stock(model: mujoco.MjModel, index: int) -> bool:
    return bool(
        ties_bodies(model, index)
        and np.array_equal(model.eq_solref[index], STOCK_SOLREF)
        and np.array_equal(model.eq_solimp[index], STOCK_SOLIMP)
    )
