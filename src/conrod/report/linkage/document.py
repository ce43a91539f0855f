"""The classic quantities of a linkage for machines, in SI units and radians, as `conrod show --json` writes them."""

from __future__ import annotations

import math
from importlib.metadata import version
from typing import Any

from conrod.exact.linkage import InstantQuantities, PointQuantities, TurnQuantities
from conrod.exact.linkage.centres import centre_count
from conrod.report.saved import json_text
from conrod.runs.plain import plain
from conrod.scenes import Scene

SCHEMA = 2


def linkage_text(name: str, scene: Scene, turn: TurnQuantities, instant: InstantQuantities | None) -> str:
    """The JSON document of a scene."""
    document = {
        "schema": SCHEMA,
        "conrod": version("conrod"),
        "scene": name,
        "parameters": scene.parameters,
        "turn": _turn(scene, turn),
        "instant": None if instant is None else _instant(instant),
    }
    return json_text(document)


def _turn(scene: Scene, turn: TurnQuantities) -> dict[str, Any]:
    """Quantities of a turn, or of the driver's span; angles [rad], lengths [m]."""
    return {
        "links": turn.numbers,
        "mobility": turn.mobility,
        "instant_centres": centre_count(scene.kinematics.mechanism),
        "looked_at": list(scene.kinematics.span),
        "crank": {"turns_fully": turn.crank_range.full, **plain(turn.crank_range)},
        "outputs": [{**plain(output), "time_ratio": output.time_ratio} for output in turn.outputs],
        "transmission": [
            {
                **plain(angle),
                "worst": plain(angle.worst),
                "greatest_pressure_angle": plain(angle.greatest_pressure_angle),
            }
            for angle in turn.transmission
        ],
    }


def _instant(instant: InstantQuantities) -> dict[str, Any]:
    """Quantities at a crank angle; m, m/s, m/s^2, rad, rad/s, rad/s^2."""
    state = instant.state
    return {
        "angle": state.angle,
        "speed": state.speed,
        "acceleration": state.acceleration,
        "links": [{"link": name, **plain(link)} for name, link in state.links.items()],
        "transmission": [
            {"driven": push.driven, "through": push.through, "angle": float(push.angle[0])} for push in instant.pushes
        ],
        "centres": plain(instant.centres),
        "points": [_point(point) for point in instant.points],
        "velocities": plain(instant.velocities.vectors),
        "accelerations": plain(instant.accelerations.vectors),
    }


def _point(point: PointQuantities) -> dict[str, Any]:
    parts = point.parts
    # A straight path has the curvature 0, a point at rest none.
    curvature = None if parts.radius is None else 0.0 if math.isinf(parts.radius) else 1.0 / parts.radius
    acceleration = parts.normal + parts.tangential
    return {
        "name": point.name,
        "links": point.links,
        **plain({"place": point.place, "velocity": point.velocity}),
        **plain({"acceleration": acceleration, "normal": parts.normal, "tangential": parts.tangential}),
        "curvature": curvature,
    }
