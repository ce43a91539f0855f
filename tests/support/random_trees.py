"""Trees of MuJoCo bodies drawn at random: every joint kind, several joints in a body, anchors and frames anywhere."""

from __future__ import annotations

import mujoco
import numpy as np

from conrod.exact.motion import Array

# Joints of a body as MuJoCo allows them: a ball comes after hinges, and no body has more than six freedoms.
JOINTS = (
    ("hinge",), ("slide",), ("ball",), (), ("hinge", "hinge"), ("slide", "hinge"), ("hinge", "slide", "hinge"),
    ("hinge", "ball"), ("ball", "slide"), ("slide", "slide", "slide", "hinge", "hinge", "hinge"),
)  # fmt: skip


def random_tree(seed: int, bodies: int = 7, equality: str = "", tendon: str = "") -> mujoco.MjModel:
    """A tree with a floating body, a mocap body and sites S1, S2, ... on its bodies B1, B2, ..."""
    draw = np.random.default_rng(seed)
    text = f'<body name="hand" mocap="true" {_frame(draw)}><site name="S0" {_frame(draw)}/></body>'
    text += f'<body name="float" {_frame(draw)}><freejoint name="float"/>{_mass(draw)}<site name="SF" {_frame(draw)}/>'
    text += f'<body name="F1" {_frame(draw)}><joint name="F1" {_joint(draw, "hinge")}/>{_mass(draw)}</body></body>'
    open_bodies = 0
    for number in range(1, bodies + 1):
        kinds = JOINTS[draw.integers(len(JOINTS))]
        text += f'<body name="B{number}" {_frame(draw)}>{_mass(draw)}<site name="S{number}" {_frame(draw)}/>'
        text += "".join(f'<joint name="B{number}{k}" {_joint(draw, kind)}/>' for k, kind in enumerate(kinds))
        open_bodies += 1
        while open_bodies and draw.random() < 0.4:
            text, open_bodies = text + "</body>", open_bodies - 1
    text += "</body>" * open_bodies
    return mujoco.MjModel.from_xml_string(
        f'<mujoco><compiler angle="radian"/><option gravity="{_text(draw.normal(size=3))}"/>'
        f"<worldbody>{text}</worldbody><tendon>{tendon}</tendon><equality>{equality}</equality></mujoco>"
    )


def random_state(model: mujoco.MjModel, seed: int) -> tuple[Array, Array, Array]:
    """Coordinates, rates and accelerations of all joints."""
    draw = np.random.default_rng(seed)
    coordinates = draw.normal(size=model.nq)
    mujoco.mj_normalizeQuat(model, coordinates)
    return coordinates, draw.normal(size=model.nv), draw.normal(size=model.nv)


def _text(values: Array) -> str:
    return " ".join(repr(float(value)) for value in values)


def _frame(draw: np.random.Generator) -> str:
    return f'pos="{_text(0.3 * draw.normal(size=3))}" quat="{_text(draw.normal(size=4))}"'


def _mass(draw: np.random.Generator) -> str:
    size = draw.uniform(0.1, 2.0)
    inertia = size * np.array([0.01, 0.012, 0.02]) * draw.uniform(0.9, 1.1)
    return f'<inertial {_frame(draw)} mass="{size}" diaginertia="{_text(inertia)}"/>'


def _joint(draw: np.random.Generator, kind: str) -> str:
    place, axis = f'pos="{_text(0.2 * draw.normal(size=3))}"', f'axis="{_text(draw.normal(size=3))}"'
    made = f'type="{kind}" {place}' + (f' {axis} ref="{draw.normal()}"' if kind in ("hinge", "slide") else "")
    own = f'armature="{draw.uniform(0, 0.1)}" damping="{draw.uniform(0, 0.5)}"'
    spring = f' stiffness="{draw.uniform(0, 5)}" springref="{draw.normal()}"' if kind in ("hinge", "slide") else ""
    return f"{made} {own}{spring}"
