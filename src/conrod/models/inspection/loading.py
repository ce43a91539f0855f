"""Does it load? A model with all that its motion needs, and what had to be left out."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np

from conrod.errors import list_names
from conrod.mjcf.equalities import equality_kind
from conrod.mjcf.loading import check_finite, name_or_number
from conrod.mjcf.missing_files import load_with_notes
from conrod.mjcf.unknown_names import XML_ERRORS
from conrod.models.inspection.results import InspectionRequest, Loading

MAX_PART = 5.0  # [m]: longest part of a machine that is not asked about
MAX_DENSITY = 23e3  # [kg/m^3], of a cube as large as the model: nothing is denser than osmium, at 22 600
URDF = ".urdf"
PLANE = int(mujoco.mjtGeom.mjGEOM_PLANE)


def load_for_inspection(path: Path, question: InspectionRequest) -> tuple[mujoco.MjModel, Loading]:
    """Load a model without missing assets and plugins, and describe its content.

    Raises:
        InvalidInput: the file cannot be used; says why.
    """
    model, left_out = load_with_notes(path, question.unit)
    check_finite(model)
    lost = tuple(lost_in_translation(path, model)) if path.suffix.lower() == URDF else ()
    remarks = (*lost, *unit_questions(model, question.unit))
    likely = "mm" if question.unit == 1.0 and longest_part(model)[1] > MAX_PART else ""
    return model, replace(describe_model(model), left_out=left_out, remarks=remarks, likely_unit=likely)


def describe_model(model: mujoco.MjModel) -> Loading:
    """Count a model's parts, and measure it in its reference pose."""
    return Loading(
        model.nbody - 1,
        model.njnt,
        model.neq,
        model.nu,
        distance_across(model),
        float(model.body_mass.sum()),
    )


def distance_across(model: mujoco.MjModel) -> float:
    """Diagonal of the box about all movable bodies, their joints, geoms and sites in the reference pose [m]."""
    data = mujoco.MjData(model)
    mujoco.mj_kinematics(model, data)
    moving = np.flatnonzero(model.body_dofnum[model.body_weldid])
    geoms, sites, joints = (np.isin(of, moving) for of in (model.geom_bodyid, model.site_bodyid, model.jnt_bodyid))
    turns = data.geom_xmat[geoms].reshape(-1, 3, 3)
    centres = data.geom_xpos[geoms] + np.einsum("gij,gj->gi", turns, model.geom_aabb[geoms, :3])
    halves = np.einsum("gij,gj->gi", np.abs(turns), model.geom_aabb[geoms, 3:])
    places = [data.xpos[moving], data.xipos[moving], data.site_xpos[sites], data.xanchor[joints]]
    every = np.concatenate([*places, centres - halves, centres + halves])
    return float(np.linalg.norm(np.ptp(every, axis=0))) if len(every) else 0.0


# -- units -------------------------------------------------------------------------------------------------------------


def unit_questions(model: mujoco.MjModel, unit: float) -> Iterator[str]:
    """Yield questions on sizes, densities and gravity that are implausible in metres and kilograms.

    Args:
        unit: unit of the file's lengths [m].
    """
    name, length = longest_part(model)
    gravity = float(np.linalg.norm(model.opt.gravity))
    if length > MAX_PART:
        hint = f", as its gravity of {gravity:.4g} says" if 9e3 < gravity < 1.1e4 else ""
        yield f"{name} is {length:.3g} m long: is the model in millimetres{hint}? --unit mm says so"
        return  # masses of such a model say nothing yet
    if unit != 1.0 and 9.7 < gravity / unit < 9.9:
        yield f"its gravity is {gravity / unit:.4g}, in its unit of length: the Earth's would be {9.81 / unit:.5g}"
    mass, room = float(model.body_mass.sum()), distance_across(model) ** 3
    if mass > MAX_DENSITY * room > 0.0:
        ask = "are its masses in kilograms?"
        if unit != 1.0 and mass * unit**3 < MAX_DENSITY * room:
            ask = f'1000 kg/m³ are density="{1000.0 * unit**3:.3g}" in its unit of length'
        yield f"it weighs {mass:.3g} kg, more than metal that fills it would: {ask}"


def longest_part(model: mujoco.MjModel) -> tuple[str, float]:
    """Name and length [m] of the longest body that moves; a length of 0 where none has a size."""
    lengths = {body: _length_of(model, body) for body in range(1, model.nbody)}
    longest = max(lengths, key=lambda body: lengths[body], default=0)
    name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, longest) or f"body {longest}"
    return name, lengths.get(longest, 0.0)


def _length_of(model: mujoco.MjModel, body: int) -> float:
    """Largest distance from a moved body's frame to a joint, site or child on it, or across a geom of it [m]."""
    if not model.body_dofnum[model.body_weldid[body]]:
        return 0.0
    children = model.body_pos[(model.body_parentid == body) & (np.arange(model.nbody) != 0)]
    sites = model.site_pos[model.site_bodyid == body]
    geoms = 2.0 * model.geom_aabb[(model.geom_bodyid == body) & (model.geom_type != PLANE), 3:]
    return max(
        (float(np.linalg.norm(place, axis=1).max()) for place in (children, sites, geoms) if len(place)), default=0.0
    )


# -- URDF --------------------------------------------------------------------------------------------------------------

# What MuJoCo reads of a URDF file is links, joints with limits of position and effort, damping and friction.
LOST_ELEMENTS = {
    "transmission": "no actuator is made of it",
    "safety_controller": "its soft limits are no limits",
    "gazebo": "what it says of friction, sensors and plugins is lost",
}


def lost_in_translation(path: Path, model: mujoco.MjModel) -> Iterator[str]:
    """Say what MuJoCo does not take over from a URDF file (MuJoCo documentation, Modeling: URDF extensions)."""
    coupled = {
        name_or_number(model, "joint", int(model.eq_obj1id[k]))
        for k in range(model.neq)
        if equality_kind(model, k) == "joint"
    }
    try:
        root = ET.parse(path).getroot()
    except XML_ERRORS:
        return
    joints = root.findall("joint")
    yield "from URDF: no actuators, and no loops but of mimic joints; its root stands still without a floating joint"
    for joint in joints:
        # MuJoCo 4 makes an equality of it, older releases nothing.
        if (mimic := joint.find("mimic")) is not None and joint.get("name") not in coupled:
            offset, factor = mimic.get("offset", "0"), mimic.get("multiplier", "1")
            name, leader = joint.get("name"), mimic.get("joint")
            made = f'<joint joint1="{name}" joint2="{leader}" polycoef="{offset} {factor} 0 0 0"/>'
            yield f"{name} does not follow {leader}: <equality>{made}</equality> in MJCF makes it"
    fast = [joint.get("name", "") for joint in joints for one in joint.findall("limit") if _limits_velocity(one)]
    if fast:
        yield f"velocity limits of {list_names(fast, 4)} are lost: MuJoCo has none; effort limits bound its actuators"
    for tag, words in LOST_ELEMENTS.items():
        if count := len(list(root.iter(tag))):
            yield f"{count} <{tag}>: {words}"


def _limits_velocity(limit: ET.Element) -> bool:
    """True if a joint's limit has a velocity, be it one that a macro was to fill in."""
    velocity = limit.get("velocity") or "0"
    try:
        return float(velocity) != 0.0
    except ValueError:
        return True
