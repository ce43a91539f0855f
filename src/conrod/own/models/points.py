"""Elements that a user named in a model: the crank's hinge and the observed points."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.motion import Array
from conrod.own.models.loading import element_id, listed, names_of
from conrod.own.models.request import KINDS, Place

# XBODY is a body's frame; BODY would be its centre of gravity.
OBJECTS = {
    "site": int(mujoco.mjtObj.mjOBJ_SITE),
    "body": int(mujoco.mjtObj.mjOBJ_XBODY),
    "geom": int(mujoco.mjtObj.mjOBJ_GEOM),
}


@dataclass(frozen=True)
class Crank:
    """The hinge that is driven: its number, and where its coordinate and its rate are."""

    joint: int
    coordinate: int
    rate: int


@dataclass(frozen=True)
class FoundPoint:
    """A point of a compiled model: the frame of a site, a body or a geom."""

    name: str
    kind: str
    index: int
    body: int

    def position(self, data: mujoco.MjData) -> Array:
        """Its position (3,), in data whose kinematics are made."""
        places = data.site_xpos if self.kind == "site" else data.xpos if self.kind == "body" else data.geom_xpos
        return np.array(places[self.index])

    def jacobians(self, model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array]:
        """Derivatives of its position and of its link's turn by the joint rates, each (3, nv)."""
        along, about = np.empty((3, model.nv)), np.empty((3, model.nv))
        mujoco.mj_jac(model, data, along, about, self.position(data), self.body)
        return along, about

    def motion(self, model: mujoco.MjModel, data: mujoco.MjData) -> tuple[Array, Array, Array]:
        """Its position, velocity and acceleration, each (3,), in data that `mj_rnePostConstraint` has made."""
        velocity, acceleration = np.empty(6), np.empty(6)
        mujoco.mj_objectVelocity(model, data, OBJECTS[self.kind], self.index, velocity, 0)
        mujoco.mj_objectAcceleration(model, data, OBJECTS[self.kind], self.index, acceleration, 0)
        # It is an accelerometer's: what rests reads the reaction to gravity.
        fall = 0.0 if model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_GRAVITY else np.array(model.opt.gravity)
        return self.position(data), velocity[3:], acceleration[3:] + fall


def joint_kind(model: mujoco.MjModel, joint: int) -> str:
    """Kind of a joint: hinge, slide, ball or free."""
    return str(mujoco.mjtJoint(int(model.jnt_type[joint])).name).removeprefix("mjJNT_").lower()


def find_crank(model: mujoco.MjModel, name: str) -> Crank:
    """The hinge of a name.

    Raises:
        InvalidInput: there is none, or it is no hinge.
    """
    joint = element_id(model, "joint", name)
    if (kind := joint_kind(model, joint)) != "hinge":
        hinges = [n for n in names_of(model, "joint") if joint_kind(model, model.joint(n).id) == "hinge"]
        choices = f"; its hinges: {listed(hinges)}" if hinges else "; it has no hinge with a name"
        raise InvalidInput(f"--crank {name}: it is a {kind} joint, a crank is a hinge{choices}")
    return crank_of(model, joint)


def crank_of(model: mujoco.MjModel, joint: int) -> Crank:
    """A hinge as a crank."""
    return Crank(joint, int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint]))


def find_point(model: mujoco.MjModel, place: Place) -> FoundPoint:
    """The point of a place.

    Raises:
        InvalidInput: the model has none of the name, or several of different kinds.
    """
    kind = place.kind or _only_kind(model, place)
    index = element_id(model, kind, place.element)
    body = index if kind == "body" else int((model.site_bodyid if kind == "site" else model.geom_bodyid)[index])
    return FoundPoint(place.point, kind, index, body)


def _only_kind(model: mujoco.MjModel, place: Place) -> str:
    found = [kind for kind in KINDS if place.element in names_of(model, kind)]
    if len(found) > 1:
        raise InvalidInput(
            f"--point {place.point}={place.element}: there is a {' and a '.join(found)} of that name; "
            f"say which: {place.point}={found[0]}:{place.element}"
        )
    if not found:
        every = {name for kind in KINDS for name in names_of(model, kind)}
        raise unknown_choice("site, body or geom", place.element, every)
    return found[0]
