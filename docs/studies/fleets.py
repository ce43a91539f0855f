"""Machines of one layout whose lengths are drawn at random within a drawing's tolerances: saws, and grippers.

A fleet is one compiled model, the fields in which its members differ, and their exact states at the start: what an
engine that steps many worlds in one call takes. To compile a saw takes milliseconds, so lengths are written into the
fields of a compiled model, and MuJoCo computes the constants that follow. The first members of a larger fleet are those
of a smaller one.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from conrod.engines.mjx import MJXSettings
from conrod.engines.mujoco.model import build
from conrod.exact.motion import Array
from conrod.scenes import SCENES, Scene
from docs.studies import gripper

DRAWING: Any = SCENES["saw-500rpm"]
TOLERANCES = {"crank": 0.3e-3, "rod": 0.5e-3, "offset": 0.3e-3}  # [m], ISO 2768-1 m: 30 to 120 mm, 120 to 400 mm
STEPS = 250  # of a turn of a saw, and of a gripper's closing
SEED = 2768
CHUNK = 500  # members whose errors are computed at a time
SLIDE, CRANK, CRANK_PIN = 0, 1, 2  # coordinates of the saw's model
GEOMETRY = ("body_pos", "body_quat", "body_ipos", "site_pos")  # fields that lengths are written into
CONSTANTS = ("body_invweight0", "dof_invweight0", "dof_M0")  # fields that MuJoCo computes from them
# Integrators with their closures' time constant in steps: the settings of MJX's `tuned`, and of MuJoCo's.
TIME_CONSTANT_STEPS = {"Euler": 2.0, "RK4": 8.0}


@dataclass(frozen=True)
class Layout:
    """A machine whose lengths may be drawn.

    Attributes:
        name: of the machine.
        drawn: lengths of so many members (n, ..) [m], from their number.
        compiled: the compiled model of a member, from its lengths.
        write: writes lengths (n, ..) into the fields of `GEOMETRY` (n, ..), given the model.
        start: exact coordinates and rates at the start (n, nq), (n, nv).
        exact: exact coordinates after each step (n, T, nq); those that no deviation follows from are 0.
        deviations: off the exact motion at the drive's angle reached, over L (n, T), of recorded ones (n, T, nq).
        drives: coordinates that turn at constant speed.
    """

    name: str
    drawn: Callable[[int], Array]
    compiled: Callable[[Array], mujoco.MjModel]
    write: Callable[[mujoco.MjModel, Array, dict[str, Array]], None]
    start: Callable[[Array], tuple[Array, Array]]
    exact: Callable[[Array], Array]
    deviations: Callable[[Array, Array], Array]
    drives: Sequence[int]


@dataclass(frozen=True)
class Fleet:
    """Machines of one layout: a model, values (n, ..) of fields that differ, exact states at the start, and lengths."""

    layout: Layout
    model: mujoco.MjModel
    fields: dict[str, Array]
    coordinates: Array
    rates: Array
    sizes: Array

    def __len__(self) -> int:
        return len(self.sizes)

    def first(self, count: int) -> Fleet:
        """The first members."""
        return replace(
            self, fields={name: values[:count] for name, values in self.fields.items()},
            coordinates=self.coordinates[:count], rates=self.rates[:count], sizes=self.sizes[:count],
        )  # fmt: skip

    def with_integrator(self, integrator: str) -> Fleet:
        """The fleet stepped by Euler or RK4, with the closures' time constant that goes with it."""
        model = copy(self.model)
        model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator.upper()}")
        model.eq_solref[:] = TIME_CONSTANT_STEPS[integrator] * model.opt.timestep, 1.0
        return replace(self, model=model)

    def with_planted(self, member: int, other: int) -> Fleet:
        """The fleet with one member's model that of another, while its lengths and its start stay."""
        fields = {name: values.copy() for name, values in self.fields.items()}
        for values in fields.values():
            values[member] = values[other]
        return replace(self, fields=fields)

    def errors(self, recorded: Array, sizes: Array | None = None) -> Array:
        """The largest deviation of each member (n,) in recorded coordinates (n, T, nq)."""
        of = self.sizes if sizes is None else sizes

        def largest(chunk: slice) -> Array:
            return np.asarray(self.layout.deviations(of[chunk], recorded[chunk].astype(float)).max(axis=-1))

        chunks = [slice(first, first + CHUNK) for first in range(0, len(self), CHUNK)]
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            return np.concatenate(list(pool.map(largest, chunks)))


def fleet(layout: Layout, count: int) -> Fleet:
    """Make a fleet of so many members, of lengths drawn at random."""
    from mujoco import batch as mujoco_batch  # since 4.0

    sizes = layout.drawn(count)
    model = layout.compiled(sizes[0])
    fields = {name: np.repeat(getattr(model, name)[None], count, axis=0) for name in GEOMETRY}
    layout.write(model, sizes, fields)
    worlds = mujoco_batch.Batch(model, nsim=count, nthread=os.cpu_count() or 1)
    for name, values in fields.items():
        worlds.expand(name)[:] = values
    worlds.set_const()
    fields |= {name: np.array(worlds.expand(name)) for name in CONSTANTS}
    return Fleet(layout, model, fields, *layout.start(sizes), sizes)


# -- saws --------------------------------------------------------------------------------------------------------------


def saw_sizes(count: int) -> Array:
    """Crank, rod and offset (n, 3) [m], each drawn evenly within its tolerance."""
    off = np.random.default_rng(SEED).uniform(-1.0, 1.0, (count, len(TOLERANCES)))
    drawn = np.array([getattr(DRAWING, name) for name in TOLERANCES])
    return np.asarray(drawn + off * np.array(list(TOLERANCES.values())))


def saw(size: Array) -> Scene:
    """The saw with given crank, rod and offset [m]."""
    made: Scene = replace(DRAWING, **dict(zip(TOLERANCES, map(float, size), strict=True)))
    return made


def compiled_saw(size: Array) -> mujoco.MjModel:
    """A saw as conrod gives it to MuJoCo, with the settings of MJX's `tuned`."""
    return build(saw(size), MJXSettings.tuned(DRAWING, STEPS), sensors=False).model


def write_saws(model: mujoco.MjModel, sizes: Array, fields: dict[str, Array]) -> None:
    """Write lengths of saws into fields of the model: the shaft's place, the rod's pin, angle, middle and end."""
    crank, rod, offset = sizes.T
    own = {name: model.body(name).id for name in ("crank", "rod")}
    reach = np.sqrt((rod - offset) * (rod + offset))
    fields["body_pos"][:, own["crank"], :2] = np.stack([reach - crank, -offset], axis=-1)
    fields["body_pos"][:, own["rod"], 0] = crank
    half = 0.5 * np.arctan2(offset, -reach)
    fields["body_quat"][:, own["rod"]] = np.stack([np.cos(half), 0 * half, 0 * half, np.sin(half)], axis=-1)
    fields["body_ipos"][:, own["rod"], 0] = fields["site_pos"][:, model.site("M").id, 0] = 0.5 * rod
    fields["site_pos"][:, model.site("slider-pin.rod").id, 0] = rod


def saw_start(sizes: Array) -> tuple[Array, Array]:
    """Exact coordinates and rates (n, 3) at crank angle 0, where the pin moves straight up with r omega."""
    crank, rod, offset = sizes.T
    reach = np.sqrt((rod - offset) * (rod + offset))
    speed = np.full(len(sizes), DRAWING.speed)
    # x = r cos t - sqrt(l^2 - y^2) with y = e - r sin t; of the rod l sin a = y, l cos a = -sqrt(l^2 - y^2).
    rates = np.stack([-crank * offset / reach * speed, speed, speed * (crank / reach - 1.0)], axis=-1)
    return np.zeros_like(rates), rates


def saw_travel(sizes: Array, turn: Array) -> Array:
    """Exact travel of the slider (n, T) [m] from where it is at crank angle 0.

    With crank r, rod l and offset e: x = r cos t - sqrt(l^2 - (e - r sin t)^2), less that at t = 0 (document 002).
    """
    crank, rod, offset = sizes.T[:, :, None]
    start = np.sqrt((rod - offset) * (rod + offset)) - crank
    return np.asarray(start + crank * np.cos(turn) - np.sqrt(rod**2 - (offset - crank * np.sin(turn)) ** 2))


def saw_exact(sizes: Array) -> Array:
    """Exact coordinates of slider and crank after each step (n, T, 3)."""
    turn = np.broadcast_to(2.0 * np.pi * np.arange(1, STEPS + 1) / STEPS, (len(sizes), STEPS))
    found = np.zeros((*turn.shape, 3))
    found[..., CRANK], found[..., SLIDE] = turn, saw_travel(sizes, turn)
    return found


def saw_deviations(sizes: Array, recorded: Array) -> Array:
    """The slider off its exact place at the crank angle reached, over its stroke (n, T)."""
    stroke = np.ptp(saw_travel(sizes, np.linspace(0.0, 2.0 * np.pi, 721)[None]), axis=-1)
    off = recorded[..., SLIDE] - saw_travel(sizes, recorded[..., CRANK])
    return np.asarray(np.abs(off) / stroke[:, None])


# -- grippers ----------------------------------------------------------------------------------------------------------


def gripper_sizes(count: int) -> Array:
    """Lengths a, b, c, d of both fingers (n, 2, 4) [m], each drawn evenly within its tolerance."""
    off = np.random.default_rng(SEED).uniform(-1.0, 1.0, (count, 2, 4))
    return np.asarray(gripper.DRAWN + off * gripper.TOLERANCE)


def write_grippers(model: mujoco.MjModel, sizes: Array, fields: dict[str, Array]) -> None:
    """Write lengths of grippers into fields of the model."""
    for k, finger in enumerate(gripper.FINGERS):
        base, driver, tip, follower = sizes[:, k].T
        bodies = [model.body(f"{finger}-{part}").id for part in ("driver", "tip", "follower")]
        fields["body_ipos"][:, bodies[0], 0] = 0.5 * driver
        fields["body_ipos"][:, bodies[2], 0] = 0.5 * follower
        fields["body_pos"][:, bodies[1], 0] = driver
        pivot = gripper.DRIVER_PIVOT + base[:, None] * gripper.unit(np.asarray(gripper.BASE_ANGLE))
        fields["body_pos"][:, bodies[2], :2] = pivot * [1.0 - 2.0 * k, 1.0]  # the left finger is the right one's mirror
        fields["site_pos"][:, model.site(f"{finger}-tip-end").id, 0] = tip
        fields["site_pos"][:, model.site(f"{finger}-follower-end").id, 0] = follower


def gripper_exact(sizes: Array) -> Array:
    """Exact coordinates of a gripper after each step (n, T, 6)."""
    closed = (gripper.CLOSED - gripper.OPEN) * np.arange(1, STEPS + 1) / STEPS
    return gripper.coordinates(sizes, gripper.OPEN + closed)


def gripper_deviations(sizes: Array, recorded: Array) -> Array:
    """The worse of both pads off its exact place at the driver angle reached, over the pad's path's span (n, T)."""
    both = gripper.Fingers(sizes)
    driver, tip = (np.moveaxis(recorded[..., k::3], -1, -2) for k in (0, 1))  # (n, 2, T)
    off = both.pad(driver, driver + tip) - both.pad(driver, both.angles(driver)[0])
    ends = np.broadcast_to(np.array([gripper.OPEN, gripper.CLOSED]), (*sizes.shape[:2], 2))
    span = np.diff(both.pad(ends, both.angles(ends)[0]), axis=-2)[..., 0, :]
    return np.asarray((np.hypot(*np.moveaxis(off, -1, 0)) / np.hypot(*np.moveaxis(span, -1, 0))[..., None]).max(axis=1))


LAYOUTS = {
    "saw": Layout(
        "saw", saw_sizes, compiled_saw, write_saws, saw_start, saw_exact, saw_deviations, [CRANK],
    ),
    "gripper": Layout(
        "gripper", gripper_sizes, lambda size: gripper.gripper_model(size, STEPS), write_grippers,
        gripper.start_state, gripper_exact, gripper_deviations, [0, 3],
    ),
}  # fmt: skip
