"""Engines meet the printed table of document 000 in the cells that the exact motion rounds to."""

from __future__ import annotations

import numpy as np
import pytest

from audits.documents.press import exact, table
from conrod.engines import ENGINES, engine_named
from conrod.engines.running import whole_run
from conrod.scenes import ShearPress

# Printed every 5 degrees, which 7200 steps have samples at; run in for ten, in which soft closures come to rest.
STEPS, LEAD = 7200, 200
ALLOWED = 0.55  # of the last printed unit: half of it is the rounding of the print
MM, UNITS = 1e-3, {"position": 0.01, "velocity": 0.1, "acceleration": 0.1}
ROWS = table()
ANGLES = np.array([float(row["theta_deg"]) for row in ROWS])


@pytest.mark.parametrize("preset", ["tuned", "hardened"])
@pytest.mark.parametrize("engine", ENGINES)
def test_every_judged_preset_meets_all_cells_that_are_right(engine: str, preset: str) -> None:
    used, press = engine_named(engine), ShearPress()
    if preset not in used.presets:
        pytest.skip("it has no such preset")
    settings, start = used.presets[preset](press, STEPS), -2.0 * np.pi * LEAD / STEPS
    run, right, agreed = whole_run(used, press, settings, 1.0 + 2.0 * LEAD / STEPS, start), exact(ANGLES), 0
    for quantity, columns in (("position", "xG yG"), ("velocity", "vxG vyG vG"), ("acceleration", "axG ayG aG")):
        track = getattr(run.points["G"], quantity)
        found = [np.interp(np.radians(ANGLES), track.instants.angle, values) / MM for values in track.values.T]
        for name, measured in zip(columns.split(), [*found, np.hypot(*found)], strict=False):
            printed, unit = np.array([float(row[name]) for row in ROWS]), UNITS[quantity]
            agrees = np.abs(right[name] - printed) <= 0.5 * unit * (1.0 + 1e-9)
            agreed += int(agrees.sum())
            assert (np.abs(measured - printed)[agrees] <= ALLOWED * unit).all(), name
    assert agreed == 467
