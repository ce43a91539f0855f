"""The cheapest settings for a model's loops: how they are searched, and lines to paste that do what was measured."""

from __future__ import annotations

import math
import re
import xml.etree.ElementTree as ET
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import mujoco
import numpy as np
import pytest
from four_bars import four_bar

from conrod.comparison.other_forces import CONTACT, OtherForce
from conrod.comparison.trajectory import Outcome
from conrod.engines.mujoco.compat import enable_bit
from conrod.execution.paired_timing import PairedTiming
from conrod.mjcf.edits import Edit, apply_recipe
from conrod.mjcf.loop_results import OWN_SETTINGS, LoopRequest, LoopRun, LoopStudy, SettingsSearch, ShippedRun
from conrod.models.loops import study
from conrod.models.loops.search import _excess, search_settings
from conrod.models.loops.settings import after_compiling, mjcf_lines, python_lines, settings_edits
from conrod.models.loops.words import lines_to_paste, settings_words

RUNS = ShippedRun("its own pose", 1.0, Outcome.COMPLETED, "", 1e-9)
FAILS, OPENS = replace(RUNS, outcome=Outcome.DIVERGED), replace(RUNS, gap=1e-3)
STEP, ALLOWED = 1e-3, {"position": 1e-4}
COSTS = {OWN_SETTINGS: 1.0, "hardened": 5.0, "tuned": 4.0}


def search(
    errors: dict[str, Callable[[float], float]], limits: tuple[int, int] = (-6, 6), fails: float = math.inf,
    guesses: dict[str, int] | None = None, own: ShippedRun = RUNS,
    opens: float = 0.0,
) -> tuple[SettingsSearch, list[tuple[str, int]]]:  # fmt: skip
    """Search among settings whose errors of position [m] at a step [s] are known; return what was tried, too.

    Args:
        fails: step [s] from which on the file's own run diverges.
        own: the file's own run as it is.
        opens: what its loops open by in its own run [m] at the model's step, in proportion to the step.
    """
    tried = list[tuple[str, int]]()

    def run_at(name: str, step: float) -> tuple[LoopRun, ShippedRun]:
        tried.append((name, round(math.log2(step / STEP))))
        shipped = replace(RUNS, gap=opens * step / STEP)
        shipped = replace(shipped, outcome=Outcome.DIVERGED, reason="not finite") if step >= fails else shipped
        size = errors[name](step)
        if math.isinf(size):
            return LoopRun(name, step, Outcome.OPENED, "pin opens by 20 mm"), shipped
        return LoopRun(name, step, Outcome.COMPLETED, "", {"position": size}, "P", size), shipped

    def timing_of(name: str) -> PairedTiming:
        return PairedTiming(COSTS[name], COSTS[name], COSTS[name], COSTS[name] * 1e-6, 1e-6, 1)

    started = guesses or dict.fromkeys(errors, 0)
    found = search_settings(run_at, timing_of, started, ALLOWED, STEP, limits, own=own)
    return found, tried


# -- the search --------------------------------------------------------------------------------------------------------


def test_limits_of_nothing_hold_for_no_setting() -> None:
    run, shipped = LoopRun("hardened", STEP, Outcome.COMPLETED, "", {"position": 0.0}, "P", 0.0), RUNS
    assert _excess(run, shipped, {"position": 0.0}, "any", math.inf) == math.inf
    assert _excess(run, shipped, {"position": 1e-4}, "within", 0.0) == math.inf
    assert _excess(run, shipped, {"position": 1e-4}, "within", 1e-8) == pytest.approx(0.1)


def test_nothing_is_nearest_where_no_run_completed() -> None:
    found, _ = search({"hardened": lambda h: math.inf})
    assert (found.best, found.nearest) == (None, None)


def test_weights_are_read_again_where_a_flag_had_hid_them() -> None:
    model = mujoco.MjModel.from_xml_string(four_bar())
    hidden, kept = enable_bit("DIAGEXACT"), int(mujoco.mjtEnableBit.mjENBL_ENERGY)
    model.opt.enableflags = hidden | kept
    flags = [edit for edit in settings_edits(model, "hardened", 1e-3, 1.0, idle=False) if edit.array == "enableflags"]
    assert flags == ([Edit("enableflags", kept)] if hidden else [])
    model.opt.enableflags = kept
    assert "enableflags" not in [edit.array for edit in settings_edits(model, "hardened", 1e-3, 1.0, idle=False)]


def test_search_finds_8_ms_where_16_ms_fails_and_shows_both() -> None:
    # 1e-4 m at 11.9 ms, by order 4: within at 8 ms, out of tolerance at 16 ms.
    found, tried = search({"hardened": lambda h: 1e-4 * (h / 11.9e-3) ** 4})
    assert found.best is not None
    assert found.coarser is not None
    assert (found.best.timestep, found.coarser.timestep) == (8e-3, 16e-3)
    assert found.best.is_within(ALLOWED)
    assert not found.coarser.is_within(ALLOWED)
    assert tried == [("hardened", power) for power in range(5)]
    assert (found.best.cost, found.coarser.cost) == (5.0 / 8.0, 5.0 / 16.0)
    # 5 us a step of 8 ms, and 1 us a step of 1 ms.
    assert (found.speed, found.own_speed) == (pytest.approx(1600.0), pytest.approx(1000.0))


def test_search_goes_to_finer_steps_by_the_order_that_it_sees() -> None:
    # 1e-4 m at 0.02 ms, by order 1: at 1/64 ms, from 1/4 ms on.
    found, tried = search({"tuned": lambda h: 1e-4 * h / 0.02e-3}, guesses={"tuned": -2})
    assert found.best is not None
    assert found.best.timestep == STEP / 64
    assert tried == [("tuned", -2), ("tuned", -3), ("tuned", -6), ("tuned", -5)]
    assert found.coarser is not None
    assert found.coarser.timestep == STEP / 32
    # An error that no step lessens is not followed to the finest step.
    stuck, tried = search({OWN_SETTINGS: lambda h: 2e-4}, guesses={OWN_SETTINGS: -2})
    assert tried == [(OWN_SETTINGS, -2), (OWN_SETTINGS, -3)]
    assert stuck.best is None
    assert stuck.nearest is not None


def test_search_says_how_far_it_went_where_nothing_holds() -> None:
    found, _ = search(
        {"tuned": lambda h: 1e-4 * h / 1e-6, OWN_SETTINGS: lambda h: math.inf}, guesses={"tuned": 0, OWN_SETTINGS: 0}
    )
    assert (found.best, found.shipped, found.coarser) == (None, None, None)
    assert found.steps == (STEP / 64, STEP)
    assert found.nearest is not None
    assert (found.nearest.label, found.nearest.timestep) == ("tuned", STEP / 64)


def test_search_that_is_ended_tries_nothing_more() -> None:
    left = iter([True, True, True, False])
    made = list[float]()

    def run_at(name: str, step: float) -> tuple[LoopRun, ShippedRun]:
        made.append(step)
        return LoopRun(name, step, Outcome.COMPLETED, "", {"position": 0.01 * step}, "P", 0.0), RUNS

    timing = PairedTiming(1.0, 1.0, 1.0, 1e-6, 1e-6, 1)
    found = search_settings(run_at, lambda name: timing, {"hardened": 0, "tuned": 0}, ALLOWED, STEP, (-6, 6), own=RUNS,
                            may_go_on=lambda: next(left, False))  # fmt: skip
    # Of steps that hold up to 8 ms two were tried, and the larger one is said.
    assert len(made) == 2
    assert found.best is not None
    assert found.best.timestep == max(made)
    nothing = search_settings(run_at, lambda name: timing, {"tuned": 0}, ALLOWED, STEP, (0, 0), own=RUNS,
                              may_go_on=lambda: False)  # fmt: skip
    assert nothing.best is None
    assert len(made) == 2


def test_search_ends_at_the_largest_step_without_another_side() -> None:
    found, _ = search({"hardened": lambda h: 1e-9}, limits=(-6, 3))
    assert found.best is not None
    assert (found.best.timestep, found.coarser) == (8e-3, None)


def test_dearer_settings_are_tried_where_they_would_be_cheaper() -> None:
    # Hardened holds at 8 ms, at 0.625 of the cost; own settings do at 1 ms and not at 2 ms, the first that is cheaper.
    held = {"hardened": lambda h: 1e-4 * (h / 11.9e-3) ** 4, OWN_SETTINGS: lambda h: 1e-4 * h / 1.5e-3}
    found, tried = search(held)
    assert found.best is not None
    assert found.best.label == "hardened"
    assert [one for one in tried if one[0] == OWN_SETTINGS] == [(OWN_SETTINGS, 1)]
    # Control: where they hold at 2 ms they are the cheapest.
    found, tried = search({**held, OWN_SETTINGS: lambda h: 1e-4 * h / 2.5e-3})
    assert found.best is not None
    assert (found.best.label, found.best.timestep, found.best.cost) == (OWN_SETTINGS, 2e-3, 0.5)
    assert found.coarser is not None
    assert found.coarser.timestep == 4e-3


def test_settings_must_carry_the_files_own_run_too() -> None:
    exact = {"hardened": lambda h: 1e-9}
    found, _ = search(exact, fails=4e-3)
    assert found.best is not None
    assert found.coarser_shipped is not None
    assert found.best.timestep == 2e-3
    assert found.coarser_shipped.failed
    # A file that does not run as it is gets those with which it does, too, and others only where there are none.
    found, _ = search(exact, fails=4e-3, own=FAILS)
    assert found.best is not None
    assert found.best.timestep == 2e-3
    found, tried = search(exact, fails=0.0, own=FAILS)
    assert found.best is not None
    assert found.best.timestep == 64e-3
    assert len(tried) == len(set(tried))
    assert search(exact, fails=0.0)[0].best is None
    # Loops that open by 0.1 mm at 4 ms in its own run, and in none of its steps by less than 1 mm.
    for opens, own, step in ((2.5e-5, RUNS, 4e-3), (2.5e-5, OPENS, 4e-3), (1.0, OPENS, 64e-3)):
        found, _ = search(exact, own=own, opens=opens)
        assert found.best is not None
        assert found.best.timestep == step
    assert search(exact, opens=1.0)[0].best is None
    # Loops of a run that nothing drives need not stay closer than they do as it is, by 0.2 mm: at 8 ms.
    found, _ = search(exact, own=replace(RUNS, gap=2e-4, driven=False), opens=2.5e-5)
    assert found.best is not None
    assert found.best.timestep == 8e-3


# -- lines to paste ----------------------------------------------------------------------------------------------------

# A four-bar whose closure has a setting of its own, a coupling without one, a limit, a contact and a handle.
MORE = """<equality><joint name="pair" joint1="twin" joint2="crank" polycoef="0 1 0 0 0"/>
    <weld name="hold" body1="stylus" body2="twin" active="{}" solref="0.05 1"/></equality>
  <worldbody><body name="stylus" mocap="true" pos="0 0 3"/>
    <body name="twin" pos="0 0 3"><joint name="twin" axis="0 0 1" range="-50 50" limited="true"/>
    <geom size="0.01"/></body></worldbody>"""


def model_text(active: str = "false", closure: str = 'solref="0.004 1"') -> str:
    return four_bar(closure=closure, more=MORE.format(active))


def pasted(text: str, lines: str, after: str) -> mujoco.MjModel:
    """The model compiled after a user pasted the lines of MJCF, and ran those of Python."""
    root = ET.fromstring(text.replace("</mujoco>", f"{re.sub('<!--.*?-->', '', lines)}</mujoco>"))
    for names, attributes in re.findall(r"<!-- in <equality>, into (.*?): (.*?) -->", lines):
        for one in (one for section in root.iter("equality") for one in section):
            if one.get("name") in names.split(", "):
                one.attrib.update(re.findall(r'(\w+)="(.*?)"', attributes))
    model = mujoco.MjModel.from_xml_string(ET.tostring(root, encoding="unicode"))
    exec(after, {"model": model, "mujoco": mujoco})
    return model


def settings_of(model: mujoco.MjModel) -> dict[str, object]:
    """All that settings could change of a model."""
    softness = [f"{kind}_{name}" for kind in ("eq", "geom", "jnt", "dof") for name in ("solref", "solimp")]
    arrays = [*softness, "body_invweight0", "dof_invweight0"]
    option = [getattr(model.opt, name) for name in ("timestep", "integrator", "solver", "iterations", "tolerance")]
    return {name: getattr(model, name).tolist() for name in arrays} | {"option": option}


@pytest.mark.parametrize("name", ["hardened", "tuned", "tuned with implicitfast", OWN_SETTINGS])
@pytest.mark.parametrize("active", ["true", "false"])
def test_pasted_lines_make_the_settings_that_were_measured(name: str, active: str, tmp_path: Path) -> None:
    text, file = model_text(active), tmp_path / "m.xml"
    file.write_text(text)
    model = mujoco.MjModel.from_xml_string(text)
    recipe = settings_edits(model, name, 0.016, 1.0, idle=False)
    measured = settings_of(apply_recipe(model, recipe))
    lines, after = mjcf_lines(file, model, recipe), "\n".join(after_compiling(recipe))
    assert settings_of(pasted(text, lines, after)) == measured
    in_python = mujoco.MjModel.from_xml_string(text)
    exec(python_lines(recipe), {"model": in_python, "mujoco": mujoco})
    assert settings_of(in_python) == measured
    # Closures alone: no contact, no limit, and no handle.
    own = settings_of(model)
    assert {k for k in own if own[k] != measured[k]} <= {"option", "eq_solref", "eq_solimp", "body_invweight0",
                                                         "dof_invweight0"}  # fmt: skip
    assert measured["eq_solref"][2] == [0.05, 1.0]
    if name != OWN_SETTINGS:
        # Control: the default alone leaves the closure its own setting, which stands before it.
        alone = pasted(text, lines.split("<!--")[0], after)
        assert alone.eq_solref[0].tolist() == [0.004, 1.0]
        assert settings_of(alone) != measured


OPTION = '<option timestep="0.001" integrator="RK4" solver="Newton" iterations="100" tolerance="1e-30"/>'
CLOSURES = '<default><equality solref="{} 1" solimp="0.9999 0.9999 0.001 0.5 2"/></default>'
WEIGHTS = """# again, after mj_setConst has computed these anew:
model.body_invweight0[[3, 4]] *= {}  # coupler, rocker"""


@pytest.mark.parametrize(("name", "idle", "lines", "after"), [
    (OWN_SETTINGS, False, '<option timestep="0.001" tolerance="1e-30"/>', ""),
    ("tuned", False, f"{OPTION}\n{CLOSURES.format(0.008)}", ""),
    ("hardened", False, f"{OPTION}\n{CLOSURES.format(0.15)}", WEIGHTS.format("1e-09")),
    ("hardened", True, f"{OPTION}\n{CLOSURES.format(0.15)}", WEIGHTS.format("1e-07")),
    ("tuned with implicitfast", True, f"{OPTION.replace('RK4', 'implicitfast')}\n{CLOSURES.format(0.002)}", ""),
])  # fmt: skip
def test_settings_are_said_as_mjcf(name: str, idle: bool, lines: str, after: str, tmp_path: Path) -> None:
    file = tmp_path / "m.xml"
    file.write_text(four_bar())
    model = mujoco.MjModel.from_xml_string(four_bar())
    recipe = settings_edits(model, name, 0.001, 1.5, idle=idle)
    assert mjcf_lines(file, model, recipe) == lines
    assert "\n".join(after_compiling(recipe)) == after


def test_default_is_pasted_where_it_changes_closures_alone(tmp_path: Path) -> None:
    file = tmp_path / "m.xml"
    plain = model_text(closure="").replace(' solref="0.05 1"', "")
    for text, has_default in ((model_text(closure=""), False), (four_bar(), True), (plain, False)):
        file.write_text(text)
        model = mujoco.MjModel.from_xml_string(text)
        recipe = settings_edits(model, "tuned", 0.002, 1.0, idle=False)
        lines = mjcf_lines(file, model, recipe)
        assert ("<default>" in lines) == has_default, lines
        assert settings_of(pasted(text, lines, "")) == settings_of(apply_recipe(model, recipe))
    assert mjcf_lines(tmp_path / "m.mjb", model, recipe) == ""


# -- a model's study ---------------------------------------------------------------------------------------------------


@cache
def found_study(folder: Path, share: float = 0.0) -> LoopStudy:
    file = folder / "four-bar.xml"
    file.write_text(four_bar(closure='solref="0.01 1"'))
    tolerance = {} if share else {"position": 1e-7}
    with pytest.MonkeyPatch.context() as patch:
        for name, cheap in {"COARSER": (4,), "FINER": (), "CHECKED_INSTANTS": 9}.items():
            patch.setattr(study, name, cheap)
        patch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
        question = LoopRequest({"crank": "60rpm"}, seconds=0.25, tolerance=tolerance, searched_share=share)
        return study.study_loops(file, question, "four-bar")


@pytest.fixture(scope="module")
def found(tmp_path_factory: pytest.TempPathFactory) -> LoopStudy:
    return found_study(tmp_path_factory.mktemp("models"))


def test_study_of_a_four_bar_goes_beyond_four_times_its_step(found: LoopStudy) -> None:
    search = found.search
    assert search is not None
    assert search.best is found.cheapest is not None
    assert search.best.timestep > 4e-3
    assert search.best.is_within(found.question.tolerance)
    assert search.coarser is not None
    assert search.coarser.timestep == pytest.approx(2.0 * search.best.timestep)
    assert not search.coarser.is_within(found.question.tolerance)
    words = settings_words(found)
    assert words.startswith("The cheapest that holds position 1.0e-4 mm (")
    assert f" L): {search.best.label} with a step of " in words
    assert f"; {search.best.label} with a step of {2e3 * search.best.timestep:.4g} ms " in words
    assert words.endswith("With these and its own actuators the file runs through its 0.25 s, its loops open by up to "
                          f"{words.split()[-2]} mm.")  # fmt: skip
    assert "times real time on this machine, with its own " in words


def test_pasted_lines_measured_again_give_the_same_errors(found: LoopStudy, tmp_path: Path) -> None:
    assert found.search is not None
    assert found.cheapest is not None
    text = four_bar(closure='solref="0.01 1"')
    model = pasted(text, found.paste, found.search.after_compiling)
    bench = study._LoopBench.from_request(model, found.question)
    again = bench._record_model("pasted", model, found.travel)[0]
    assert again.errors == found.cheapest.errors
    # Control: as the file is it is another motion.
    own = mujoco.MjModel.from_xml_string(text)
    own.opt.timestep = found.cheapest.timestep
    assert bench._record_model("own", own, found.travel)[0].errors != found.cheapest.errors
    titles = [title for title, _ in lines_to_paste(found)]
    assert titles[0].endswith("to paste before </mujoco>")
    assert titles[-1] == "or all of it in Python"


def test_words_say_why_no_larger_step_was_tried(found: LoopStudy) -> None:
    assert found.search is not None
    for borne, why in ((False, "the motion would have fewer than 8"), (True, "its actuators bear none")):
        ended = replace(found, search=replace(found.search, coarser=None, coarser_shipped=None, borne=borne))
        assert f"; no larger step was tried: {why}. With these" in settings_words(ended)


def test_words_say_where_a_search_was_ended(found: LoopStudy) -> None:
    assert found.search is not None
    cut = settings_words(replace(found, search=replace(found.search, ended=12.0)))
    assert cut.startswith("The cheapest of those tried in 12 s of CPU time that holds ")
    untried = replace(found.search, best=None, steps=(1e-3, 1e-3), ended=12.0)
    words = settings_words(replace(found, search=untried))
    assert words.startswith("No settings were searched that hold ")
    assert words.endswith("the runs before took longer than 12 s.")
    assert "CPU time" not in settings_words(found)


def test_words_say_that_contacts_harden_where_any_acted(found: LoopStudy) -> None:
    search = found.search
    assert search is not None
    assert search.best is not None
    assert "Contacts" not in settings_words(found)
    touching = replace(search.best, acting=(OtherForce(CONTACT, "a and b", 1.0, "N"),))
    for lines, said in ((search.after_compiling, True), ("", False)):
        words = settings_words(replace(found, search=replace(search, best=touching, after_compiling=lines)))
        assert ("Contacts of the bodies whose weights are scaled harden with its loops." in words) is said


def test_words_name_the_nearest_settings_where_none_hold(found: LoopStudy) -> None:
    assert found.search is not None
    nothing = replace(
        found.search, best=None, nearest=found.driven_run, steps=(1e-3 / 64, 1e-3), allowed={"position": 1e-12}
    )
    words = settings_words(replace(found, search=nothing))
    assert words.startswith("None of the settings that were tried holds position 1.0e-9 mm (")
    assert ": hardened, tuned, as it is, tuned with implicitfast, tuned with Euler, tuned with implicit, in " in words
    assert " in steps of 0.01562 ms to 1 ms; nearest: as it is with a step of 1 ms leaves position " in words
    assert settings_words(replace(found, search=None)) == ""


@pytest.mark.slow
def test_settings_are_found_for_a_share_of_the_travel_if_asked(tmp_path: Path) -> None:
    found = found_study(tmp_path, 1e-3)
    assert found.search is not None
    assert found.search.allowed == {"position": 1e-3 * found.scales["position"]}
    assert " L): " in settings_words(found)
    assert found.passed == (found.driven_run.errors["position"] >= 0.0)  # measured, not judged
    assert np.isfinite(found.search.speed)
