"""What tests are parametrised over: everything that ships, and variations of it that must behave alike."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import pytest

from conrod.scenes import SCENES, CamFollower, Saw, Scene, ShearPress

# The same machines turning the other way, and with other proportions.
VARIATIONS: dict[str, Scene] = {
    "press-reversed": ShearPress(speed=-5.75),
    "press-long-crank": ShearPress(crank=0.25, rod=0.31, speed=20.0),
    "saw-reversed": Saw(speed=-52.0),
    "saw-in-line": Saw(offset=0.0),
    "saw-slide-below": Saw(offset=-0.12, crank=0.08, rod=0.25, speed=3.0),
    "cam-reversed": CamFollower(speed=-1.0),
    "cam-fast-large-roller": CamFollower(roller_radius=0.015, speed=20.0),
}

EVERY_SCENE = {**SCENES, **VARIATIONS}
# Those with a connecting rod, which models may have without mass.
WITH_A_ROD = {name: s for name, s in EVERY_SCENE.items() if "rod" in s.kinematics.mechanism.body_index}
LINKAGES = {name: scene for name, scene in WITH_A_ROD.items() if name in SCENES}

# One object each: to walk a mechanism around its turn takes most of a test's time, and is done once an object.
PRESS, SAW, CAM = SCENES["shear-press"], SCENES["saw-40rpm"], SCENES["cam-follower"]

# Where defects are planted in the mechanism: both machines, both senses of rotation.
DEFECTIVE_LINKAGES: dict[str, Any] = {
    name: EVERY_SCENE[name] for name in ("shear-press", "saw-40rpm", "press-reversed", "saw-slide-below")
}
DEFECTIVE_CAMS = {name: EVERY_SCENE[name] for name in ("cam-follower", "cam-reversed")}

MM = 1e-3
NOSE, DISTANCE = 29, 80  # R1, C of document 004 [mm]


def document_cams() -> dict[str, CamFollower]:
    """The 25 cams of document 004: (R, rho) in mm, the least rho of each R, and (76, 128)."""
    pairs = []
    for base in (36, 46, 56, 66, 76):
        least = 0.5 * (base + NOSE + DISTANCE)
        pairs += [(base, least)] + [(base, rho) for rho in (88, 98, 108, 118) if rho >= least]
    pairs.append((76, 128))
    return {
        f"cam-{base}-{rho:g}": CamFollower(
            base_radius=base * MM, flank_radius=rho * MM, nose_radius=NOSE * MM, centre_distance=DISTANCE * MM
        )
        for base, rho in pairs
    }


CAMS = document_cams()
CAMS_WITH_JOINTS = {name: cam for name, cam in CAMS.items() if not cam.is_one_circle}

# For tests that need the generic solver of each cam: a few of all kinds at once, all 25 with `make test-all`.
QUICK_CAMS = ("cam-36-72.5", "cam-36-118", "cam-66-88", "cam-76-98", "cam-76-128")


def slow_but_for_a_few(names: Iterable[str]) -> list[Any]:
    """Parameters of a test; all but the quick ones are marked slow."""
    return [name if name in QUICK_CAMS else pytest.param(name, marks=pytest.mark.slow) for name in names]
