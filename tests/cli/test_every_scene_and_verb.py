"""Every shipped name goes through every verb that takes a scene: an answer, `unsupported`, or one line and status 2.

`pytest -m slow -rA` prints each command with its exit status and time.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import pytest
from command_line import conrod, error_lines

from conrod.scenes import SCENES, catalogue_names, dynamics_names, scene_named

CHAIN = "four-bar-chain-2"
NAMES = (*SCENES, *catalogue_names(), *dynamics_names(), CHAIN)
# No closure; closed forms; a cam by arcs, one by a law; change points; a span; wheels; a rack; a spring; a chain.
KINDS = (
    "pendulum", "saw-40rpm", "cam-follower", "cam-3-4-5", "parallelogram", "double-rocker", "planetary-gear",
    "rack-and-wheel", "slider-crank-spring", CHAIN,
)  # fmt: skip
COARSE = "--steps-per-rev 40 --revolutions 1"
FAST = ("show {}", "export {} --format mjcf -o m.xml")
VERBS = (
    *FAST,
    "lint m.xml --seconds 0.01",
    "show {} --angle 0",
    "export {} --format csv --steps-per-rev 40 -o t.csv",
    "check t.csv --scene {}",
    "check m.xml --scene {} --crank crank POINTS",
    f"validate {{}} {COARSE}",
    f"forces {{}} --quantity torque,reactions,contact {COARSE}",
    "free {} --seconds 0.02",
    "free {} --torque --seconds 0.02",
)
# Of each kind one: every machine of a kind has the same runs, and these take most of the time.
STUDIES = (
    "sweep {} --engine pymunk --grid coarse",
    "recommend {} --engine pymunk --position 1e-2",
    "limits {} --axis steps --engine pymunk --preset stock",
    "ablate {} --engine mujoco --steps-per-rev 40 --rounds 2",
)


def exit_status_of(line: str, name: str, folder: Path) -> int:
    """Exit status of a command, which gives an answer or one line of a refusal."""
    points = scene_named(name).lengths if "POINTS" in line else ()
    command = line.format(name).replace("POINTS", " ".join(f"--point {one}=site:{one}" for one in points))
    start = time.perf_counter()
    done = conrod(*command.split(), cwd=folder, ledger=folder / "ledger.sqlite")
    print(f"{done.returncode} {time.perf_counter() - start:6.1f} s  conrod {command}", flush=True)
    assert done.returncode in (0, 1, 2), done
    if done.returncode == 2:
        lines = error_lines(done)
        assert (len(lines), done.stdout) == (1, ""), done
        assert lines[0].startswith("conrod: ")
        assert len(lines[0]) < 700
    return done.returncode


@pytest.mark.parametrize("name", KINDS)
def test_every_kind_of_machine_is_shown_and_exported(name: str, tmp_path: Path) -> None:
    assert [exit_status_of(line, name, tmp_path) for line in FAST] == [0, 0]


@pytest.mark.slow
@pytest.mark.parametrize("name", dict.fromkeys(NAMES))
def test_every_scene_goes_through_every_verb(name: str, tmp_path: Path) -> None:
    ends = [exit_status_of(line, name, tmp_path) for line in (*VERBS, *(STUDIES if name in KINDS else ()))]
    # Negative control: the commands are not all refused.
    assert ends.count(2) < len(ends) // 2


def test_refusal_without_its_line_is_detected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    # Negative control of the check.
    monkeypatch.setattr("conrod.cli._exit_with_error", lambda message: sys.exit(2))
    with pytest.raises(AssertionError):
        exit_status_of("show {}", "none", tmp_path)
