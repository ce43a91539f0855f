"""Where the runs of a hardened model start, and what is told where they show nothing."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest

from conrod.cli.harden import print_hardened
from conrod.errors import InvalidInput
from conrod.mjcf.harden.closures import active_closures
from conrod.mjcf.harden.results import HardenedModel, Request
from conrod.mjcf.harden.runs import Pace, conservative, energy_drift, start_of
from conrod.mjcf.harden.study import harden_file
from conrod.mjcf.lint.findings import Request as LintRequest
from conrod.mjcf.lint.linting import lint
from conrod.mjcf.runs import STATE
from conrod.own.models.loading import keyframe_to_start_from
from tests.support.legged import LEGGED, legged

SAW = Path(__file__).parents[2] / "mjcf" / "saw-500rpm.xml"


@cache
def saw(keyframe: str | None) -> HardenedModel:
    return harden_file(SAW, Request(keyframe, seconds=0.024, content=False))


def printed(found: HardenedModel, capsys: pytest.CaptureFixture[str]) -> dict[str, list[str]]:
    """Cells of the printed table by the heading of their row; of two rows the last."""
    print_hardened(found, None)
    rows = [line.strip("│").split("│") for line in capsys.readouterr().out.splitlines() if line.startswith("│")]
    return {heading.strip(): [cell.strip() for cell in cells] for heading, *cells in rows}


# -- where they start ------------------------------------------------------------------------------------------------


def test_runs_start_from_the_first_keyframe_as_those_of_lint_do() -> None:
    assert saw(None).start == "keyframe start"
    assert saw(None).travel == pytest.approx(0.1, rel=0.5)
    assert f"from {saw(None).start}" in lint(SAW, LintRequest(seconds=0.0012, ignored=())).run


@pytest.mark.parametrize(("given", "index"), [(None, 0), ("swing", 0), ("drop", 1), ("1", 1), ("qpos0", None)], ids=str)
def test_a_start_is_named_or_numbered_or_is_the_own_pose(given: str | None, index: int | None) -> None:
    assert keyframe_to_start_from(legged(), given) == index


def test_without_a_keyframe_runs_start_from_the_own_pose() -> None:
    assert keyframe_to_start_from(mujoco.MjModel.from_xml_string(ARM.format(0)), None) is None


@pytest.mark.parametrize("given", ["swung", "2", "-1", ""])
def test_a_start_that_there_is_not_is_told_with_those_that_there_are(given: str) -> None:
    with pytest.raises(InvalidInput, match=f"unknown keyframe '{given}': choose from drop, qpos0, swing"):
        keyframe_to_start_from(legged(), given)


def test_rates_that_would_open_the_loops_are_changed_and_that_is_told() -> None:
    # The keyframe turns the hips and leaves the cranks behind.
    model = legged()
    start = start_of(model, "swing", active_closures(model))
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, start.state, STATE)
    assert start.rates_changed == pytest.approx(np.abs(data.qvel - model.key_qvel[0]).max() / 3.0)
    assert start.rates_changed > 0.01
    found = harden_file(LEGGED, Request(seconds=0.02, content=False))
    assert any("rates of the start" in note for note in found.warnings)
    # Control: conrod's own keyframe moves all its links.
    assert not any("rates of the start" in note for note in saw(None).warnings)


# -- where they show nothing -----------------------------------------------------------------------------------------


def test_a_machine_that_stands_has_no_orders_and_no_drift_below_what_its_reference_is_known_to(
    capsys: pytest.CaptureFixture[str],
) -> None:
    stands = saw("qpos0")
    assert any("nothing moves" in note for note in stands.warnings)
    assert stands.energy_note == "nothing moves"
    table = printed(stands, capsys)
    assert table["order in the step"] == ["-"] * 3
    assert table["energy, change over exchanged"] == ["-"] * 3
    assert table["drift from the reference [m]"][2] == "-"
    # Control: one that moves has them.
    assert not any("nothing moves" in note for note in saw(None).warnings)
    table = printed(saw(None), capsys)
    assert "-" not in table["drift from the reference [m]"]
    assert table["order in the step"][2].startswith("4.")
    assert not any("-0.0" in cell for cells in table.values() for cell in cells)


ARM = """
<mujoco><worldbody>
  <body name="arm" gravcomp="{}"><joint axis="0 1 0"/><geom size="0.1" pos="0.3 0 0"/></body>
</worldbody>
</mujoco>
"""


def test_gravity_compensation_is_left_out_where_the_energy_is_looked_at() -> None:
    # MuJoCo's potential energy does not know of it.
    model = mujoco.MjModel.from_xml_string(ARM.format(0.5))
    bare, without = conservative(model)
    assert "gravity compensation" in without
    state = start_of(model, None, ()).state
    share, control = (energy_drift(run, state, Pace(50, 1, 0.002))[0] for run in (bare, model))
    assert share < 0.02
    assert control > 0.4
    assert conservative(mujoco.MjModel.from_xml_string(ARM.format(0)))[1] == ("contacts",)
