"""Which cams engines are given as contact: what their laws of contact and the placing of the follower are made for."""

from __future__ import annotations

from conrod.cam_shape import concave_reason
from conrod.mechanism import GROUND, CamContact, Mechanism, Prismatic

WANTED = "contact is derived for one cam, on the crank, and one follower on a slide of the ground"
CAM_AND_FOLLOWER = 2


def contact_refusal(mechanism: Mechanism) -> str | None:
    """None, or why a mechanism's cam is solved exactly but given to no engine; None too where there is no cam."""
    for contact in mechanism.cam_contacts:
        reason = concave_reason(contact.profile)
        if reason is None and (otherwise := _otherwise(mechanism, contact)):
            reason = f"{WANTED}; {otherwise}"
        if reason:
            return reason
    return None


def _otherwise(mechanism: Mechanism, contact: CamContact) -> str | None:
    """What is not as wanted."""
    if contact.a != mechanism.crank:
        return f"the cam of {contact.name} is on {contact.a}"
    slides = [j for j in mechanism.joints if isinstance(j, Prismatic) and {j.a, j.b} == {GROUND, contact.b}]
    if not slides:
        return f"the follower {contact.b} is on no such slide"
    if slides[0].a != GROUND:
        return f"the guide of {slides[0].name} is on the follower: name the line on the ground as the guide"
    if len(mechanism.bodies) != CAM_AND_FOLLOWER:
        return f"here {len(mechanism.bodies)} bodies move"
    return None
