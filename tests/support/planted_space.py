"""Engines of other packages in space: exact motion with an error of known size and order, and misbehaviours of it.

The machine is at the time t + LEAD (h / T)^p T where the engine reports t, with h its step and T the period: positions
are off by the way that the exact motion goes in that lead.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from misbehaving_engines import install_engines, named_presets, raiser
from planted_engine import ORDERS, PlantedEngine

from conrod.engines.space import SpatialRun, SpatialStart
from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.exact.space.forward_kinematics import Series, forward_kinematics

LEAD = 0.05  # of a period, at one step a period


class PlantedSpace(PlantedEngine):
    """The exact motion in space, a little ahead of itself."""

    def refusal_in_space(self, start: SpatialStart, preset: str) -> Any:
        if any(joint.kind == "ball" for joint in start.tree.joints):
            return "the planted engine knows no balls"
        return None

    def run_in_space(self, start: SpatialStart, preset: str, steps: int, every: int = 1) -> Any:
        times = start.step * every * np.arange(steps // every + 1)
        lead = LEAD * (start.step / start.period) ** ORDERS[preset] * start.period
        start.machine.track_branch(start.machine.knots[0].coordinates, times[-1] + lead)
        motion = start.machine.motion(times + lead, 2)
        poses = forward_kinematics(start.tree, motion.coordinates, motion.rates[:2])
        return SpatialRun(times, {name: derivatives(poses.point(at), len(times)) for name, at in start.points.items()})

    def stepper_in_space(self, start: SpatialStart, preset: str) -> Any:
        return lambda steps: None


def derivatives(series: Series, samples: int) -> Array:
    """Position, velocity and acceleration (3, T, 3) of a point, from its series in time."""
    made = np.zeros((3, samples, 3))
    for k, (factor, one) in enumerate(zip((1.0, 1.0, 2.0), series, strict=False)):
        made[k] = factor * np.broadcast_to(one, (3, samples)).T
    return made


class Edited(PlantedSpace):
    """Changes its run."""

    def __init__(self, edit: Callable[[SpatialRun], Any]) -> None:
        self.edit = edit

    def run_in_space(self, *arguments: Any, **named: Any) -> Any:
        return self.edit(super().run_in_space(*arguments, **named))


class Does(PlantedSpace):
    """Does something before its run, with its start."""

    def __init__(self, act: Callable[[SpatialStart], Any]) -> None:
        self.act = act

    def run_in_space(self, start: SpatialStart, *arguments: Any, **named: Any) -> Any:
        self.act(start)
        return super().run_in_space(start, *arguments, **named)


class Mutates(PlantedSpace):
    """Changes the start that it was given, once it needs that no more."""

    def run_in_space(self, start: SpatialStart, *arguments: Any, **named: Any) -> Any:
        found = super().run_in_space(start, *arguments, **named)
        start.exact.coordinates[:] = 0.0
        start.tree.start[:] = 1.0
        start.machine.knots.clear()
        return found


class Refuses(PlantedSpace):
    """Gives something as its refusal."""

    def __init__(self, reason: Callable[[], Any]) -> None:
        self.reason = reason

    def refusal_in_space(self, *_: Any) -> Any:
        return self.reason()


class StepsWrongly(PlantedSpace):
    """Cannot be timed."""

    def stepper_in_space(self, *_: Any) -> Any:
        return raiser(ZeroDivisionError("no step"))


def with_points(edit: Callable[[Any], Any], of: Callable[[str], bool] = bool) -> Callable[[SpatialRun], SpatialRun]:
    """A change of the points of a run, or of some of them."""
    return lambda run: replace(run, points={n: edit(p) if of(n) else p for n, p in run.points.items()})


def with_times(edit: Callable[[Any], Any]) -> Callable[[SpatialRun], SpatialRun]:
    """A change of the stamps of a run."""
    return lambda run: replace(run, times=edit(run.times))


def rename_points(run: SpatialRun) -> SpatialRun:
    return replace(run, points={f"my {name}": values for name, values in run.points.items()})


def set_nan(values: Any) -> Any:
    values[:, len(values[0]) // 2 :] = np.nan
    return values


def patch_numpy(_: SpatialStart) -> None:
    np.linalg.norm = lambda values, *a, **k: np.zeros(len(values))  # type: ignore[assignment]


# By name: the engine, its outcome, and a part of the reason for it.
CASES: dict[str, tuple[PlantedSpace, str, str]] = {
    "space-good": (PlantedSpace(), "completed", ""),
    "space-mutates": (Mutates(), "completed", ""),
    "space-nan": (Edited(with_points(set_nan)), "diverged", "not finite from 0.5 s on"),
    "space-nan-end": (Edited(with_points(set_nan, lambda n: n.endswith("end 2"))), "diverged", "not finite from 0.5 s"),
    "space-nan-time": (Edited(with_times(lambda t: t * np.nan)), "crashed", "it handed over stamps with nan"),
    "space-none": (Edited(lambda run: None), "crashed", "a run in space that is of NoneType"),
    "space-flat": (Edited(with_points(lambda v: v[0])), "crashed", "of shape (21, 3), not (3, 21, 3)"),
    "space-transposed": (Edited(with_points(lambda v: v.transpose(1, 0, 2).copy())), "crashed", "of shape (21, 3, 3)"),
    "space-single": (Edited(with_points(lambda v: v.astype(np.float32))), "crashed", "as float32, not as float64"),
    "space-list": (Edited(with_points(lambda v: v.tolist())), "crashed", "as list, not as a numpy array"),
    "space-short": (Edited(with_times(lambda t: t[:-1])), "crashed", "20 samples of a run in space, of which 21"),
    "space-reversed": (Edited(with_times(lambda t: t[::-1].copy())), "crashed", "number 0 is 1 s, 1 s off its step"),
    "space-late": (Edited(with_times(lambda t: t + 0.05)), "crashed", "number 0 is 0.05 s, 0.05 s off its step"),
    "space-renamed": (Edited(rename_points), "crashed", "points ['my closure"),
    "space-no-reason": (Edited(lambda run: replace(run, failure=3)), "crashed", "why a run in space broke off that is"),
    "space-fails": (Edited(lambda run: replace(run, failure="lost\nat last")), "diverged", "lost at last"),
    "space-raises": (Does(raiser(RuntimeError("the solver is lost"))), "crashed", "RuntimeError: the solver is lost"),
    "space-refuses-late": (Does(raiser(InvalidInput("no such rod"))), "unsupported", "no such rod"),
    "space-exits": (Does(lambda _: sys.exit(0)), "crashed", "SystemExit: 0"),
    "space-leaves": (Does(lambda _: os._exit(0)), "crashed", "ended with status 0"),
    "space-aborts": (Does(lambda _: os.abort()), "crashed", "ended by signal SIGABRT"),
    "space-numpy": (Does(patch_numpy), "crashed", "it changed numpy.linalg.norm"),
    "space-steps": (StepsWrongly(), "crashed", "ZeroDivisionError: no step"),
    "space-refuses": (Refuses(lambda: "too small"), "unsupported", "too small"),
    "space-refusal": (Refuses(lambda: 3), "crashed", "a reason of a refusal that is of int"),
}
for _name, (_engine, *_) in CASES.items():
    _engine.name, _engine.presets = _name, named_presets(_engine)  # type: ignore[misc]


def __getattr__(name: str) -> Any:
    if (known := name.removeprefix("ENGINE_").replace("_", "-")) in CASES:
        return CASES[known][0]
    raise AttributeError(name)


def install_in(folder: Path) -> Path:
    """Install a distribution with all these engines into a folder for `sys.path`."""
    return install_engines(folder, "planted_space", CASES)
