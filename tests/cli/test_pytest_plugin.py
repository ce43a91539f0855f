"""The pytest plugin: words, baselines beside the test, what fails and why, with xdist too."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

# Loaded here: pytester unloads what a run in this process loads, and numpy cannot be loaded twice.
import numpy.fft  # noqa: F401
import pytest

import conrod
import conrod.scenes.space

pytest_plugins = ["pytester"]
ROOT = Path(__file__).parents[2]
TEST = """
def test_saw(conrod_check):
    conrod_check("saw-500rpm", engines="mujoco", preset="hardened", steps_per_rev={steps})
"""


@pytest.fixture(autouse=True)
def _plugin_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTEST_DISABLE_PLUGIN_AUTOLOAD", "1")
    monkeypatch.setenv("PYTHONPATH", str(ROOT / "src"))


def run(pytester: pytest.Pytester, *arguments: str) -> pytest.RunResult:
    """pytest in a process of its own, which an engine may take down."""
    return pytester.runpytest_subprocess("-p", "pytest_conrod", "-p", "no:cacheprovider", *arguments)


def test_plugin_passes_arguments_and_a_baseline_of_each_call(
    pytester: pytest.Pytester, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[tuple[Any, Any, dict[str, Any]]] = []

    def check(subject: Any, scene: Any = None, **words: Any) -> Any:
        asked.append((subject, scene, words))
        return SimpleNamespace(within_tolerance=True, baseline=conrod.BaselineComparison(Path()))

    monkeypatch.setitem(vars(conrod), "check", check)
    pytester.makepyfile(
        """
        def test_one(conrod_check):
            conrod_check("a", revolutions=3)
            conrod_check("b", "saw", points={"C": "site:D"})
            conrod_check("bennett")
        """
    )
    pytester.inline_run("-p", "pytest_conrod", "-q")
    folder = Path("conrod-baselines", "test_plugin_passes_arguments_and_a_baseline_of_each_call")
    assert asked == [
        ("a", None, {"revolutions": 3, "accept": False, "baseline": folder / "test_one.json"}),
        ("b", "saw", {"points": {"C": "site:D"}, "accept": False, "baseline": folder / "test_one+2.json"}),
        ("bennett", None, {"accept": False, "baseline": folder / "test_one+3.json"}),
    ]


SLIPS = {
    "'saw-500rpm', engin='mujoco'": "conrod: unknown keyword 'engin': did you mean 'engines'?",
    "'saw-500rpm', crank='crank'": "conrod: crank does not go with a scene",
    "3, 'saw-500rpm'": "conrod: a int cannot be judged: give a scene",
}


def test_mistaken_call_fails_in_one_line_and_writes_nothing(pytester: pytest.Pytester) -> None:
    tests = [f"def test_{k}(conrod_check):\n    conrod_check({slip})\n" for k, slip in enumerate(SLIPS)]
    pytester.makepyfile("\n".join(tests))
    done = pytester.runpytest_inprocess("-p", "pytest_conrod", "-q")
    done.assert_outcomes(failed=len(tests))
    told = [line for line in done.outlines if line.startswith("conrod: ")]
    assert all(line.startswith(message) for line, message in zip(told, SLIPS.values(), strict=True))
    assert not (pytester.path / "conrod-baselines").exists()


def test_the_plugin_loads_nothing_of_conrod_until_it_is_used(pytester: pytest.Pytester) -> None:
    pytester.makepyfile(
        "import sys\ndef test_none():\n    assert not [m for m in sys.modules if m.startswith('conrod')]\n"
    )
    run(pytester, "-q").assert_outcomes(passed=1)


def check_failure(pytester: pytest.Pytester, *lines: str) -> None:
    done = run(pytester)
    done.assert_outcomes(failed=1)
    done.stdout.fnmatch_lines(lines)


@pytest.mark.slow
def test_first_run_writes_baseline_and_drift_must_be_accepted(pytester: pytest.Pytester) -> None:
    test = pytester.makepyfile(test_a=TEST.format(steps=500))
    check_failure(pytester, "conrod: no baseline yet: conrod-baselines/test_a/test_saw.json is written, *")
    run(pytester).assert_outcomes(passed=1)
    file = pytester.path / "conrod-baselines" / "test_a" / "test_saw.json"
    kept = json.loads(file.read_text(encoding="utf-8"))
    # A digit that is another, a hundred bands off.
    position = kept["results"]["mujoco hardened"]["numbers"]["position"]
    position["value"] -= 100.0 * position["band"]
    file.write_text(json.dumps(kept), encoding="utf-8")
    drift = "  mujoco hardened: position 7.*, was 7.*: worse, drifted by 2.0 digits"
    check_failure(pytester, drift, "accept: pytest --conrod-regen-all test_a.py::test_saw")
    # Other settings are no drift; they are named, and accepted alike.
    test.write_text(TEST.format(steps=250), encoding="utf-8")
    check_failure(
        pytester, "conrod: the baseline is of something else: steps-per-rev 500, here 250 (*", "accept*regen-all*"
    )
    run(pytester, "--conrod-regen-all").assert_outcomes(passed=1)
    run(pytester).assert_outcomes(passed=1)
