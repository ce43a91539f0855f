"""Machines that axes make of a scene, and why a scene has none: masses, units, change points, orders, cams."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TypeVar

from conrod.exact.linkage import output_links
from conrod.exact.linkage.crank_range import sample_motion
from conrod.mechanism.mechanism import GROUND, Mechanism, Revolute
from conrod.scenes import CamFollower, Saw, Scene, ShearPress
from conrod.scenes.cam_follower import FLANK_RADIUS_ROUNDING
from conrod.studies.limits.case import Setup

MM = 1e-3  # [m]
SCENES_KEPT = 16

# -- masses and units ------------------------------------------------------------------------------------------------


def with_mass_ratio(setup: Setup, ratio: float) -> Scene:
    """Return the machine whose output link has so many times the mass of the rod that drives it."""
    rod, mass = driving_rod(setup.scene), output_mass(setup.scene)
    assert rod is not None
    assert mass is not None
    return setup.variant(**{mass: ratio * setup.mechanism.body(rod).mass})


def no_mass_ratio(setup: Setup) -> str | None:
    """Return None, or what a machine lacks for unequal masses of rod and output link."""
    if driving_rod(setup.scene) is None:
        return f"the {setup.scene.kind} has no connecting rod"
    if output_mass(setup.scene) is None:
        return f"{setup.scene.kind}: the mass of the link with the output point is no parameter"
    return None


def driving_rod(scene: Scene) -> str | None:
    """Return the link that is pinned to the one with the output point, and is neither crank nor ground."""
    mechanism = scene.kinematics.mechanism
    link = next(observed.body for observed in mechanism.observed if observed.name == scene.output)
    pins = [joint for joint in mechanism.joints if isinstance(joint, Revolute) and link in (joint.a, joint.b)]
    partners = [joint.b if joint.a == link else joint.a for joint in pins]
    return next((name for name in partners if name not in (GROUND, mechanism.crank)), None)


def output_mass(scene: Scene) -> str | None:
    """Return the parameter that is the mass of the link which carries the scene's output point; None for none.

    It is found by what it does: of the parameters in kg, the one that moves this link's mass and no other's.
    """
    mechanism = scene.mechanism()
    link = next(observed.body for observed in mechanism.observed if observed.name == scene.output)
    for parameter in (p for p in scene.parameter_facts().values() if p.unit == "kg"):
        value = scene.parameters[parameter.name]
        other = 0.5 * value if 2.0 * value > parameter.highest else 2.0 * value
        changed = scene.with_parameters(**{parameter.name: other}).mechanism()
        if [b.name for b in mechanism.bodies if changed.body(b.name).mass != b.mass] == [link]:
            return parameter.name
    return None


WITH_A_METRE = ("m", "N")  # a newton is one kilogram metre over a square second


def rescaled(scene: Scene, factor: float) -> dict[str, float]:
    """Return the parameters of a scene whose unit of length is `factor` times smaller; masses and times keep theirs."""
    facts = scene.parameter_facts()
    return {name: value * factor ** length_power(facts[name].unit) for name, value in scene.parameters.items()}


def length_power(unit: str) -> int:
    """Return the power of metre in a unit such as kg*m^2 or m/s^2."""
    power = 0
    for sign, product in zip((1, -1, -1), unit.split("/"), strict=False):
        for name, _, exponent in (term.partition("^") for term in product.split("*")):
            power += sign * int(exponent or 1) if name in WITH_A_METRE else 0
    return power


# -- change points and poses -----------------------------------------------------------------------------------------


def near_change_point(setup: Setup, nearness: float) -> Scene:
    """Return the machine whose length is so much of its limit: the one length that has to change, and alone does.

    A press' crank as long as the rod: the slider could stand still on the shaft while both turn together. A saw's
    offset as large as rod - crank: the rod stands across the slide when the crank points away from it.
    """
    p = setup.scene.parameters
    if isinstance(setup.scene, ShearPress):
        return setup.variant(crank=nearness * p["rod"])
    return setup.variant(offset=math.copysign(nearness * (p["rod"] - p["crank"]), p["offset"]))


def no_change_point(setup: Setup) -> str | None:
    """Return None, or why a machine is not brought to a change point."""
    known = isinstance(setup.scene, ShearPress | Saw)
    return None if known else f"which lengths bring the {setup.scene.kind} to a change point is not known"


@lru_cache(SCENES_KEPT)
def dead_angles(scene: Scene) -> tuple[float, ...]:
    """Return the crank angles [deg] of the dead centres, where a driven link turns back without a dwell."""
    centres = [centre for output in output_links(sample_motion(scene.kinematics)) for centre in output.dead_centres]
    return tuple(sorted({math.degrees(centre.angle) for centre in centres if centre.angle == centre.until}))


# -- order of declaration --------------------------------------------------------------------------------------------


def orders(setup: Setup, most: int) -> tuple[float, ...]:
    """Return numbers of orders of declaration: all, or `most` evenly spread, the last of which reverses everything."""
    last = math.factorial(len(setup.mechanism.bodies)) * math.factorial(len(setup.mechanism.joints)) - 1
    count = min(most, last + 1)
    return tuple(dict.fromkeys(float(round(k * last / max(count - 1, 1))) for k in range(count)))


def declared(setup: Setup, number: float) -> Mechanism:
    """Return the mechanism in the order of declaration of a number; 0 is the scene's own."""
    of_bodies, of_joints = divmod(round(number), math.factorial(len(setup.mechanism.joints)))
    bodies, joints = permutation(setup.mechanism.bodies, of_bodies), permutation(setup.mechanism.joints, of_joints)
    return replace(setup.mechanism, bodies=bodies, joints=joints)


Element = TypeVar("Element")


def permutation(elements: Sequence[Element], number: int) -> tuple[Element, ...]:
    """Return the permutation of a number: 0 leaves all in place, the last reverses them (factorial number system)."""
    left, chosen = list(elements), []
    for size in range(len(elements), 0, -1):
        place, number = divmod(number, math.factorial(size - 1))
        chosen.append(left.pop(place))
    return tuple(chosen)


# -- cams ------------------------------------------------------------------------------------------------------------

LEAST_EXCESS = FLANK_RADIUS_ROUNDING / MM  # [mm]
ONE_CIRCLE = LEAST_EXCESS * 1.001  # [mm]; rounding of the scene's own radius must not decide which cam it is
PRELOAD = "preload"  # force on the follower over (its mass x its largest downward acceleration at the scene's speed)


def flank_excess(setup: Setup) -> float:
    """Return the scene's own flank radius over the least one [mm]."""
    assert isinstance(setup.scene, CamFollower)
    return (setup.scene.flank_radius - setup.scene.least_flank_radius) / MM


def with_flank(setup: Setup, excess: float) -> Scene:
    """Return the cam whose flank radius exceeds the least one by so much [mm]."""
    assert isinstance(setup.scene, CamFollower)
    over = excess * MM if excess > ONE_CIRCLE else 0.0
    return setup.variant(flank_radius=setup.scene.least_flank_radius + over)


def no_flank(setup: Setup) -> str | None:
    """Return None, or why a flank radius is not varied."""
    if isinstance(setup.scene, CamFollower) and setup.scene.is_one_circle:
        return f"the {setup.scene.kind} has its least flank radius already"
    return no_such_cam(setup)


def with_nose(setup: Setup, radius: float) -> Scene:
    """Return the cam with a nose radius [mm]; the nose's centre moves out, so that lift and least flank radius stay."""
    assert isinstance(setup.scene, CamFollower)
    nose = radius * MM
    return setup.variant(nose_radius=nose, centre_distance=setup.scene.full_lift + setup.scene.base_radius - nose)


def no_such_cam(setup: Setup) -> str | None:
    """Return None, or why a radius of the cam that ships is not varied on another machine."""
    known = isinstance(setup.scene, CamFollower)
    return None if known else f"which radii of a cam of the {setup.scene.kind} go together is not known"


def at_float_speed(setup: Setup, share: float) -> Scene:
    """Return the cam turning at a share of the float speed, its follower held by the same force.

    Accelerations grow with the square of the speed, so at s times the float speed the preload is 1 / s^2.
    """
    speed = share * (setup.scene.speed * math.sqrt(setup.scene.parameters[PRELOAD]))
    return setup.variant(speed=speed, **{PRELOAD: 1.0 / share**2})


def no_float(setup: Setup) -> str | None:
    """Return None, or why a machine has no float speed."""
    held = setup.scene.parameters.get(PRELOAD, 0.0) > 0.0
    return None if held else f"the {setup.scene.kind} has no follower that a force holds down"
