"""Names of the quantities of a machine's forces, and the groups that a user asks for."""

from __future__ import annotations

from conrod.dynamics.inverse import component_names
from conrod.dynamics.sensitivity import TORQUE
from conrod.mechanism import CamContact, Mechanism

GROUPS = ("torque", "reactions", "contact")


def quantities_of(mechanism: Mechanism, group: str) -> tuple[str, ...]:
    """The quantities of a group: "drive torque", or "joint.component".

    The push between cam and roller is the contact; reactions are what all other joints carry.
    """
    if group == "torque":
        return (TORQUE,)
    return tuple(
        f"{joint.name}.{name}"
        for joint in mechanism.joints
        if isinstance(joint, CamContact) == (group == "contact")
        for name in component_names(joint)
    )


def groups_of(mechanism: Mechanism, asked: tuple[str, ...]) -> tuple[str, ...]:
    """Those of the groups asked for that the machine has."""
    return tuple(group for group in asked if quantities_of(mechanism, group))
