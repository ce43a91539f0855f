"""What errors of forces are judged by.

No law of an engine gives a bound on them, as one does for its motion: they are judged by what is required of an
engine at 1000 steps a revolution. With fewer the bar is as much higher as the order of the engine's scheme makes the
error; with more it stays.
"""

from __future__ import annotations

from collections.abc import Mapping

from conrod.mechanism import Mechanism

STEPS = 1000
REQUIRED: Mapping[tuple[str, str], Mapping[str, float]] = {
    ("mujoco", "hardened"): {"torque": 1e-7, "reactions": 1e-6},
    ("pymunk", "tuned"): {"torque": 1e-3, "reactions": 1e-3},
}
ORDERS = {"mujoco": 4, "pymunk": 2}
CONTACT, JUDGED_CONTACT = 0.02, "tuned"
AS_ASKED = "as asked for"


def tolerance_of(
    mechanism: Mechanism, engine: str, preset: str, steps: int, groups: Mapping[str, object], asked: Mapping[str, float]
) -> tuple[dict[str, float], str]:
    """By group what is allowed, and why; nothing of presets of which nothing is required.

    Args:
        groups: those that are looked at.
        asked: what the user allows, by group; then nothing else is judged.
    """
    if asked:
        return {group: value for group, value in asked.items() if group in groups}, AS_ASKED
    if mechanism.cam_contacts:
        # Where the acceleration jumps all forces do: their largest errors are one step of the jump.
        if preset != JUDGED_CONTACT or "contact" not in groups:
            return {}, ""
        return {"contact": CONTACT}, "required of the contact force: 2 % rms between the cam's arc joints"
    bars = REQUIRED.get((engine, preset), {})
    coarser = max(1.0, STEPS / steps) ** ORDERS.get(engine, 0)
    allowed = {group: bar * coarser for group, bar in bars.items() if group in groups}
    told = ", ".join(f"{group} {bars[group]:g}" for group in allowed)
    reason = f"required at {STEPS} steps a revolution: {told}, of the exact peak" if allowed else ""
    return allowed, reason + (
        f"; at {steps} times {coarser:.3g}, by order {ORDERS[engine]}" if coarser > 1.0 and allowed else ""
    )
