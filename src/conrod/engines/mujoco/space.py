"""MuJoCo on machines in space: a model of their tree, its joints driven along laws by flywheels."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator

import mujoco
import numpy as np

from conrod.engines.engine import STOCK
from conrod.engines.mujoco.driven_joints import Drives, model_with_settings, preset_settings
from conrod.engines.mujoco.dynamics import bad_number_warnings, silence_warnings
from conrod.engines.space import SpatialRun, SpatialStart
from conrod.exact.motion import Array
from conrod.exact.space import SpatialBody, SpatialPoint, SpatialTree

CLOSURES = ("connect", "weld", "joint")
SITE = int(mujoco.mjtObj.mjOBJ_SITE)
INTEGRATION = int(mujoco.mjtState.mjSTATE_INTEGRATION)


def refusal_in_space(start: SpatialStart, preset: str) -> str | None:
    """Return the reason why MuJoCo is not given a machine in space, or None."""
    if other := sorted({closure.kind for closure in start.tree.closures} - {*CLOSURES}):
        return f"mujoco in space is given loops closed by connects, welds and couplings, no {' or '.join(other)}"
    if any(not one.points and not one.sums[0] for one in start.tree.closures):
        return "mujoco in space is given no coupling whose dependent joint is held"
    return None


def spatial_mjcf(tree: SpatialTree, points: Iterable[SpatialPoint] = ()) -> str:
    """A tree as a MuJoCo model, with a site `point K` for the K-th of some points."""
    root = ET.Element("mujoco")
    ET.SubElement(root, "compiler", angle="radian")
    ET.SubElement(root, "option", gravity=_text(tree.gravity))
    bodies = [ET.SubElement(root, "worldbody")]
    for k, body in enumerate(tree.bodies[1:], 1):
        bodies.append(_add_body(bodies[body.parent], f"body {k}", body))
    for k, point in enumerate(points):
        _add_site(bodies[point.body], f"point {k}", point.offset, np.eye(3))
    equality = ET.SubElement(root, "equality")
    for k, closure in enumerate(tree.closures):
        if not closure.points:
            (one,), other = ([f"joint {rate}" for rate in terms] for terms in closure.sums)
            pair = {"joint1": one} | ({"joint2": other[0]} if other else {})
            ET.SubElement(equality, "joint", {**pair, "polycoef": _text(np.array(closure.polynomial))})
            continue
        turns = (np.eye(3) if closure.turn is None else closure.turn, np.eye(3))
        names = [f"closure {k} {end}" for end in (1, 2)]
        for name, point, turn in zip(names, closure.points, turns, strict=True):
            _add_site(bodies[point.body], name, point.offset, turn)
        ET.SubElement(equality, closure.kind, site1=names[0], site2=names[1])
    return ET.tostring(root, encoding="unicode")


def _add_body(parent: ET.Element, name: str, body: SpatialBody) -> ET.Element:
    """Add a body with its joints and inertia."""
    made = ET.SubElement(parent, "body", name=name, pos=_text(body.place), quat=_text(_quaternion(body.turn)))
    if body.mass > 0.0:
        inertia = body.inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        ET.SubElement(made, "inertial", pos=_text(body.centre), mass=repr(body.mass), fullinertia=_text(inertia))
    for joint in body.joints:
        scalar = {"axis": _text(joint.axis), "ref": repr(joint.reference)} if joint.kind in ("hinge", "slide") else {}
        where = {} if joint.kind == "free" else {"pos": _text(joint.anchor)}
        own = {"armature": repr(joint.armature), "damping": repr(joint.damping)}
        ET.SubElement(made, "joint", {"name": f"joint {joint.rate}", "type": joint.kind, **where, **scalar, **own})
    return made


def _add_site(body: ET.Element, name: str, place: Array, turn: Array) -> None:
    ET.SubElement(body, "site", name=name, pos=_text(place), quat=_text(_quaternion(turn)))


def _quaternion(turn: Array) -> Array:
    """The quaternion (4,) of a rotation (3, 3), as MuJoCo takes it."""
    found = np.empty(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(turn).ravel())
    return found


def _text(numbers: Array) -> str:
    return " ".join(map(repr, np.asarray(numbers, dtype=float).tolist()))


# -- runs --------------------------------------------------------------------------------------------------------------


class MuJoCoSpatialStepper:
    """A machine in space in MuJoCo that starts in its exact state; a call advances it by some steps.

    Attributes:
        sites: numbers of the sites that are the observed points.
        done: number of steps made.
        failure: why the run broke off; empty while it goes on.
    """

    def __init__(self, start: SpatialStart, preset: str) -> None:
        plain = mujoco.MjModel.from_xml_string(spatial_mjcf(start.tree, start.points.values()))
        settings = None if preset == STOCK else preset_settings(preset, start.step, start.period, start.idle)
        self.model = model_with_settings(plain, start.step, settings)
        self._drives, self._step = Drives(start.machine, self.model), start.step
        self.data, self.done, self.failure = mujoco.MjData(self.model), 0, ""
        self.sites = [mujoco.mj_name2id(plain, SITE, f"point {k}") for k in range(len(start.points))]
        self.data.qpos[:], self.data.qvel[:] = start.exact.coordinates[:, 0], start.exact.rates[0, :, 0]

    def __call__(self, steps: int) -> None:
        for _ in self.states(steps):
            pass

    def states(self, steps: int) -> Iterator[int]:
        """Yield the number of steps made, at the beginning and after each of some steps, until the run breaks off."""
        write = self._drives.writer(self._step * (self.done + np.arange(steps + 1.0)))
        with silence_warnings(), self._drives.pushing_flywheels():
            yield self.done
            for k in range(1, steps + 1):
                if self.failure:
                    return
                mujoco.mj_step(self.model, self.data)
                self.done += 1
                self.failure = self._break_off()
                if self.failure:
                    return
                write(self.data, k)
                yield self.done

    def _break_off(self) -> str:
        """Why the run's numbers are no longer valid; empty if they are."""
        bad = bad_number_warnings(self.data)
        if not bad and np.isfinite(self.data.qpos.sum() + self.data.qvel.sum()):
            return ""
        warned = f" ({', '.join(bad)})" if bad else ""
        return f"not finite{warned} at {self.done * self._step:.4g} s"


def run_in_space(start: SpatialStart, preset: str, steps: int, every: int = 1) -> SpatialRun:
    """Run a machine from its exact state, and record its points at the start and after each `every` steps."""
    stepper = MuJoCoSpatialStepper(start, preset)
    model, aside = stepper.model, mujoco.MjData(stepper.model)
    rows = [points_at(model, stepper.data, aside, stepper.sites) for done in stepper.states(steps) if done % every == 0]
    times = start.step * every * np.arange(len(rows), dtype=float)
    moved = np.array(rows).transpose(1, 2, 0, 3)
    return SpatialRun(times, dict(zip(start.points, moved, strict=True)), stepper.failure)


def points_at(model: mujoco.MjModel, data: mujoco.MjData, aside: mujoco.MjData, sites: list[int]) -> Array:
    """Position, velocity and acceleration (S, 3, 3) of some sites, at the instant of the state.

    What `mj_step` leaves of them does not belong together: they are computed from the state in other data.
    """
    state = np.empty(mujoco.mj_stateSize(model, INTEGRATION))
    mujoco.mj_getState(model, data, state, INTEGRATION)
    mujoco.mj_setState(model, aside, state, INTEGRATION)
    mujoco.mj_forward(model, aside)
    mujoco.mj_rnePostConstraint(model, aside)
    found, six = np.empty((len(sites), 3, 3)), np.empty(6)
    for one, site in zip(found, sites, strict=True):
        one[0] = aside.site_xpos[site]
        mujoco.mj_objectVelocity(model, aside, SITE, site, six, 0)
        one[1] = six[3:]
        mujoco.mj_objectAcceleration(model, aside, SITE, site, six, 0)
        one[2] = six[3:] + model.opt.gravity  # an accelerometer's: what rests reads the reaction to gravity
    return found
