"""Document 004: the values that its text quotes for a cam of circular arcs, and its formulas.

The exact values are those of the geometry (`CamFollower`). The document works with a series cut after its first term,
equations (8) to (23), tabulated every ten degrees and at the joint angles.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from audits.documents import cam_claims
from audits.documents.arc_cam import QUANTITIES, ArcCam
from audits.formulas.cam_checks import FORMULAS, arguments
from audits.formulas.published import verdict_on
from audits.items import shipped_items
from audits.judging import Case, Explanation, Item, judge
from conrod.models.printed.verdicts import PrintedVerdict

DOCUMENT = "004"
GRID = np.arange(0.0, 181.0, 10.0)  # [deg], the document's table
LIFT, VELOCITY, ACCELERATION, JERK = range(len(QUANTITIES))
WIDEST = ArcCam(36.0, 118.0)  # the cam that the document calls the extreme one
OTHER = ArcCam(36.0, 108.0)
FIRST = ArcCam(36.0, 88.0)


def verdicts() -> tuple[PrintedVerdict, ...]:
    """Every quoted value, every formula, and what the text claims in words."""
    values = tuple(judge(CASES[item.key](item)) for item in shipped_items(DOCUMENT, "cam.csv"))
    return values + tuple(verdict_on(formula, arguments()) for formula in FORMULAS) + cam_claims.verdicts()


def _least_flank(base: float) -> Callable[[Item], Case]:
    value = ArcCam(base, base + 80.0).scene.least_flank_radius / 1e-3
    return lambda item: Case(item, value, "(R + R1 + C)/2, the centres in line")


def _lift(base: float) -> Callable[[Item], Case]:
    return lambda item: Case(item, ArcCam(base, base + 80.0).scene.full_lift / 1e-3, "C + R1 - R")


def _smallest_base(item: Item) -> Case:
    lift = Explanation(
        "the largest lift, 73 mm, C + R1 - R (lines 237 and 295), and R = 36 mm of line 223", 80.0 + 29.0 - 73.0, 0.0
    )
    return Case(item, 36.0, "R = 36 mm throughout the results", neighbours=(lift,))


def _lift_angle(item: Item) -> Case:
    return Case(item, 180.0, "the nose stands up")


def _exact_extreme(quantity: int, magnitude: bool = False, flank_only: bool = False) -> tuple[float, float]:
    """Angle [deg] and value of the exact extreme on the rise, or within the flank alone."""
    angles, motion = WIDEST.rise()
    values = motion[quantity]
    if flank_only:
        angles, values = angles[: len(angles) // 2], values[: len(values) // 2]
    k = int(np.argmax(np.abs(values) if magnitude else values))
    return float(angles[k]), float(values[k])


def _series(cam: ArcCam, degrees: float, arc: str, quantity: int) -> float:
    return float(cam.series(degrees, arc)[quantity, 0])


def _largest_speed(item: Item) -> Case:
    cut = Explanation("the series (12) at the joint C", _series(WIDEST, WIDEST.joint_c, "flank", VELOCITY))
    return Case(item, _exact_extreme(VELOCITY)[1], "exact geometry: at the joint C", causes=(cut,))


def _largest_speed_angle(item: Item) -> Case:
    mirror = Explanation("360 - 197,772 deg of the conclusion", 360.0 - 197.772, 0.0005)
    return Case(item, _exact_extreme(VELOCITY)[0], "exact geometry: the joint C", neighbours=(mirror,))


def _largest_speed_mirror(item: Item) -> Case:
    return Case(item, 360.0 - _exact_extreme(VELOCITY)[0], "exact geometry: 360 deg - the joint C")


def _speed_76(item: Item) -> Case:
    near = ", ".join(
        f"rho = {rho:g} mm {_series(ArcCam(76.0, rho), ArcCam(76.0, rho).joint_c, 'flank', VELOCITY):.3f}"
        for rho in (98.0, 108.0, 118.0)
    )
    widest = float(np.max(ArcCam(76.0, 92.5).exact(np.linspace(0.0, 180.0, 18001))[VELOCITY]))
    other = float(np.max(ArcCam(76.0, 98.0).rise()[1][VELOCITY]))
    why = (
        f"the exact peaks are {widest:.3f} (rho = 92.5 mm) and {other:.3f} mm/s (98 mm); the series at the joint C "
        f"gives for {near}"
    )
    return Case(item, widest, why)


def _speed_76_angle(item: Item) -> Case:
    sweep = np.linspace(0.0, 180.0, 18001)
    peak = float(sweep[int(np.argmax(ArcCam(76.0, 92.5).exact(sweep)[VELOCITY]))])
    joints = ", ".join(f"{ArcCam(76.0, rho).joint_c:.3f} deg for {rho:g} mm" for rho in (98.0, 108.0, 118.0))
    why = (
        f"the peak of rho = 92.5 mm, which has no joint; the joint C stands at {joints}: that of 108 mm differs from "
        "the print in one digit, but the printed velocity is not the one there"
    )
    return Case(item, peak, why)


def _on_grid(quantity: int) -> tuple[float, float]:
    """Angle and value of the series' largest entry on the flank in a table of ten degrees."""
    first, last = np.searchsorted(GRID, [WIDEST.joint_b, WIDEST.joint_c])
    angles = GRID[first:last]
    values = WIDEST.series(angles, "flank")[quantity]
    k = int(np.argmax(values))
    return float(angles[k]), float(values[k])


def _flank_peak(quantity: int, part: int) -> Callable[[Item], Case]:
    """The largest value on the flank (part 1) or its angle (part 0)."""

    def case(item: Item) -> Case:
        coarse = Explanation("the series on the grid of 10 deg", _on_grid(quantity)[part])
        angle, value = _exact_extreme(quantity, flank_only=True)
        why = f"exact geometry: {value:.3f} at {angle:.3f} deg"
        return Case(item, (angle, value)[part], why, causes=(coarse,))

    return case


def _tip(item: Item) -> Case:
    angle, value = _exact_extreme(ACCELERATION, magnitude=True)
    why = f"exact geometry at the tip (not the extreme, which is {value:.3f} at {angle:.3f} deg)"
    return Case(item, float(WIDEST.exact(180.0)[ACCELERATION, 0]), why)


def _tip_angle(item: Item) -> Case:
    angle, value = _exact_extreme(ACCELERATION, magnitude=True)
    nose = WIDEST.nose_angles
    series = float(nose[int(np.argmin(WIDEST.series(nose, "nose")[ACCELERATION]))])
    cut = Explanation("the series (18), whose acceleration falls all the way to the tip,", series)
    return Case(item, angle, f"exact geometry: {value:.3f} just after the joint C", causes=(cut,))


def _extreme_on_nose(quantity: int, besides: str = "") -> Callable[[Item], Case]:
    def case(item: Item) -> Case:
        angle, value = _exact_extreme(quantity, magnitude=True)
        slip = Explanation(
            "rho = 108 mm put in place of 118 mm in the series, at its joint C, in magnitude,",
            abs(_series(OTHER, OTHER.joint_c, "nose", quantity)),
        )
        why = f"exact geometry: just after the joint C, {angle:.3f} deg{besides}"
        return Case(item, abs(value), why, wrong_steps=(slip,))

    return case


def _joint_angle(mirrored: bool) -> Callable[[Item], Case]:
    def seen(cam: ArcCam) -> float:
        return 360.0 - cam.joint_c if mirrored else cam.joint_c

    slip = Explanation("rho = 108 mm put in place of 118 mm", seen(OTHER))
    return lambda item: Case(item, seen(WIDEST), "geometry of the joint C", wrong_steps=(slip,))


def _jerk_130(item: Item) -> Case:
    angles = WIDEST.flank_angles
    peak = float(angles[int(np.argmax(WIDEST.series(angles, "flank")[ACCELERATION]))])
    grid = Explanation(
        f"the grid of 10 deg, where the series' largest acceleration stands at {_on_grid(ACCELERATION)[0]:g} deg, with "
        f"the jerk of its true place, {peak:.3f} deg,",
        _series(WIDEST, peak, "flank", JERK),
    )
    series = _series(WIDEST, 130.0, "flank", JERK)
    why = f"exact geometry (the series gives {series:.3f})"
    return Case(item, float(WIDEST.exact(130.0)[JERK, 0]), why, causes=(grid,))


def _jerk_before(item: Item) -> Case:
    slip = Explanation(
        "probably the series (20) of rho = 88 mm at 162,228 deg, the joint C of rho = 118 mm, which",
        _series(FIRST, 162.228, "flank", JERK),
    )
    exact = float(WIDEST.exact(WIDEST.joint_c, "left")[JERK, 0])
    series = _series(WIDEST, WIDEST.joint_c, "flank", JERK)
    return Case(item, exact, f"exact geometry (the series gives {series:.3f})", wrong_steps=(slip,))


CASES: dict[str, Callable[[Item], Case]] = {
    "least-flank-36": _least_flank(36.0),
    "least-flank-76": _least_flank(76.0),
    "base-35": _smallest_base,
    "lift-36": _lift(36.0),
    "lift-36-angle": _lift_angle,
    "lift-76": _lift(76.0),
    "speed-max": _largest_speed,
    "speed-max-angle": _largest_speed_angle,
    "speed-max-mirror": _largest_speed_mirror,
    "speed-76": _speed_76,
    "speed-76-angle": _speed_76_angle,
    "flank-acceleration": _flank_peak(ACCELERATION, 1),
    "flank-acceleration-angle": _flank_peak(ACCELERATION, 0),
    "tip-acceleration": _tip,
    "tip-angle": _tip_angle,
    "acceleration-max": _extreme_on_nose(
        ACCELERATION, "; line 277 itself has a larger one for this cam, 248,421 mm/s^2 at its tip"
    ),
    "acceleration-max-angle": _joint_angle(mirrored=False),
    "acceleration-max-mirror": _joint_angle(mirrored=True),
    "flank-jerk": _flank_peak(JERK, 1),
    "flank-jerk-angle": _flank_peak(JERK, 0),
    "jerk-130": _jerk_130,
    "joint-angle": _joint_angle(mirrored=False),
    "jerk-before": _jerk_before,
    "jerk-after": _extreme_on_nose(JERK),
    "jerk-max": _extreme_on_nose(JERK),
    "jerk-max-angle": _joint_angle(mirrored=False),
    "jerk-max-mirror": _joint_angle(mirrored=True),
}
