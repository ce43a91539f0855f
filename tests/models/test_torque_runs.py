"""A run under a torque is judged by the exact motion; planted slips are seen, and named."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod as typed
from command_line import kept_worker
from scipy.integrate import solve_ivp

import conrod
from conrod import InvalidInput
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.exact.motion import Array
from conrod.mechanism.loads import Friction, Load, LoadLaw, Sampled, Steady, Turn, Viscous
from conrod.mechanism.mechanism import GROUND, Mechanism
from conrod.models.torque_runs.exact import CrankStart, exact_motion, quantities_of, start_state
from conrod.models.torque_runs.study import TorqueRunStudy
from conrod.models.torque_runs.torque import Torque
from conrod.scenes import SCENES

SAW = SCENES["saw-500rpm"]
MACHINE = SAW.kinematics.mechanism
TIMES = 1e-3 * np.arange(121)
REST = CrankStart(0.0, 0.0)
Columns = dict[str, Array]


@pytest.fixture(autouse=True)
def here(monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are read in a process that is kept."""
    monkeypatch.setattr("conrod.execution.local.WorkerProcess", kept_worker)


def run_of(
    law: LoadLaw = Steady(5.0),  # noqa: B008 # frozen
    machine: Mechanism = MACHINE,
    start: CrankStart = REST,
    times: Array = TIMES,
    extra: tuple[Load, ...] = (),
) -> Columns:
    """Columns of an exact run."""
    dynamics = ForwardDynamics(replace(machine, loads=(*machine.loads, Torque(law, "").acts_on(machine), *extra)))
    motion = dynamics.motion(times, {}, start_state(SAW, dynamics, start))
    found = quantities_of(SAW, motion.poses, motion.rates, motion.accelerations)
    return {"time": times} | {name: found[name] for name in ("crank_angle", "crank_speed", "C.x", "C.vx")}


def judged(table: Columns, torque: Any = 5.0, start: Any = 0.0, **words: Any) -> TorqueRunStudy:
    study: TorqueRunStudy = conrod.check(table, SAW, torque=torque, start=start, **words).study
    return study


def heavier(name: str, factor: float) -> Mechanism:
    bodies = tuple(
        replace(one, mass=factor * one.mass, inertia=factor * one.inertia) if one.name == name else one
        for one in MACHINE.bodies
    )
    return replace(MACHINE, bodies=bodies)


def one_row_late() -> Columns:
    """Each row has the values of the row before."""
    return {name: own[1:] if name == "time" else own[:-1] for name, own in run_of().items()}


CRANK = Turn(GROUND, MACHINE.crank)
# Slips, each with the kind of its cause and words that its text has.
PLANTED: dict[str, tuple[Callable[[], Columns], str, str]] = {
    "torque": (lambda: run_of(Steady(5.05)), "torque", "the torque is 1.01 times the given one"),
    "stamp": (one_row_late, "time", "each row belongs 0.001 s (1 of a row) earlier than its time says"),
    "inertia": (lambda: run_of(machine=heavier("crank", 1.02)), "inertia of crank", "are 1.02 times the machine's"),
    "mass": (lambda: run_of(machine=heavier("slider", 1.02)), "inertia of slider", "are 1.02 times the machine's"),
    "speed": (lambda: run_of(start=CrankStart(0.0, 0.5)), "start speed", "the run starts at 4.77"),
    "angle": (lambda: run_of(start=CrankStart(0.1, 0.0)), "start angle", "starts at crank angle 5.729"),
    "gravity": (lambda: run_of(machine=replace(MACHINE, gravity=(0.0, 0.0))), "gravity", "gravity is missing"),
    "damping": (
        lambda: run_of(extra=(Load("damping", CRANK, Viscous(0.02)),)), "viscous friction", "damped by 0.02 N m s/rad"
    ),
    "friction": (
        lambda: run_of(extra=(Load("friction", CRANK, Friction(0.3, 0.01)),)), "torque", "a dry friction of 0.299"
    ),
}  # fmt: skip


# A fit takes a second or two.
SLIPS = [slip if slip == "torque" else pytest.param(slip, marks=pytest.mark.slow) for slip in PLANTED]


@pytest.mark.parametrize("slip", SLIPS)
def test_a_planted_slip_is_seen_and_named(slip: str) -> None:
    plant, kind, words = PLANTED[slip]
    study = judged(plant())
    assert study.passed is False
    assert study.causes[0].kind == kind
    assert words in study.causes[0].text
    assert all(after < 0.05 * before for before, after in study.causes[0].explains.values())


def test_an_exact_run_passes() -> None:
    study = judged(run_of())
    assert study.passed
    assert (study.largest("position") or 0.0) < 1e-12
    assert study.drift < 1e-11


@pytest.mark.slow
def test_velocities_of_half_a_step_later_are_seen() -> None:
    table = run_of()
    # As of pymunk, whose velocities belong half a step later than its positions; they are judged where asked for.
    later = run_of(times=TIMES + 5e-4)
    stamped = table | {name: later[name] for name in ("crank_speed", "C.vx")}
    assert judged(stamped).passed
    study = judged(stamped, tolerance={"position": 1e-3, "speed": 1e-3})
    assert [*study.exceeded] == ["speed"]
    assert study.causes[0].kind == "velocity stamp"
    assert "0.0005 s (0.5 of a row) later" in study.causes[0].text


@pytest.mark.slow
def test_joints_that_gape_with_speed_show_a_coarse_step() -> None:
    table = run_of()
    # What an engine's step leaves: at the crank's angle the slider is off its place, as the square of the speed.
    off = 1e-4 * (table["crank_speed"] / table["crank_speed"].max()) ** 2
    (cause,) = judged(table | {"C.x": table["C.x"] + off}, tolerance={"position": 1e-5}).causes
    assert cause.kind == "coarse step"
    assert "and more so the faster it goes" in cause.text
    # Negative control: an offset that is the same at any speed is one of lengths, or of the frame.
    (cause,) = judged(table | {"C.x": table["C.x"] + 1e-3}).causes
    assert cause.kind == "lengths"


def test_exact_motion_under_a_torque_solves_the_closed_form() -> None:
    """Eksergian's equation of the saw, from its closed form alone, by another solver and at another coordinate."""
    crank, rod, slider = (MACHINE.body(name) for name in ("crank", "rod", "slider"))

    def inertia(angle: float) -> tuple[float, float, float]:
        """I, I' and V' at a crank angle."""
        motion = SAW.motion([angle], 1.0)
        c, m = motion.point("C"), motion.point("M")
        lever = c.position - m.position
        spin = (lever[0, 0] * (c.velocity - m.velocity)[0, 1] - lever[0, 1] * (c.velocity - m.velocity)[0, 0]) / 0.15**2
        change = (lever[0, 0] * (c.acceleration - m.acceleration)[0, 1]
                  - lever[0, 1] * (c.acceleration - m.acceleration)[0, 0]) / 0.15**2  # fmt: skip
        total = crank.inertia + slider.mass * (c.velocity**2).sum() + rod.mass * (m.velocity**2).sum()
        total += rod.inertia * spin**2
        slope = 2.0 * slider.mass * (c.velocity * c.acceleration).sum()
        slope += 2.0 * rod.mass * (m.velocity * m.acceleration).sum() + 2.0 * rod.inertia * spin * change
        return float(total), float(slope), float(rod.mass * 9.81 * m.velocity[0, 1])

    def derivative(_: float, state: Array) -> list[float]:
        total, slope, weight = inertia(float(state[0]))
        return [state[1], (5.0 - weight - 0.5 * slope * state[1] ** 2) / total]

    end = 0.2
    solved = solve_ivp(derivative, (0.0, end), [0.0, 0.0], method="DOP853", rtol=1e-12, atol=1e-12, t_eval=[end])
    motion = exact_motion("saw", SAW, Torque(Steady(5.0), ""), REST, np.array([0.0, end]))
    found = quantities_of(SAW, motion.poses, motion.rates, motion.accelerations)
    assert found["crank_angle"][-1] == pytest.approx(solved.y[0, -1], rel=1e-10)
    assert found["crank_speed"][-1] == pytest.approx(solved.y[1, -1], rel=1e-10)


@cache
def controlled() -> tuple[Columns, Sampled]:
    """A run under a torque that is held from row to row."""
    sizes = 5.0 * np.sin(40.0 * TIMES)
    law = Sampled(tuple(TIMES.tolist()), tuple(sizes.tolist()), "previous")
    return run_of(law, start=CrankStart()) | {"motor": sizes}, law


def test_torque_of_a_column_is_held_unless_said_otherwise() -> None:
    table, _ = controlled()
    assert judged(table, "motor", None).passed
    assert (judged(table, "motor:previous", None).largest("phase") or 0.0) < 1e-11
    # Negative control.
    assert (judged(table, "motor:next", None, tolerance={"phase": 10.0}).largest("phase") or 0.0) > 1e-3


@pytest.mark.slow
def test_a_torque_held_otherwise_is_named() -> None:
    study = judged(controlled()[0], "motor:next", None, tolerance={"phase": 1e-7})
    assert study.passed is False
    assert any("held from each row to the next" in cause.text for cause in study.causes)


def test_torque_of_a_file_is_linear_between_its_rows(tmp_path: Path) -> None:
    file = tmp_path / "drive.csv"
    times = np.linspace(0.0, 0.12, 7)
    sizes = 5000.0 * np.cos(20.0 * times)
    rows = [f"{t!r},{size!r}" for t, size in zip(times.tolist(), sizes.tolist(), strict=True)]
    file.write_text("\n".join(["t [s],torque [N mm]", *rows]), encoding="utf-8")
    law = Sampled(tuple(times.tolist()), tuple((1e-3 * sizes).tolist()))
    assert (judged(run_of(law), file).largest("phase") or 0.0) < 1e-11
    # Negative control; nothing is out of this tolerance, so that no cause is looked for.
    assert (judged(run_of(law), f"{file}:previous", tolerance={"phase": 10.0}).largest("phase") or 0.0) > 1e-3


def csv_of(table: Columns, file: Path) -> Path:
    rows = zip(*(map(repr, own.tolist()) for own in table.values()), strict=True)
    units = {"time": "s", "crank_angle": "rad", "crank_speed": "rad/s", "C.x": "m", "C.vx": "m/s", "motor": "N m"}
    file.write_text(
        "\n".join([",".join(f"{name} [{units[name]}]" for name in table), *map(",".join, rows)]), encoding="utf-8"
    )
    return file


def test_command_prints_the_verdict(tmp_path: Path) -> None:
    file = csv_of(controlled()[0], tmp_path / "run.csv")
    done = typed("check", str(file), "--scene", "saw-500rpm", "--torque", "motor")
    assert done.returncode == 0
    assert "within tolerance: position" in done.stdout
    assert "the torque of column 'motor', held from each row to the next" in " ".join(done.stdout.split())


@pytest.mark.slow
def test_command_names_another_start_and_writes_a_page(tmp_path: Path, undrawn: None) -> None:
    file = csv_of(controlled()[0], tmp_path / "run.csv")
    out = tmp_path / "report"
    command = ("check", str(file), "--scene", "saw-500rpm", "--torque", "motor")
    done = typed(*command, "--start", "510rpm", "--out", str(out))
    assert done.returncode == 1
    assert "OUT OF TOLERANCE" in done.stdout
    assert re.search(r"the run starts at (500|499)[.\d]* rpm, not at 510 rpm: --start", " ".join(done.stdout.split()))
    assert "under a torque" in (out / "README.md").read_text(encoding="utf-8")


REFUSED = {
    "engine": ("moter", None, "unknown column in --torque 'moter': did you mean 'motor'?"),
    "unit": ("5 kg", None, "'kg' is not a unit of N m"),
    "nan": (math.nan, None, "is not a finite number"),
    "start": (5.0, (1.0, 7.0), "--start = 7 rad is out of range"),
    "file": ("nothing.csv", None, "nothing.csv"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_torque_or_start_that_cannot_be_used_is_refused(case: str) -> None:
    torque, start, words = REFUSED[case]
    with pytest.raises(InvalidInput) as refusal:
        judged(controlled()[0], torque, start)
    assert words in str(refusal.value)


def test_a_run_that_cannot_be_one_is_refused() -> None:
    table = run_of()
    for change, words in (
        ({"time": TIMES - 0.01}, "the first time is -0.01 s: the motion begins at time 0"),
        ({"time": TIMES[::-1]}, "times are not in order"),
        ({"C.x": table["C.x"] + 0.3}, "the run starts off the mechanism: at t = 0 s C is"),
    ):
        with pytest.raises(InvalidInput) as refusal:
            judged(table | change)
        assert words in str(refusal.value)
    with pytest.raises(InvalidInput, match="no acceleration column; conrod does not differentiate"):
        judged(table, tolerance={"acceleration": 1.0})
    with pytest.raises(InvalidInput, match="it stays at rest: neither the torque nor"):
        conrod.check(table, replace(SAW, gravity=0.0), torque=0.0, start=0.0)
    with pytest.raises(InvalidInput, match="is a machine in space"):
        conrod.check(table, "bennett", torque=5.0)


def test_options_that_do_not_go_with_a_torque_are_refused(tmp_path: Path) -> None:
    file = str(csv_of(run_of(), tmp_path / "run.csv"))
    for words, line in (
        (("--torque", "5", "--estimate", "time"), "--estimate does not go with --torque"),
        (("--start", "0rpm"), "--start does not go with a table without --torque"),
    ):
        done = typed("check", file, "--scene", "saw-500rpm", *words)
        assert done.returncode == 2
        assert line in done.stderr
