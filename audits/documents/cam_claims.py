"""Claims of document 004 about its cams, held against the exact geometry of all of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from audits.cam_survey import CamSurvey, cams, surveys
from audits.documents.arc_cam import ArcCam
from conrod.models.printed.verdicts import PrintedVerdict, VerdictKind

LIFT, VELOCITY, ACCELERATION, JERK = range(4)
ANGLES = np.arange(1.0, 180.0)  # [deg]
SAMPLES = 41  # of a nose
WIDEST = ArcCam(36.0, 118.0)  # the cam that the document calls the extreme one
SAME = 1e-9  # mm: what differs by less is the same


def verdicts() -> tuple[PrintedVerdict, ...]:
    """One on each claim, in the order of the lines."""
    found = [claim() for claim in CLAIMS]
    found += _sectors()
    text = "for the same R, the larger rho the smaller 2(theta - beta + gamma)"
    found.append(_falling(235, "angle of the rise", text, lambda cam: 360.0 - 2.0 * cam.joint_b))
    found.append(_falling(235, "way along the contour", "for the same R, the larger rho the shorter", _contour))
    return tuple(sorted(found, key=lambda verdict: verdict.line))


def _claim(
    line: int, quantity: str, text: str, wrong: str, reason: str, right: str, kind: VerdictKind
) -> PrintedVerdict:
    """A claim that holds where nothing contradicts it."""
    verdict = (VerdictKind.AGREES, reason, None) if not wrong else (kind, f"{reason}, but {wrong}", right)
    return PrintedVerdict("004", "text", line, quantity, "statement", "", text, None, None, *verdict)


def _where(found: CamSurvey) -> str:
    return f"R = {found.base:g}, rho = {found.flank:g} mm"


def _extreme(quantity: int, largest: bool) -> CamSurvey:
    return sorted(surveys(), key=lambda s: float(s.exact_peak[quantity]), reverse=largest)[0]


def _lift_falls() -> PrintedVerdict:
    wrong = ""
    for base in dict.fromkeys(cam.base for cam in cams()):
        some = sorted((cam for cam in cams() if cam.base == base), key=lambda cam: cam.flank)
        lifts = [cam.exact(ANGLES)[LIFT] for cam in some]
        for cam, lower, higher in zip(some[1:], lifts[1:], lifts[:-1], strict=True):
            if (lower > higher + SAME).any():
                wrong = wrong or f"not at {ANGLES[int(np.argmax(lower - higher))]:g} deg for {_cam(cam)}"
    return _claim(235, "lift", "for the same R, the larger rho the smaller h; at 180 deg the same h", wrong,
                  "exact lifts of neighbouring rho compared at every degree", "", VerdictKind.WRONG_STEP)  # fmt: skip


def _sectors() -> Iterator[PrintedVerdict]:
    """The angles that line 132 names, with beta and gamma as the sectors of lines 157 and 161 have them."""
    b, c = WIDEST.joint_b, WIDEST.joint_c
    by_print = f"by line 157 the rise goes from theta = beta, {b:.3f} deg for {_cam(WIDEST)}, to 180 deg"
    yield _claim(132, "angle of the rise", "angle BOD = beta", f"that makes BOD = {180.0 - b:.3f} deg", by_print,
                 "BOD = 180 deg - beta", VerdictKind.MISPRINT)  # fmt: skip
    mirrored = 360.0 - c - 180.0
    wrong = "" if abs(mirrored - (180.0 - c)) < SAME else f"DOE = {mirrored:.3f} deg"
    yield _claim(132, "angle of the nose", "angle DOE = gamma", wrong,
                 f"the nose reaches as far on both sides of its tip, {mirrored:.3f} deg for {_cam(WIDEST)}", "",
                 VerdictKind.MISPRINT)  # fmt: skip


def _contour(cam: ArcCam) -> float:
    """Length [mm] of the cam's contour from B over C to the tip D: each arc's radius times its turn."""
    b = np.radians(cam.joint_b)
    away = complex(-cam.scene.centre_distance / 1e-3) + (cam.flank - cam.base) * np.exp(1j * b)
    turn = np.pi if cam.scene.is_one_circle else float(np.angle(away)) % (2.0 * np.pi)
    return float(cam.flank * (turn - b) + cam.scene.nose_radius / 1e-3 * (np.pi - turn))


def _falling(line: int, name: str, text: str, of: Callable[[ArcCam], float]) -> PrintedVerdict:
    """Quantities that fall with rho for each R."""
    pairs = [
        (a, b) for a in cams() for b in cams()
        if a.base == b.base and b.flank == min((c.flank for c in cams() if c.base == a.base and c.flank > a.flank),
                                              default=0.0)
    ]  # fmt: skip
    wrong = "; ".join(f"{of(b):.4g} ({_cam(b)}) is no less than {of(a):.4g} ({_cam(a)})" for a, b in pairs
                      if of(b) >= of(a))  # fmt: skip
    return _claim(line, name, text, wrong, f"geometry of {len(pairs)} pairs of neighbouring cams", "not so for every "
                  "pair", VerdictKind.WRONG_STEP)  # fmt: skip


def _falls_with_base() -> PrintedVerdict:
    pairs = [(a, b) for a in surveys() for b in surveys() if a.flank == b.flank and b.base == a.base + 10.0]
    wrong = "; ".join(f"not from {_where(a)} to {_where(b)}" for a, b in pairs
                      if (b.exact_peak[[LIFT, VELOCITY]] >= a.exact_peak[[LIFT, VELOCITY]]).any())  # fmt: skip
    return _claim(235, "lift and its rate", "for the same rho, the larger R the smaller h and its rate", wrong,
                  f"exact peaks of {len(pairs)} pairs of neighbouring cams", "not so for every pair",
                  VerdictKind.WRONG_STEP)  # fmt: skip


def _largest_lift() -> PrintedVerdict:
    pairs = [(a, b) for a in surveys() for b in surveys() if a.base <= b.base]
    off = [(a, b) for a, b in pairs
           if abs(float(a.exact_peak[LIFT] - b.exact_peak[LIFT]) - (b.base - a.base)) > SAME]  # fmt: skip
    wrong = f"{_where(off[0][0])} and {_where(off[0][1])} do not" if off else ""
    return _claim(293, "largest lift", "for each R the same for all rho; the larger R the smaller", wrong,
                  "exact lifts of all cams differ by as much as R does", "", VerdictKind.WRONG_STEP)  # fmt: skip


def _nose_is_harder() -> PrintedVerdict:
    wrong, least = "", np.inf
    for cam in (cam for cam in cams() if not cam.scene.is_one_circle):
        angles, motion = cam.rise()
        rates = np.abs(motion[ACCELERATION])
        ratio = float(rates[len(angles) // 2 :].max() / rates[: len(angles) // 2].max())
        least = min(least, ratio)
        wrong = wrong or ("" if ratio > 1.0 else f"it is {ratio:.2f} times that of BC for {_cam(cam)}")
    return _claim(275, "acceleration on CD and DE", "far larger than on BC", wrong,
                  f"exact peaks of every cam with a nose, at least {least:.2f} times as large", "",
                  VerdictKind.WRONG_STEP)  # fmt: skip


def _jump() -> PrintedVerdict:
    jump = float((WIDEST.exact(WIDEST.joint_c, "right") - WIDEST.exact(WIDEST.joint_c, "left"))[ACCELERATION, 0])
    return _claim(277, "acceleration at the joint C", "it jumps", "" if abs(jump) > SAME else "it does not",
                  f"exact geometry: by {jump:.3f} mm/s^2 for {_cam(WIDEST)}", "", VerdictKind.WRONG_STEP)  # fmt: skip


def _unit_of_jerk() -> PrintedVerdict:
    return _claim(289, "unit of the jerk", "j_r = 0 deg", "jerk is a length by the cube of a time",
                  "deg is a unit of an angle", "0 mm/s^3", VerdictKind.MISPRINT)  # fmt: skip


def _cam(cam: ArcCam) -> str:
    return f"R = {cam.base:g}, rho = {cam.flank:g} mm"


def _steepest() -> PrintedVerdict:
    most, least = _extreme(VELOCITY, True), _extreme(VELOCITY, False)
    holds = (most.base, most.flank, least.base, least.flank) == (76.0, 128.0, 36.0, 72.5)
    wrong = "" if holds else f"the largest is {most.exact_peak[VELOCITY]:.3f} mm/s at {_where(most)}, the smallest " \
        f"{least.exact_peak[VELOCITY]:.3f} mm/s at {_where(least)}, as line 255 has it"  # fmt: skip
    text = "the largest at R = 76, rho = 128; the smallest at R = 36, rho = 72,5"
    return _claim(237, "rate of the lift", text, wrong,
                  "exact peaks of all cams", "R = 36, rho = 118 and R = 76, rho = 92,5",
                  VerdictKind.MISPRINT)  # fmt: skip


def _fastest() -> PrintedVerdict:
    most, least = _extreme(VELOCITY, True), _extreme(VELOCITY, False)
    holds = (most.base, most.flank, least.base, least.flank) == (36.0, 118.0, 76.0, 92.5)
    wrong = "" if holds else f"the largest is at {_where(most)}, the smallest at {_where(least)}"
    return _claim(255, "velocity", "the largest at R = 36, rho = 118; the smallest at R = 76, rho = 92,5", wrong,
                  "exact peaks of all cams", "", VerdictKind.WRONG_STEP)  # fmt: skip


def _nose_is_the_same() -> PrintedVerdict:
    spread = 0.0
    for cam in cams():
        if not cam.scene.is_one_circle:
            widest = max((other for other in cams() if other.base == cam.base), key=lambda other: other.flank)
            nose = np.linspace(cam.joint_c, 180.0, SAMPLES)
            off = cam.exact(nose)[[LIFT, VELOCITY]] - widest.exact(nose)[[LIFT, VELOCITY]]
            spread = max(spread, float(np.abs(off).max()))
    wrong = "" if spread < SAME else f"they differ by {spread:.2g} mm or mm/s"
    return _claim(257, "lift and velocity on CD and DE", "for each R, rho has no influence", wrong,
                  "every cam on its nose against that with the longest flank", "", VerdictKind.WRONG_STEP)  # fmt: skip


def _centres() -> PrintedVerdict:
    longer = [cam for cam in cams() if cam.flank - cam.base >= 80.0]
    listed = "; ".join(f"rho - R = {cam.flank - cam.base:g} mm for {_cam(cam)}" for cam in longer)
    others = f"C = 80 mm, which holds for the other {len(cams()) - len(longer)} cams"
    return _claim(275, "distances of the arcs' centres", "C > (rho - R)", listed, others,
                  "C < (rho - R) for that cam", VerdictKind.WRONG_STEP)  # fmt: skip


def _jerk() -> PrintedVerdict:
    by_cam = {(s.base, s.flank): float(s.exact_peak[JERK]) for s in surveys()}
    one, other = by_cam[36.0, 118.0], by_cam[76.0, 128.0]
    wrong = "" if one > other else "it is smaller"
    return _claim(289, "jerk", "larger for R = 36, rho = 118 than for R = 76, rho = 128", wrong,
                  f"exact peaks {one:.1f} and {other:.1f} mm/s^3", "", VerdictKind.WRONG_STEP)  # fmt: skip


def _growing(quantity: int, name: str) -> Callable[[], PrintedVerdict]:
    """The conclusion's claim on one quantity: it grows with rho, and falls with R."""

    def claim() -> PrintedVerdict:
        found = surveys()
        pairs = [(a, b) for a in found for b in found if _steps_up(a, b, found)]
        against = [(a, b) for a, b in pairs if b.exact_peak[quantity] <= a.exact_peak[quantity]]
        wrong = (
            ""
            if not against
            else "; ".join(
                f"{a.exact_peak[quantity]:.4g} ({_where(a)}) is no less than {b.exact_peak[quantity]:.4g} ({_where(b)})"
                for a, b in against
            )
        )
        return _claim(293, name, f"for each R the larger rho the larger the {name}; the larger R the smaller", wrong,
                      f"exact peaks of {len(pairs)} pairs of neighbouring cams",
                      "not so for every pair", VerdictKind.WRONG_STEP)  # fmt: skip

    return claim


def _steps_up(a: CamSurvey, b: CamSurvey, found: Sequence[CamSurvey]) -> bool:
    """Whether b is a's neighbour with the next larger rho, or with the next smaller R."""
    if a.base == b.base:
        return b.flank == min((s.flank for s in found if s.base == a.base and s.flank > a.flank), default=0.0)
    return a.flank == b.flank and b.base == a.base - 10.0


CLAIMS: tuple[Callable[[], PrintedVerdict], ...] = (
    _lift_falls,
    _falls_with_base,
    _steepest,
    _fastest,
    _nose_is_the_same,
    _centres,
    _nose_is_harder,
    _jump,
    _jerk,
    _unit_of_jerk,
    _largest_lift,
    _growing(VELOCITY, "velocity"),
    _growing(ACCELERATION, "acceleration"),
    _growing(JERK, "jerk"),
)
