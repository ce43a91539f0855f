"""Load and check a user's own model: finite numbers, keyframes, named elements, crank and observed points."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from conrod.engines.mujoco.dynamics import silence_warnings
from conrod.errors import InvalidInput, list_names, unknown_choice
from conrod.exact.motion import Array
from conrod.mechanism.units import check_number
from conrod.mjcf.request import Controls, PointPlace
from conrod.mjcf.unknown_names import malformed_xml_words, unknown_name_words
from conrod.user_files.files import check_readable

COUNT_FIELDS = {"joint": "njnt", "equality": "neq", "actuator": "nu"}
TIMESTEP_RANGE = (1e-12, 1e6)  # [s], that MuJoCo's clock and a run's number of steps have room for


def check_finite(model: mujoco.MjModel) -> None:
    """Refuse a model with a number that is not finite, which MuJoCo compiles without a warning.

    Raises:
        InvalidInput: names the field.
    """
    check_number("timestep", float(model.opt.timestep), *TIMESTEP_RANGE, "s")
    if not np.all(np.isfinite(model.opt.gravity)):
        raise InvalidInput("gravity is not finite")
    # Places and axes first: what the compiler makes of them is as little a number.
    for field in sorted(
        (name for name in dir(model) if not name.startswith("_")), key=lambda n: not n.endswith(("_pos", "_axis"))
    ):
        values = getattr(model, field)
        if isinstance(values, np.ndarray) and values.dtype.kind == "f" and not np.all(np.isfinite(values)):
            raise InvalidInput(f"{field} is not finite")


# What a user names the model's own pose, after MuJoCo's field.
OWN_POSE = "qpos0"


def names_of(model: mujoco.MjModel, kind: str) -> list[str]:
    """Names of all elements of a kind, in order; empty for an element without a name.

    Args:
        kind: kind of object, as MuJoCo names it: body, joint, site, geom, equality, key, actuator.
    """
    kind_id = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
    count = getattr(model, COUNT_FIELDS.get(kind, f"n{kind}"))
    return [mujoco.mj_id2name(model, kind_id, index) or "" for index in range(count)]


def names_or_numbers(names: Iterable[str]) -> list[str]:
    """Replace empty names by their number."""
    return [name or str(index) for index, name in enumerate(names)]


def keyframe_to_start_from(model: mujoco.MjModel, given: str | None) -> int | None:
    """Index of the keyframe to start from; None for the model's reference pose.

    Args:
        given: a keyframe's name or number, or `OWN_POSE`; None for the first keyframe, or the own pose without any.

    Raises:
        InvalidInput: the model has no such keyframe; names the nearest.
    """
    names = names_or_numbers(names_of(model, "key"))
    if given is None:
        return 0 if names else None
    if given in names:
        return names.index(given)
    if given == OWN_POSE:
        return None
    if given.isdecimal() and int(given) < len(names):
        return int(given)
    raise unknown_choice("keyframe", given, [*names, OWN_POSE])


def data_at_start(
    model: mujoco.MjModel, keyframe: str | None, controls: Controls = ()
) -> tuple[mujoco.MjData, int | None]:
    """MuJoCo data at a start, and the index of its keyframe; None for the model's reference pose.

    Args:
        keyframe: as in `keyframe_to_start_from`.
        controls: controls that replace those of the keyframe.

    Raises:
        InvalidInput: the model has no such keyframe or actuator, or MuJoCo would clamp a control.
    """
    data, index = mujoco.MjData(model), keyframe_to_start_from(model, keyframe)
    if index is not None:
        mujoco.mj_resetDataKeyframe(model, data, index)
    names = names_or_numbers(names_of(model, "actuator"))
    clamps = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_CLAMPCTRL
    for name, value in controls:
        if not names:
            raise InvalidInput(f"--ctrl {name}: the model has no actuator")
        if name not in names and not (name.isdecimal() and int(name) < len(names)):
            raise unknown_choice("actuator", name, names)
        actuator = names.index(name) if name in names else int(name)
        low, high = model.actuator_ctrlrange[actuator]
        if clamps and model.actuator_ctrllimited[actuator] and not low <= value <= high:
            raise InvalidInput(f"--ctrl {name}={value:g}: MuJoCo clamps it to its ctrlrange, {low:g} to {high:g}")
        data.ctrl[actuator] = value
    return data, index


def start_words(model: mujoco.MjModel, keyframe: int | None, controls: Iterable[float] = ()) -> str:
    """Describe a start, as 'keyframe start with motor = 4.19', with the controls (nu,) that are not 0."""
    words = "its own pose" if keyframe is None else f"keyframe {names_or_numbers(names_of(model, 'key'))[keyframe]}"
    actuators = names_or_numbers(names_of(model, "actuator"))
    inputs = [f"{name} = {value:.6g}" for name, value in zip(actuators, controls, strict=False) if value]
    return f"{words} with {list_names(inputs)}" if inputs else words


def check_model_path(path: Path) -> None:
    """Refuse a path that is no readable file, or that MuJoCo cannot open.

    Raises:
        InvalidInput: says why.
    """
    check_readable(path)
    if str(path) != os.fsencode(path).decode(errors="replace"):
        raise InvalidInput(f"{path}: its name is no UTF-8, and MuJoCo cannot open it: rename it")


def load_model(path: Path) -> mujoco.MjModel:
    """Load and compile an MJCF, URDF or binary model file.

    To be called in a process of its own, see `conrod.execution.local`: the engine may abort on what
    it is given.

    Raises:
        InvalidInput: the file is missing, does not parse or compile, or includes a missing file.
    """
    check_model_path(path)
    with silence_warnings():
        try:
            if path.suffix.lower() == ".mjb":
                return mujoco.MjModel.from_binary_path(str(path))
            return mujoco.MjModel.from_xml_path(str(path))
        except ValueError as error:
            said = unknown_name_words(path, str(error)) or malformed_xml_words(path, str(error))
            said = said or f"MuJoCo cannot load it: {' '.join(str(error).split())}"
            raise InvalidInput(f"{path}: {said}") from None


def element_id(model: mujoco.MjModel, kind: str, name: str) -> int:
    """Index of a named element of a kind, as in `names_of`.

    Raises:
        InvalidInput: no element of the kind has the name; names the nearest.
    """
    names = names_of(model, kind)
    if not name or name not in names:
        raise unknown_choice(kind, name, filter(None, names))
    return names.index(name)


def name_or_number(model: mujoco.MjModel, kind: str, index: int) -> str:
    """An element's name, or its number where it has none."""
    kind_id = getattr(mujoco.mjtObj, f"mjOBJ_{kind.upper()}")
    return mujoco.mj_id2name(model, kind_id, index) or f"{kind} {index}"


# -- crank and points ------------------------------------------------------------------------------------------------

# XBODY is a body's frame; BODY would be its centre of gravity.
POINT_OBJECTS = {
    "site": int(mujoco.mjtObj.mjOBJ_SITE),
    "body": int(mujoco.mjtObj.mjOBJ_XBODY),
    "geom": int(mujoco.mjtObj.mjOBJ_GEOM),
}
NO_GRAVITY = int(mujoco.mjtDisableBit.mjDSBL_GRAVITY)


@dataclass(frozen=True)
class FoundPoint:
    """A point of a compiled model: the frame of a site, a body or a geom, or a point at an offset from it.

    Attributes:
        offset: of the point from the frame, along the axes of the body's frame [m]; only bodies have one.
    """

    name: str
    kind: str
    index: int
    body: int
    offset: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def position(self, data: mujoco.MjData) -> Array:
        """Position (3,), in data whose kinematics are computed."""
        places = data.site_xpos if self.kind == "site" else data.xpos if self.kind == "body" else data.geom_xpos
        return np.array(places[self.index]) + (self._arm(data) if any(self.offset) else 0.0)

    def _arm(self, data: mujoco.MjData) -> Array:
        """The offset (3,) along the axes of the world."""
        return np.asarray(data.xmat[self.body].reshape(3, 3) @ np.array(self.offset))

    def motion(self, model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array, Array]:
        """Position, velocity and acceleration, each (3,), in data after `mj_rnePostConstraint`."""
        velocity, acceleration = np.empty(6), np.empty(6)
        mujoco.mj_objectVelocity(model, data, POINT_OBJECTS[self.kind], self.index, velocity, 0)
        mujoco.mj_objectAcceleration(model, data, POINT_OBJECTS[self.kind], self.index, acceleration, 0)
        # It is an accelerometer's: what rests reads the reaction to gravity.
        fall = 0.0 if model.opt.disableflags & NO_GRAVITY else model.opt.gravity
        if not any(self.offset):
            return self.position(data), velocity[3:], acceleration[3:] + fall
        # Of a point beside the frame: v + w x r, and a + w' x r + w x (w x r).
        arm = self._arm(data)
        moved = np.cross(velocity[:3], arm)
        bent = np.cross(acceleration[:3], arm) + np.cross(velocity[:3], moved)
        return self.position(data), velocity[3:] + moved, acceleration[3:] + bent + fall


def joint_kind(model: mujoco.MjModel, joint: int) -> str:
    """Kind of a joint: hinge, slide, ball or free."""
    return str(mujoco.mjtJoint(int(model.jnt_type[joint])).name).removeprefix("mjJNT_").lower()


def find_crank(model: mujoco.MjModel, name: str) -> int:
    """Index of the hinge that is the crank.

    Raises:
        InvalidInput: no joint has the name, or the joint is no hinge.
    """
    joint = element_id(model, "joint", name)
    if (kind := joint_kind(model, joint)) != "hinge":
        hinges = [n for j, n in enumerate(names_of(model, "joint")) if n and joint_kind(model, j) == "hinge"]
        choices = f"; its hinges: {list_names(hinges)}" if hinges else "; it has no hinge with a name"
        raise InvalidInput(f"--crank {name}: it is a {kind} joint, a crank is a hinge{choices}")
    return joint


def find_point(model: mujoco.MjModel, place: PointPlace) -> FoundPoint:
    """Find an observed point in a model.

    Raises:
        InvalidInput: no element of the kind has the name.
    """
    kind, index = place.kind, element_id(model, place.kind, place.element)
    body = index if kind == "body" else int((model.site_bodyid if kind == "site" else model.geom_bodyid)[index])
    return FoundPoint(place.point, kind, index, body)
