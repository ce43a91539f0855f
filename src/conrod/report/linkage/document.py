"""The classic quantities of a linkage for machines, in SI units and radians: what `conrod show --json` writes."""

from __future__ import annotations

import json
import math
from importlib.metadata import version
from typing import Any

import numpy as np

from conrod.exact.linkage.centres import InstantCentre, centre_count
from conrod.exact.linkage.polygon import Polygon
from conrod.exact.linkage.quantities import InstantQuantities, PointQuantities, TurnQuantities
from conrod.exact.linkage.transmission import Extreme
from conrod.exact.motion import Array
from conrod.scenes import Scene

SCHEMA = 1


def linkage_text(name: str, scene: Scene, turn: TurnQuantities, instant: InstantQuantities | None) -> str:
    """The JSON document of a scene."""
    document = {
        "schema": SCHEMA,
        "conrod": version("conrod"),
        "scene": name,
        "parameters": scene.parameters,
        "turn": turn_document(scene, turn),
        "instant": None if instant is None else instant_document(instant),
    }
    return json.dumps(document, indent=1, allow_nan=False) + "\n"


def turn_document(scene: Scene, turn: TurnQuantities) -> dict[str, Any]:
    """Quantities of a turn, or of the driver's span; angles [rad], lengths [m]."""
    reach = turn.crank_range
    return {
        "links": turn.numbers,
        "mobility": turn.mobility,
        "instant_centres": centre_count(scene.kinematics.mechanism),
        "looked_at": list(scene.kinematics.span),
        "crank": {
            "turns_fully": reach.full,
            "from": reach.start,
            "to": reach.stop,
            "from_end": reach.start_end,
            "to_end": reach.stop_end,
            "change_points": list(reach.change_points),
        },
        "outputs": [
            {
                "link": output.link,
                "joint": output.joint,
                "unit": output.unit,
                "stroke": output.stroke,
                "gain": output.gain,
                "dead_centres": [
                    {"angle": c.angle, "until": c.until, "value": c.value, "end": "greatest" if c.greatest else "least"}
                    for c in output.dead_centres
                ],
                "forward": output.forward,
                "backward": output.backward,
                "time_ratio": output.time_ratio,
            }
            for output in turn.outputs
        ],
        "transmission": [
            {
                "driven": angle.driven,
                "through": angle.through,
                "least": _extreme(angle.least),
                "greatest": _extreme(angle.greatest),
                "worst": _extreme(angle.worst),
                "greatest_pressure_angle": _extreme(angle.greatest_pressure_angle),
            }
            for angle in turn.transmission
        ],
    }


def instant_document(instant: InstantQuantities) -> dict[str, Any]:
    """Quantities at a crank angle; m, m/s, m/s^2, rad, rad/s, rad/s^2."""
    state = instant.state
    return {
        "angle": state.angle,
        "speed": state.speed,
        "acceleration": state.acceleration,
        "links": [
            {
                "link": name,
                "pose": list(link.pose),
                "velocity": list(link.velocity),
                "acceleration": list(link.acceleration),
                "angular_velocity": link.angular_velocity,
                "angular_acceleration": link.angular_acceleration,
            }
            for name, link in state.links.items()
        ],
        "transmission": [
            {"driven": push.driven, "through": push.through, "angle": float(push.angle[0])} for push in instant.pushes
        ],
        "centres": [_centre(centre) for centre in instant.centres],
        "points": [_point(point) for point in instant.points],
        "velocities": _polygon(instant.velocities),
        "accelerations": _polygon(instant.accelerations),
    }


def _extreme(extreme: Extreme) -> dict[str, float]:
    return {"value": extreme.value, "angle": extreme.angle}


def _centre(centre: InstantCentre) -> dict[str, Any]:
    return {
        "name": centre.name,
        "links": list(centre.links),
        "kind": centre.kind,
        "place": None if centre.place is None else list(centre.place),
        "direction": None if centre.direction is None else list(centre.direction),
    }


def _point(point: PointQuantities) -> dict[str, Any]:
    parts = point.parts
    # A straight path has the curvature 0, a point at rest none.
    curvature = None if parts.radius is None else 0.0 if math.isinf(parts.radius) else 1.0 / parts.radius
    return {
        "name": point.name,
        "links": list(point.links),
        "place": _pair(point.place),
        "velocity": _pair(point.velocity),
        "acceleration": _pair(parts.normal + parts.tangential),
        "normal": _pair(parts.normal),
        "tangential": _pair(parts.tangential),
        "curvature": curvature,
    }


def _polygon(polygon: Polygon) -> list[dict[str, Any]]:
    return [
        {
            "name": vector.name,
            "from": vector.start,
            "to": vector.stop,
            "value": _pair(vector.value),
            "kind": vector.kind,
            "link": vector.link,
        }
        for vector in polygon.vectors
    ]


def _pair(vector: Array) -> list[float]:
    return [float(value) for value in np.asarray(vector)]
