"""A table as encoders would write it, of a saw that is not quite the drawing's: what the example report is made with.

`python tests/support/encoder_table.py > reports/verification/inputs/encoder.csv`
"""

from __future__ import annotations

import math

import numpy as np

from conrod.scenes import SCENES

HEAD = (
    "# Synthetic, no measurement: exact motion of saw-40rpm with a rod of 300.05 mm, read at 100 Hz by a rotary "
    "encoder of 4096 counts and a linear scale of 0.01 mm\n"
    "time [s],crank_angle [deg],C.x [mm]\n"
)
ROD, COUNTS, SCALE, RATE, ROWS = 0.30005, 4096, 1e-5, 100.0, 301


def encoder_table() -> str:
    """Two turns; the scale is at zero where the drawing's slider is at crank angle 0."""
    drawn = SCENES["saw-40rpm"]
    saw = drawn.with_parameters(rod=ROD)
    times = np.arange(ROWS) / RATE
    at_zero = [one.mechanism().driven_joint.point_a for one in (drawn, saw)]
    x = saw.reference(times).point("C").position[:, 0] - at_zero[1][0] + at_zero[0][0]
    angle = np.round(np.degrees(saw.speed * times) / (360.0 / COUNTS)) * (360.0 / COUNTS)
    rows = zip(times.tolist(), angle.tolist(), np.round(x / SCALE).tolist(), strict=True)
    return HEAD + "".join(f"{t:.2f},{math.fmod(a, 360.0):.5f},{1e3 * SCALE * n:.2f}\n" for t, a, n in rows)


if __name__ == "__main__":
    print(encoder_table(), end="")
