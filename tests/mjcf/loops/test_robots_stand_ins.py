"""Small models with the closed loops of real robots: mobility, what is redundant or idle, what is held and judged.

They stand in for the models of public collections, which `make own-models MODELS=DIR` judges.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path

import mujoco
import numpy as np
import pytest

from conrod.comparison.trajectory import Outcome
from conrod.errors import InvalidInput
from conrod.exact.space.mobility import Mobility
from conrod.exact.space.motion import DrivenTree
from conrod.mjcf.loop_results import LoopRequest, LoopStudy
from conrod.models.loops import study
from conrod.models.loops.report import finding

GEOM = '<geom type="capsule" size="0.01" fromto="0 0 0 {}" contype="0" conaffinity="0"/>'

# A thigh with a knee, a shin on a spring, and a rod with a ball at the thigh and a connect at the heel, as of Cassie.
ACHILLES = f"""
  <body name="thigh" pos="0 0 1"><freejoint name="base"/>{GEOM.format("0.5 0 0")}
    <site name="hip"/>
    <body name="rod" pos="0 0 0.05"><joint name="rod" type="ball"/>{GEOM.format("0.45 0 0.05")}</body>
    <body name="knee" pos="0.1 0 0"><joint name="knee" axis="0 1 0" range="-60 60"/>{GEOM.format("0.1 0 0")}
      <body name="shin" pos="0.1 0 0"><joint name="spring" axis="0 1 0" stiffness="1500"/>{GEOM.format("0.2 0 0")}
        <body name="tarsus" pos="0.2 0 0"><joint name="tarsus" axis="0 1 0"/>{GEOM.format("0.05 0 0.1")}</body>
      </body>
    </body>
    <body name="arm" pos="0 0 0.1"><joint name="arm" axis="1 0 0"/>{GEOM.format("0 0.2 0")}</body>
  </body>"""
HEEL = '<connect name="heel" body1="rod" body2="tarsus" anchor="0.45 0 0.05"/>'


def finger(side: str, sign: int) -> str:
    """A finger of a gripper: a driver with a coupler, and a spring link with a follower."""
    return f"""
      <body name="{side}driver" pos="0 {0.03 * sign} 0"><joint name="{side}driver" axis="{sign} 0 0" range="-10 50"/>
        {GEOM.format(f"0 {0.03 * sign} 0.01")}
        <body name="{side}coupler" pos="0 {0.03 * sign} 0.01"><joint name="{side}coupler" axis="{sign} 0 0"/>
          {GEOM.format("0 0 0.045")}</body></body>
      <body name="{side}spring" pos="0 {0.01 * sign} 0.02">
        <joint name="{side}spring" axis="{sign} 0 0" stiffness="0.05" springref="20"/>
        {GEOM.format(f"0 {0.03 * sign} 0.02")}
        <body name="{side}follower" pos="0 {0.03 * sign} 0.02"><joint name="{side}follower" axis="{sign} 0 0"/>
          {GEOM.format(f"0 {0.02 * sign} 0.015")}</body></body>"""


GRIPPER = f'<body name="hand"><site name="flange"/>{finger("r", 1)}{finger("l", -1)}</body>'
PINS = """
  <connect name="r" body1="rfollower" body2="rcoupler" anchor="0 0.02 0.015"/>
  <connect name="l" body1="lfollower" body2="lcoupler" anchor="0 -0.02 0.015"/>"""
BY_JOINT = PINS + '<joint name="both" joint1="rdriver" joint2="ldriver" polycoef="0 1 0 0 0"/>'
BY_TENDON = PINS + '<tendon name="both" tendon1="rt" tendon2="lt" polycoef="0 1 0 0 0"/>'
TENDONS = """<tendon><fixed name="rt"><joint joint="rdriver" coef="0.5"/></fixed>
  <fixed name="lt"><joint joint="ldriver" coef="0.5"/></fixed></tendon>"""

# A palletiser's upper arm and its parallel rod, which carry a wrist; a second rod closes the parallelogram again.
PARALLELOGRAM = f"""
  <body name="arm" pos="0 0 0.1"><joint name="arm" axis="0 1 0" range="-80 80"/>{GEOM.format("0 0 0.3")}
    <body name="wrist" pos="0 0 0.3"><joint name="wrist" axis="0 1 0"/>{GEOM.format("0.1 0 0")}
      <site name="tip" pos="0.1 0 0"/></body></body>
  <body name="rod" pos="-0.05 0 0.1"><joint name="rod" axis="0 1 0"/>{GEOM.format("0 0 0.3")}</body>
  <body name="rod2" pos="0.05 0 0.1"><joint name="rod2" axis="0 1 0"/>{GEOM.format("0 0 {}")}</body>"""
LEVELS = """
  <connect name="level" body1="wrist" body2="rod" anchor="-0.05 0 0"/>
  <connect name="level2" body1="wrist" body2="rod2" anchor="0.05 0 0"/>"""


def written(bodies: str, equalities: str, more: str = "") -> str:
    return f"<mujoco><worldbody>{bodies}</worldbody>{more}<equality>{equalities}</equality></mujoco>"


def studied(
    model: str, drives: dict[str, str], edit: Callable[[mujoco.MjModel], None] = lambda _: None
) -> tuple[DrivenTree, Mobility, set[str]]:
    """A driven machine after its way, its mobility, and the points that are judged."""
    compiled = mujoco.MjModel.from_xml_string(model)
    edit(compiled)
    bench = study._LoopBench.from_request(compiled, LoopRequest(drives, seconds=1.0))
    return bench.machine, bench.freedom, {point.name for point in bench.points}


def test_achilles_rod_spins_idly_and_its_base_and_arm_are_held() -> None:
    machine, found, judged = studied(written(ACHILLES, HEEL), {"knee": "sine:10deg,1Hz", "spring": "hold"})
    # Knee, spring, tarsus and the rod's three rates, of which the connect takes three.
    assert (found.freedom, found.rank, found.remaining_dof) == (6, 3, 3)
    assert found.idle == ("rod",)
    assert not found.redundant
    assert machine.held == ("base", "arm")
    # The only site is on the held thigh, and frames of bodies stand where the driven knee puts them: what is judged is
    # what the loop moves, and none that only the rod's spin could move.
    assert judged == {"centre of gravity of tarsus", "centre of gravity of rod"}


def test_what_else_to_drive_is_named_with_a_spring_to_hold_first() -> None:
    with pytest.raises(InvalidInput, match=r"leaves 3, 1 of them idle, and 1 is driven: drive 1 more.*: spring, or"):
        studied(written(ACHILLES, HEEL), {"knee": "sine:10deg,1Hz"})


@pytest.mark.parametrize(("coupling", "more"), [(BY_JOINT, ""), (BY_TENDON, TENDONS)])
def test_spring_gripper_has_three_freedoms_by_joint_or_tendon(coupling: str, more: str) -> None:
    drives = {"rdriver": "move:0,20deg,1s", "rspring": "hold", "lspring": "hold"}
    machine, found, judged = studied(written(GRIPPER, coupling, more), drives)
    assert (found.freedom, found.rank, found.remaining_dof) == (8, 5, 3)
    assert dict(found.redundant) == {"r": 1, "l": 1}  # each connect's row along the hinges
    assert "flange" not in judged
    # The left follower's frame is on its hinge, on a link that is held: no closure moves it.
    assert "lfollower" in found.rigid
    assert "lcoupler" in judged
    end = machine.motion(np.array([1.0])).coordinates[:, 0]
    by_name = {joint.name: end[joint.coordinate] for joint in machine.tree.joints}
    assert by_name["ldriver"] == pytest.approx(math.radians(20.0), abs=1e-14)
    assert by_name["lfollower"] == pytest.approx(by_name["rfollower"], abs=1e-13)
    with pytest.raises(InvalidInput, match="leaves 4"):  # negative control: without its coupling
        studied(written(GRIPPER, PINS), drives)


@pytest.mark.parametrize(("length", "misfit"), [(0.3, 0.0), (0.3 + 1e-5, 1e-6)])
def test_double_parallelogram_has_redundant_rows_and_a_misfit(length: float, misfit: float) -> None:
    bodies = PARALLELOGRAM.replace('fromto="0 0 0 0 0 {}"', f'fromto="0 0 0 0 0 {length}"')

    def longer(compiled: mujoco.MjModel) -> None:
        compiled.eq_data[1, 5] += (
            length - 0.3
        )  # the second rod's end: a hundredth of a millimetre contradicts the first

    machine, found, judged = studied(written(bodies, LEVELS), {"arm": "sine:30deg,1Hz"}, longer)
    assert found.remaining_dof == 1
    assert judged == {"tip"}
    assert dict(found.redundant) == {"level": 1, "level2": 2}
    assert (machine.misfit > misfit) if misfit else (machine.misfit < 1e-14)
    tip = machine.motion(np.linspace(0.0, 1.0, 9)).points["tip"]
    level = tip.position[:, 2] - 0.1 - 0.3 * np.cos(np.radians(30.0 * np.sin(2 * np.pi * np.linspace(0.0, 1.0, 9))))
    assert np.abs(level).max() < (20 * 1e-5 if misfit else 1e-13)  # the wrist stays level


# -- the file as it is -------------------------------------------------------------------------------------------------

RESET, SWINGS = "it ended as reset: MuJoCo reset its state (BADQACC)", "turns back at every step"


def shipped(actuator: str, control: float, folder: Path, monkeypatch: pytest.MonkeyPatch) -> LoopStudy:
    """Study of the palletiser's arm with an actuator, in few runs."""
    for name, cheap in {"COARSER": (2,), "FINER": (), "CHECKED_INSTANTS": 9}.items():
        monkeypatch.setattr(study, name, cheap)
    file = folder / "arm.xml"
    file.write_text(written(PARALLELOGRAM.format(0.3), LEVELS, actuator), encoding="utf-8")
    return study.study_loops(file, LoopRequest({"arm": "sine:10deg,5Hz"}, controls=(("0", control),)), "arm")


@pytest.mark.parametrize(
    ("stiffness", "force", "said"),
    [
        (1000.0, 1e12, RESET),
        (40.0, 0.5, SWINGS),  # its force is limited: the rate alternates about what is asked
        (0.5, 0.5, ""),  # negative control: healthy
    ],
)
def test_verdict_starts_with_an_actuator_too_stiff_for_the_step(
    stiffness: float, force: float, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    actuator = f'<actuator><velocity joint="arm" kv="{stiffness}" forcerange="-{force} {force}"/></actuator>'
    found = shipped(actuator, 0.3, tmp_path, monkeypatch)
    assert found.shipped.failed == bool(said)
    assert found.passed != bool(said)
    # The drive masks the actuator: with it the loops stay closed, and that comes second.
    first, second = finding(found).split(". ")[:2]
    assert first.startswith("Run as the file has it")
    assert second.startswith("Driven with its own settings its loops open by")
    assert said in first


def test_verdict_names_presets_that_fail_with_a_stiff_actuator(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    implicit = '<option integrator="implicitfast"/><actuator><velocity joint="arm" kv="1000"/></actuator>'
    found = shipped(implicit, 0.0, tmp_path, monkeypatch)
    assert not found.shipped.failed
    assert found.presets["hardened"].outcome is Outcome.DIVERGED  # RK4, which is not implicit
    assert "But with it and its own actuators the file ended as diverged" in finding(found)
