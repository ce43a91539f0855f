"""The studies of docs/reuse.md run as they are printed, and print what the page says."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import conrod as typed
from command_line import kept_worker

PAGE = Path(__file__).parents[2] / "docs" / "reuse.md"
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e-?\d+)?")
SAME = 0.2  # share by which an error that was printed may differ on another machine or release


def studies() -> Iterator[tuple[str, str]]:
    """The code of each study, and what it prints."""
    yield from re.findall(r"```python\n(.*?)```\n+```\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)


def says_the_same(printed: str, told: str) -> bool:
    """True if two texts have the same words, and numbers that are about the same."""
    if NUMBER.sub("#", printed).split() != NUMBER.sub("#", told).split():
        return False
    pairs = zip(NUMBER.findall(printed), NUMBER.findall(told), strict=True)
    return all(float(a) == pytest.approx(float(b), rel=SAME) for a, b in pairs)


def test_another_number_or_verdict_is_seen() -> None:
    assert says_the_same("phase 1.1e-3 deg, passed", "phase 1.0e-3 deg, passed")
    # Negative controls.
    assert not says_the_same("phase 1.1e-3 deg, passed", "phase 2.0e-3 deg, passed")
    assert not says_the_same("phase 1.1e-3 deg, failed", "phase 1.0e-3 deg, passed")


@pytest.mark.slow
@pytest.mark.parametrize("study", range(len([*studies()])))
def test_study_prints_what_the_page_says(
    study: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("conrod.execution.local.WorkerProcess", kept_worker)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    code, told = [*studies()][study]
    if "import saw" in code:
        (command,) = re.findall(r"^conrod (export .*)$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
        assert typed(*command.split()).returncode == 0
    exec(compile(code, f"{PAGE.name}, study {study}", "exec"), {})
    assert says_the_same(capsys.readouterr().out, told)
