"""More about three of the documents: answers not printed, the listing as MATLAB runs it, the series for every cam."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

from audits.cam_survey import LARGEST_PRESSURE_ANGLE, CamSurvey, surveys
from audits.documents.module_answers import answers
from audits.formulas.published import SAME
from audits.listing_survey import runs
from audits.report.cam_figures import pressure_angle, series_error
from audits.report.corrections import share_text
from conrod.models.printed.report import escape_marks, unsigned_zero
from conrod.report.figure import Figure
from conrod.report.numbers import quantity
from conrod.report.table import Table, table

Block: TypeAlias = str | Table | Figure


def module_section() -> list[Block]:
    """The answers, with their computation."""
    rows = [
        [
            str(a.line),
            escape_marks(a.place),
            escape_marks(a.quantity),
            quantity(a.value, 6),
            escape_marks(a.unit),
            escape_marks(a.why),
        ]
        for a in answers()
    ]
    return [
        "## Asked for and not printed",
        "What the examples ask and leave open, from their printed lengths and speeds.",
        table(["line", "where", "quantity", "value", "unit", "computation"], rows),
    ]


SAW_METHOD = (
    "The listing's lines were evaluated with MATLAB's own operators at its own angles, 0 to 360 deg by 1 deg, its "
    "names put right where it would stop and line 154 left out. Between two rows MATLAB's `/` does not divide element "
    "by element: it solves x b = a by least squares and gives one number, so that w3 and a3 come out the same for all "
    "angles. With `./` alone w3 is a row, and products and powers of rows want `.*` and `.^` too. And `input` asks for "
    "*putaran*, which section 4 answers with 500 rpm, where the lines below want rad/s."
)


def saw_section() -> list[Block]:
    """Peaks of each way to run the listing."""
    rows = [
        [
            f"{run.speed:g}",
            run.way,
            _number(run.rod_speed) + (", one number" if run.is_one_number else ""),
            _number(run.rod_acceleration) + (", one number" if run.is_one_number else ""),
            _number(run.velocity),
            _share(run.velocity_error),
            _number(run.acceleration),
            _share(run.acceleration_error),
        ]
        for run in runs()
    ]
    head = ["rpm meant", "the listing", "w3 [rad/s]", "a3 [rad/s²]", "velocity [mm/s]", "off by",
            "acceleration [mm/s²]", "off by"]  # fmt: skip
    caption = (
        "Largest values in size over the turn; *off by* is the largest deviation from the exact motion at the speed "
        "that is meant, as a share of its peak."
    )
    return ["## The MATLAB listing as MATLAB runs it", SAW_METHOD, caption, table(head, rows)]


def _number(value: float) -> str:
    return quantity(value, 5)


def _share(value: float) -> str:
    return "nothing" if value <= SAME else f"{share_text(value)} %"


NAMES = ("lift", "velocity", "acceleration", "jerk")
UNITS = ("mm", "mm/s", "mm/s²", "mm/s³")
# Below this share of its peak a jump is rounding noise.
NOISE = 1e-9
CAM_METHOD = (
    "Equations (8) to (23) replace √(1 - u²) by 1 - u²/2. They were evaluated as published, with R1 + r in place of "
    "R1 - R in (13), (17) and (21), which cannot be used as they stand (R1 - R is negative for every cam), against the "
    "exact geometry of base circle, flank, nose and roller, at 1 rad/s, R1 = 29, C = 80 and r = 9 mm. *flank* is the "
    "sector BC, equations (8), (12), (16), (20), and by symmetry EF, (11), (15), (19), (23); *nose* is CD, (9), (13), "
    "(17), (21), and DE, (10), (14), (18), (22). An error is the largest in size within the sector, the peak the "
    "largest exact value in size. At the joint C flank and nose meet: lift and velocity are continuous in truth, "
    "and what the series leaves there is its own. For the least flank radius of a base the cam is one circle and has "
    "no nose."
)
AT_B = (
    "At the joint B, where the flank begins, the series is exact up to the second derivative: lift and velocity begin "
    "at zero and the acceleration jumps as it does in truth."
)
PRESSURE = (
    "The document's own rule (line 62): the pressure angle is not to exceed 30 deg. *as printed* is by equations (6) "
    "and (7), which count the height from the base circle and leave out the roller's radius."
)


def cam_section() -> list[Block]:
    """The tables with their figures."""
    found = surveys()
    broken = [f"R = {s.base:g}, rho = {s.flank:g}" for s in found if not s.keeps_the_rule]
    return [
        "## The truncated series for every cam",
        CAM_METHOD,
        _worst(found),
        Figure("series-error", "Error of the series over the cam angle for R = 36 mm", series_error),
        *(block for k, name in enumerate(NAMES) for block in (f"### {name.capitalize()}", _series_table(found, k))),
        "### The joint B",
        AT_B,
        _joint_b_table(found),
        "## Pressure angles",
        PRESSURE,
        f"{len(broken)} of the {len(found)} cams break the rule: {'; '.join(broken)} mm. Among them is the cam that "
        "the conclusion calls the extreme one.",
        Figure("pressure-angle", "Largest pressure angle of every cam, with the rule of 30 degrees", pressure_angle),
        _pressure_table(found),
    ]


def _worst(found: Sequence[CamSurvey]) -> Table:
    """The cam on which the series does worst, in words."""
    rows = []
    for k, name in enumerate(NAMES):
        shares = [max(s.flank_error[k], s.nose_error[k]) / s.exact_peak[k] for s in found]
        cam = found[max(range(len(found)), key=lambda i: round(shares[i], 9))]
        error = max(cam.flank_error[k], cam.nose_error[k])
        rows.append(
            [name, f"{cam.base:g}", f"{cam.flank:g}", f"{_size(error)} {UNITS[k]}", f"{100.0 * max(shares):.1f} %"]
        )
    return table(["worst case", "R [mm]", "rho [mm]", "error of the series", "of the exact peak"], rows)


def _series_table(found: Sequence[CamSurvey], k: int) -> Table:
    unit = UNITS[k]
    head = ["R [mm]", "rho [mm]", f"exact peak [{unit}]", "error on the flank", "error on the nose",
            "jump at C, series", "jump at C, exact"]  # fmt: skip
    return table(
        head,
        [
            [
                *_cam(s),
                _size(s.exact_peak[k]),
                _size(s.flank_error[k]),
                "no nose" if s.is_least else _size(s.nose_error[k]),
                "no joint" if s.is_least else _jump(s.jump_c[k], s.exact_peak[k]),
                "no joint" if s.is_least else _jump(s.exact_jump_c[k], s.exact_peak[k]),
            ]
            for s in found
        ],
    )


def _joint_b_table(found: Sequence[CamSurvey]) -> Table:
    head = ["R [mm]", "rho [mm]", "B [deg]", "C [deg]", "acceleration at B, series [mm/s²]", "exact [mm/s²]",
            "jerk at B, series [mm/s³]", "exact [mm/s³]"]  # fmt: skip
    return table(
        head,
        [
            [
                *_cam(s),
                f"{s.joint_b:.3f}",
                "none" if s.is_least else f"{s.joint_c:.3f}",
                *(_jump(jump[k], s.exact_peak[k]) for k in (2, 3) for jump in (s.jump_b, s.exact_jump_b)),
            ]
            for s in found
        ],
    )


def _pressure_table(found: Sequence[CamSurvey]) -> Table:
    head = [
        "R [mm]",
        "rho [mm]",
        "largest [deg]",
        "at [deg]",
        "as printed [deg]",
        f"within {LARGEST_PRESSURE_ANGLE:g} deg",
    ]
    return table(
        head,
        [
            [
                *_cam(s),
                f"{s.pressure_angle:.2f}",
                f"{s.pressure_angle_at:.1f}",
                f"{s.pressure_angle_as_printed:.2f}",
                "yes" if s.keeps_the_rule else "**no**",
            ]
            for s in found
        ],
    )


def _cam(found: CamSurvey) -> list[str]:
    return [f"{found.base:g}", f"{found.flank:g}" + (" (least)" if found.is_least else "")]


def _size(value: float) -> str:
    return quantity(float(value), 4) if abs(value) > NOISE else "0"


def _jump(value: float, peak: float) -> str:
    return unsigned_zero(quantity(float(value), 4)) if abs(value) > NOISE * peak else "0"
