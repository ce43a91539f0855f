"""Variants of a scene: masses, units, change points, order of declaration, cams."""

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

MILLIMETRE = 1e-3  # [m]
MAX_CACHED_SCENES = 16

# -- masses and units ------------------------------------------------------------------------------------------------


def with_mass_ratio(setup: Setup, ratio: float) -> Scene:
    """Return the machine with a ratio of the output link's mass to the driving rod's."""
    rod, mass = driving_rod(setup.scene), output_mass(setup.scene)
    assert rod is not None
    assert mass is not None
    return setup.variant(**{mass: ratio * setup.mechanism.body(rod).mass})


def mass_ratio_refusal(setup: Setup) -> str | None:
    """Return why a machine's mass ratio cannot be varied, None if it can."""
    if driving_rod(setup.scene) is None:
        return f"the {setup.scene.kind} has no connecting rod"
    if output_mass(setup.scene) is None:
        return f"{setup.scene.kind}: the mass of the link with the output point is no parameter"
    return None


def driving_rod(scene: Scene) -> str | None:
    """Return the link, not crank or ground, that is pinned to the output link, or None."""
    mechanism = scene.kinematics.mechanism
    link = next(observed.body for observed in mechanism.observed if observed.name == scene.output)
    pins = [joint for joint in mechanism.joints if isinstance(joint, Revolute) and link in (joint.a, joint.b)]
    partners = [joint.b if joint.a == link else joint.a for joint in pins]
    return next((name for name in partners if name not in (GROUND, mechanism.crank)), None)


def output_mass(scene: Scene) -> str | None:
    """Return the parameter that is the output link's mass; None if missing.

    It is found by its effect: of the parameters in kg, the one that changes the mass of this link and of no other.
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


UNITS_WITH_METRE = ("m", "N")  # a newton is one kilogram metre over a square second


def rescaled_parameters(scene: Scene, factor: float) -> dict[str, float]:
    """Return a scene's parameters in a unit of length `factor` times smaller.

    The units of mass and time stay kg and s.
    """
    facts = scene.parameter_facts()
    return {name: value * factor ** length_power(facts[name].unit) for name, value in scene.parameters.items()}


def length_power(unit: str) -> int:
    """Return the power of metre in a unit such as kg*m^2 or m/s^2."""
    power = 0
    for sign, product in zip((1, -1, -1), unit.split("/"), strict=False):
        for name, _, exponent in (term.partition("^") for term in product.split("*")):
            power += sign * int(exponent or 1) if name in UNITS_WITH_METRE else 0
    return power


# -- change points and poses -----------------------------------------------------------------------------------------


def with_change_point_nearness(setup: Setup, nearness: float) -> Scene:
    """Return the machine with one length at a share of its limit, where it has a change point.

    A press has one if crank = rod: the slider may rest on the crankshaft while crank and rod rotate together. A saw has
    one if offset = rod - crank: the rod is perpendicular to the slide when the crank points away from it.
    """
    p = setup.scene.parameters
    if isinstance(setup.scene, ShearPress):
        return setup.variant(crank=nearness * p["rod"])
    return setup.variant(offset=math.copysign(nearness * (p["rod"] - p["crank"]), p["offset"]))


def change_point_refusal(setup: Setup) -> str | None:
    """Return why a machine has no known change point, None if it has one."""
    known = isinstance(setup.scene, ShearPress | Saw)
    return None if known else f"which lengths bring the {setup.scene.kind} to a change point is not known"


@lru_cache(MAX_CACHED_SCENES)
def dead_centre_angles(scene: Scene) -> tuple[float, ...]:
    """Return crank angles [deg] of dead centres without a dwell, where a driven link reverses."""
    centres = [centre for output in output_links(sample_motion(scene.kinematics)) for centre in output.dead_centres]
    return tuple(sorted({math.degrees(centre.angle) for centre in centres if centre.angle == centre.until}))


# -- order of declaration --------------------------------------------------------------------------------------------


def permutation_numbers(setup: Setup, max_count: int) -> tuple[float, ...]:
    """Return numbers of permutations of bodies and joints: of all, or of `max_count` of them.

    These are evenly spread over all, the first and the last included.
    """
    last = math.factorial(len(setup.mechanism.bodies)) * math.factorial(len(setup.mechanism.joints)) - 1
    count = min(max_count, last + 1)
    return tuple(dict.fromkeys(float(round(k * last / max(count - 1, 1))) for k in range(count)))


def reordered_mechanism(setup: Setup, number: float) -> Mechanism:
    """Return the mechanism with bodies and joints in the permutation of a number.

    Number 0 is the order of the scene.
    """
    of_bodies, of_joints = divmod(round(number), math.factorial(len(setup.mechanism.joints)))
    bodies, joints = (
        numbered_permutation(setup.mechanism.bodies, of_bodies),
        numbered_permutation(setup.mechanism.joints, of_joints),
    )
    return replace(setup.mechanism, bodies=bodies, joints=joints)


Element = TypeVar("Element")


def numbered_permutation(elements: Sequence[Element], number: int) -> tuple[Element, ...]:
    """Return the permutation of a number in the factorial number system.

    Number 0 is the identity, and the last number the reversal.
    """
    left, chosen = list(elements), []
    for size in range(len(elements), 0, -1):
        place, number = divmod(number, math.factorial(size - 1))
        chosen.append(left.pop(place))
    return tuple(chosen)


# -- cams ------------------------------------------------------------------------------------------------------------

MIN_FLANK_EXCESS = FLANK_RADIUS_ROUNDING / MILLIMETRE  # [mm]
MAX_ONE_CIRCLE_EXCESS = MIN_FLANK_EXCESS * 1.001  # [mm]; up to here a cam is one circle, in spite of rounding
PRELOAD = "preload"  # parameter: force on the follower / (its mass x largest downward acceleration at the speed)


def flank_excess(setup: Setup) -> float:
    """Excess [mm] of the scene's flank radius over the least one."""
    assert isinstance(setup.scene, CamFollower)
    return (setup.scene.flank_radius - setup.scene.least_flank_radius) / MILLIMETRE


def with_flank_excess(setup: Setup, excess: float) -> Scene:
    """Return the cam whose flank radius is the least one plus an excess [mm]."""
    assert isinstance(setup.scene, CamFollower)
    over = excess * MILLIMETRE if excess > MAX_ONE_CIRCLE_EXCESS else 0.0
    return setup.variant(flank_radius=setup.scene.least_flank_radius + over)


def flank_refusal(setup: Setup) -> str | None:
    """Return why a flank radius cannot be varied, None if it can."""
    if isinstance(setup.scene, CamFollower) and setup.scene.is_one_circle:
        return f"the {setup.scene.kind} has its least flank radius already"
    return cam_radii_refusal(setup)


def with_nose_radius(setup: Setup, radius: float) -> Scene:
    """Return the cam with a nose radius [mm], and the same lift and least flank radius."""
    assert isinstance(setup.scene, CamFollower)
    nose = radius * MILLIMETRE
    return setup.variant(nose_radius=nose, centre_distance=setup.scene.full_lift + setup.scene.base_radius - nose)


def cam_radii_refusal(setup: Setup) -> str | None:
    """Return why the radii of a cam cannot be varied together, None if they can."""
    known = isinstance(setup.scene, CamFollower)
    return None if known else f"which radii of a cam of the {setup.scene.kind} go together is not known"


def with_float_speed_share(setup: Setup, share: float) -> Scene:
    """Return the cam at a share of the float speed, with the same force on its follower.

    Accelerations grow with the square of the speed, so at s times the float speed the preload is 1 / s^2. The float
    speed is speed * sqrt(preload), where the force just gives the largest downward acceleration.
    """
    speed = share * (setup.scene.speed * math.sqrt(setup.scene.parameters[PRELOAD]))
    return setup.variant(speed=speed, **{PRELOAD: 1.0 / share**2})


def float_refusal(setup: Setup) -> str | None:
    """Return why a machine has no float speed, None if it has one."""
    held = setup.scene.parameters.get(PRELOAD, 0.0) > 0.0
    return None if held else f"the {setup.scene.kind} has no follower that a force holds down"
