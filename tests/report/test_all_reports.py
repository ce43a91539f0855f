"""`make reports`: what is made is recorded, an interrupted one goes on, a busy machine is said to be."""

from __future__ import annotations

import re
import sys
from pathlib import Path

import pytest

from conrod import InvalidInput
from docs.studies import all_reports
from docs.studies.all_reports import REPORTS, Progress, Report, code_digest, main, timing_page

MAKEFILE = (all_reports.ROOT / "Makefile").read_text(encoding="utf-8")
RECORDING = (
    "import os, sys; open('asked.txt', 'a').write(sys.argv[1] + ' ' + os.environ['CONROD_LEDGER'] + chr(10)); "
    "sys.exit(3 if os.path.exists('fail-' + sys.argv[1]) else 0)"
)


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in place of the repository, with three reports of which one times steps."""
    (tmp_path / "reports").mkdir()
    monkeypatch.setattr(all_reports, "ROOT", tmp_path)
    monkeypatch.setattr(all_reports, "STATE", tmp_path / ".reports")
    monkeypatch.setattr(all_reports, "code_digest", lambda: "code")
    monkeypatch.setattr(all_reports, "clock_spread", lambda: 0.004)
    three = (Report("audit"), Report("own", needs="models"), Report("sweep", timed=True))
    monkeypatch.setattr(all_reports, "REPORTS", three)
    return tmp_path


def make(*reports: str) -> None:
    main(reports, (sys.executable, "-c", RECORDING))


def asked(root: Path) -> list[str]:
    return [line.split()[0] for line in (root / "asked.txt").read_text().splitlines()]


def test_reports_are_made_once_with_one_ledger(root: Path, capsys: pytest.CaptureFixture[str]) -> None:
    make()
    assert asked(root) == ["audit", "sweep"]
    assert {line.split()[1] for line in (root / "asked.txt").read_text().splitlines()} == {
        str(root / ".reports/code/ledger.sqlite")
    }
    make()
    assert asked(root) == ["audit", "sweep"]
    make("own")
    assert asked(root) == ["audit", "sweep", "own"]
    said = capsys.readouterr().out.splitlines()
    assert said[:3] == ["0 made, 2 left: audit, sweep", "1 made, 1 left: sweep", "2 made, 0 left: none"]
    main(["--list"])
    assert capsys.readouterr().out.splitlines()[1:] == ["audit: made", "own: made", "sweep: made"]


def test_reports_go_on_after_one_that_failed(root: Path) -> None:
    (root / "fail-sweep").touch()
    with pytest.raises(InvalidInput, match="make sweep ended with status 3; `make reports` goes on from there"):
        make()
    (root / "fail-sweep").unlink()
    make()
    assert asked(root) == ["audit", "sweep", "sweep"]


def test_other_code_makes_all_reports_again(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    make()
    monkeypatch.setattr(all_reports, "code_digest", lambda: "other")
    make()
    assert asked(root) == ["audit", "sweep"] * 2


def test_a_record_that_was_cut_short_counts_as_none(root: Path) -> None:
    make()
    record = root / ".reports/code/made.json"
    record.write_text(record.read_text()[:20])
    assert Progress.read(record.parent).minutes == {}


def test_report_of_an_unknown_name_is_refused(root: Path) -> None:
    with pytest.raises(InvalidInput, match="unknown report 'sweeep': did you mean 'sweep'"):
        make("sweeep")


@pytest.mark.parametrize(("spread", "said"), [(0.004, "of an idle machine"), (0.03, "in sweep are unreliable")])
def test_timing_page_says_whether_the_machine_was_idle(
    spread: float, said: str, root: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    spreads = iter((0.004, spread))
    monkeypatch.setattr(all_reports, "clock_spread", lambda: next(spreads))
    make()
    page = (root / "reports/timing.md").read_text(encoding="utf-8")
    assert said in page
    assert f"| sweep | 0.4 % | {100.0 * spread:.1f} % |" in page


def test_clock_spread_is_a_share_of_the_loop_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(all_reports, "ROUNDS", 8)
    assert 0.0 <= all_reports.clock_spread() < 10.0
    assert "busy" in timing_page(Progress(Path(), {}, {"sweep": (0.0, 0.5)}))


def test_each_report_has_a_rule_of_make_and_a_digest_of_code() -> None:
    rules = set(re.findall(r"^([a-z-]+):.*reports/", MAKEFILE, re.MULTILINE))
    known = {one.name for one in REPORTS} | {"catalogue", "prior", "cams", "stale"}
    assert {one.name for one in REPORTS} <= {*re.findall(r"^([a-z-]+):", MAKEFILE, re.MULTILINE)}
    assert rules - known == set()
    assert code_digest() == code_digest()
