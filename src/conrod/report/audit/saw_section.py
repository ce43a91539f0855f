"""What document 002's listing computes when it is run, as a table."""

from __future__ import annotations

from conrod.audit.formulas.published import SAME
from conrod.audit.listing_survey import runs
from conrod.report.audit.words import share_text
from conrod.report.numbers import quantity
from conrod.report.tables import paragraphs, table

METHOD = (
    "The listing's lines were evaluated with MATLAB's own operators at its own angles, 0° to 360° in steps of 1°, its "
    "names put right where it would stop and line 154 left out. Between two rows MATLAB's `/` does not divide element "
    "by element: it solves x b = a by least squares and gives one number, so that w3 and a3 come out the same for all "
    "angles. With `./` alone w3 is a row, and products and powers of rows want `.*` and `.^` too. And `input` asks for "
    "*putaran*, which section 4 answers with 500 rpm, where the lines below want rad/s."
)


def saw_section() -> str:
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
    told = (
        "Largest values in size over the turn; *off by* is the largest deviation from the exact motion at the speed "
        "that is meant, as a share of its peak."
    )
    return paragraphs("## The MATLAB listing as MATLAB runs it", METHOD, told, table(head, rows))


def _number(value: float) -> str:
    return quantity(value, 5)


def _share(value: float) -> str:
    return "nothing" if value <= SAME else f"{share_text(value)} %"
