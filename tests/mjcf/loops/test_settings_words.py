"""How a model with closed loops ran, and its cheapest settings, in words, and as lines of a baseline."""

from __future__ import annotations

from dataclasses import replace

import pytest

from conrod.comparison.other_forces import CONTACT, OtherForce
from conrod.comparison.trajectory import Outcome
from conrod.exact.space.mobility import Mobility
from conrod.execution.baseline_check import baseline_line
from conrod.mjcf.loop_results import LOOPS, OWN_SETTINGS, LoopRequest, LoopRun, LoopStudy, SettingsSearch, ShippedRun
from conrod.models.loops.baseline_lines import loop_lines
from conrod.models.loops.words import settings_words, shipped_words, with_share

ERRORS = {"position": 1e-3, "velocity": 0.1, "acceleration": 2.0}
RUN = LoopRun(OWN_SETTINGS, 1e-3, Outcome.COMPLETED, errors=ERRORS, worst="A", gap=5e-4, order=2.0)
SHIPPED = ShippedRun("its own pose", 12.345, Outcome.COMPLETED, "", gap=1e-4, path=0.7)
CHATTERS = replace(SHIPPED, chatter=("crank", 0.504))
DIVERGES = replace(SHIPPED, outcome=Outcome.DIVERGED, reason="not finite at 0.1 s")
STUDY = LoopStudy(
    "m.xml", "m", "MuJoCo", LoopRequest({"crank": "40rpm"}, tolerance={"position": 1e-3}), 1.0, 0.2, (),
    Mobility(4, 3, 3, {}, (), (), 1.0, 0.0), 0.0, {"position": 1e-12}, (), (), (), SHIPPED,
    (RUN, replace(RUN, label="tuned")), (), scales={"position": 0.2, "velocity": 4.0},
)  # fmt: skip
FOUND = SettingsSearch(
    {"position": 2e-3}, ("hardened", "tuned"), (1e-3, 8e-3), replace(RUN, label="hardened", timestep=4e-3, cost=0.25),
    SHIPPED, replace(RUN, label="hardened", timestep=8e-3, errors={"position": 6e-3}, gap=3e-3), SHIPPED, speed=16.0,
    own_speed=4.0,
)  # fmt: skip


@pytest.mark.parametrize(("run", "words"), [
    (SHIPPED, "runs through its 12.3 s, its loops open by up to 0.10 mm"),
    (CHATTERS, "oscillates: the rate of crank turns back at every step, by 50 % of its range"),
    (DIVERGES, "ended as diverged: not finite at 0.1 s"),
])  # fmt: skip
def test_own_run_is_described_by_how_it_ended(run: ShippedRun, words: str) -> None:
    assert shipped_words(run) == words


@pytest.mark.parametrize(("name", "size", "words"), [
    ("position", 1e-4, "0.10 mm (5.0e-4 L)"),
    (LOOPS, 3e-4, "0.30 mm (0.0015 L)"),
    ("velocity", 0.1, "0.10 m/s (0.025 L)"),
    ("acceleration", 2.0, "2.0 m/s²"),  # of unknown scale
])  # fmt: skip
def test_sizes_have_their_share_of_the_motion(name: str, size: float, words: str) -> None:
    assert with_share(STUDY, name, size) == words


def said(**changed: object) -> str:
    return settings_words(replace(STUDY, search=replace(FOUND, **changed)))  # type: ignore[arg-type]


def test_cheapest_settings_are_said_with_the_next_coarser() -> None:
    begins = (
        "The cheapest that holds position 2.0 mm (0.010 L): hardened with a step of 4 ms, at 0.25 times the cost of "
        "its own settings (16 times real time on this machine, with its own 4.0); "
    )
    ends = " With these and its own actuators the file runs through its 12.3 s, its loops open by up to 0.10 mm."
    coarser = "hardened with a step of 8 ms leaves position 6.0 mm (0.030 L), loops open 3.0 mm (0.015 L)."
    assert said() == begins + coarser + ends
    assert said(shipped=None) == begins + coarser
    held = replace(RUN, label="hardened", timestep=8e-3)
    ended = "with a step of 8 ms and its own actuators it ended as diverged: not finite at 0.1 s."
    assert said(coarser=held, coarser_shipped=DIVERGES) == begins + ended + ends
    opened = replace(held, outcome=Outcome.OPENED, reason="pin opens by 20 mm")
    assert said(coarser=opened) == f"{begins}hardened with a step of 8 ms ended as opened: pin opens by 20 mm.{ends}"


def test_contacts_are_said_to_harden_where_weights_are_scaled() -> None:
    harder = " Contacts of the bodies whose weights are scaled harden with its loops."
    touching = (OtherForce(CONTACT, "a and b", 1.0, "N"),)
    rubbing = (OtherForce("friction", "crank", 1.0, "N m"),)
    for best, own, lines, told in (
        (touching, (), "model.body_invweight0[1] *= 2", True),
        ((), touching, "model.body_invweight0[1] *= 2", True),
        (rubbing, (), "model.body_invweight0[1] *= 2", False),
        (touching, touching, "", False),
    ):
        runs = {"best": replace(RUN, cost=1.0, acting=best), "shipped": replace(SHIPPED, acting=own)}
        assert said(**runs, after_compiling=lines).endswith(f" mm.{harder * told}")


def test_nearest_settings_are_said_where_none_hold() -> None:
    nothing = "None of the settings that were tried holds position 2.0 mm (0.010 L): hardened, tuned, in steps of"
    nothing += " 1 ms to 8 ms"
    assert said(best=None) == f"{nothing}."
    nearest = "; nearest: hardened with a step of 8 ms leaves position 6.0 mm (0.030 L), loops open 3.0 mm (0.015 L)."
    assert said(best=None, nearest=FOUND.coarser) == nothing + nearest


def test_judged_loops_are_lines_of_a_baseline() -> None:
    sizes = {**ERRORS, LOOPS: 5e-4, "order of position": 2.0}
    lines = {
        "kinematics": baseline_line("completed", True, {"position": 1e-12}),
        "its own run": baseline_line("completed", True, {LOOPS: 1e-4, "path": 0.7}),
        "driven, as it is": baseline_line("completed", True, sizes),
        "driven, tuned": baseline_line("completed", None, sizes),
    }
    assert loop_lines([STUDY]) == lines
    wrong = replace(
        STUDY, name="w", kinematic={"position": 1e-3}, shipped=CHATTERS, runs=(replace(RUN, gap=2e-3),),
    )  # fmt: skip
    assert loop_lines([STUDY, wrong]) == {f"m {name}": line for name, line in lines.items()} | {
        "w kinematics": baseline_line("completed", False, {"position": 1e-3}),
        "w its own run": baseline_line("completed", False, {}),
        "w driven, as it is": baseline_line("completed", False, {**sizes, LOOPS: 2e-3}),
    }
