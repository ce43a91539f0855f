"""The report of limits as files: whole, the same every time, and rendered from its own results.json."""

from __future__ import annotations

import json
import math
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from limit_studies import follower, limit_study, of_axis
from limit_walks import SCENE, quietened

from conrod.report.limits import writer
from conrod.report.limits.document import rounded
from conrod.report.limits.writer import limits_report_again, limits_report_batch
from conrod.report.reproduction import Reproduction
from conrod.studies.frame.files import Batch, write_together
from conrod.studies.limits.grade import Level
from conrod.studies.limits.results import LimitStudy

COMMAND = Reproduction("conrod limits {scene} --out reports/limits")


@pytest.fixture(scope="module")
def study() -> LimitStudy:
    return limit_study()


@pytest.fixture(scope="module")
def batch(study: LimitStudy, tmp_path_factory: pytest.TempPathFactory) -> Batch:
    """The whole report, rendered once."""
    return limits_report_batch([study], tmp_path_factory.mktemp("limits"), COMMAND)


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """Figures by name alone: drawing them is what takes long."""
    monkeypatch.setattr(writer, "limits_figures", lambda study: {w.axis: "<svg/>" for w in study.walks if w.probes})


# -- the files ---------------------------------------------------------------------------------------------------------


def test_the_report_is_whole(study: LimitStudy, batch: Batch) -> None:
    for name in ("README.md", f"{SCENE}.md"):
        links = re.findall(r"\]\(([^)]+)\)", str(batch.files[name]))
        assert links
        assert not [link for link in links if link not in batch.files]
    drawings = {name: str(text) for name, text in batch.files.items() if name.endswith(".svg")}
    assert {name for name in drawings if name not in str(batch.files[f"{SCENE}.md"])} == set()
    for text in drawings.values():
        ElementTree.fromstring(text)
    for axis in {walk.axis for walk in study.walks if walk.probes}:
        assert f"figures/{SCENE}-{axis}.svg" in drawings


def test_rows_keep_to_their_columns(batch: Batch) -> None:
    for name in ("README.md", f"{SCENE}.md"):
        for block in str(batch.files[name]).split("\n\n"):
            if block.startswith("| "):
                widths = {len(re.findall(r"(?<!\\)\|", line)) for line in block.splitlines()}
                assert len(widths) == 1, block[:200]


@pytest.mark.usefixtures("undrawn")
def test_the_report_names_the_quiet_runs_before_anything_else(study: LimitStudy, tmp_path: Path) -> None:
    files = limits_report_batch([study], tmp_path, COMMAND).files
    for name in ("README.md", f"{SCENE}.md"):
        text = str(files[name])
        assert text.index("## Wrong, and nothing says so") == text.index("## "), name
        assert "199 .. 31 steps" in text
        assert "Quiet are also 2 of 5 runs of the maps." in text
    # Negative control: quiet on a map alone is still quiet, and nothing is said where nothing is.
    calm = replace(study, walks=tuple(quietened(study.walks)))
    assert "No run was wrong" not in str(limits_report_batch([calm], (), tmp_path, COMMAND).files["README.md"])
    calm = replace(calm, maps=())
    text = str(limits_report_batch([calm], (), tmp_path, COMMAND).files[f"{SCENE}.md"])
    assert "No run was wrong without a sign of it" in text
    assert "**wrong but quiet**" not in text


def test_words_are_explained_once(batch: Batch) -> None:
    for name in ("README.md", f"{SCENE}.md"):
        for level in Level:
            assert str(batch.files[name]).count(f"- *{level.slug}*: {level.meaning}") == 1


def test_powers_of_ten_are_written_as_in_the_figures(batch: Batch) -> None:
    page = str(batch.files[f"{SCENE}.md"])
    assert "1 .. 1e6" in page
    assert "1 .. 1e-6" in page
    assert re.search(r"\de[+-]0\d", page) is None


@pytest.mark.usefixtures("undrawn")
def test_parts_that_were_not_asked_for_are_left_out(study: LimitStudy, tmp_path: Path) -> None:
    whole = str(limits_report_batch([study], tmp_path, COMMAND).files[f"{SCENE}.md"])
    alone = str(limits_report_batch([of_axis(study, "steps")], (), tmp_path, COMMAND).files[f"{SCENE}.md"])
    for section in ("## Long runs", "## The same again?", "## Two axes at once", "## What was not walked, and why"):
        assert section in whole
        assert section not in alone
    assert "### Steps per revolution" in alone


def small(study: LimitStudy) -> LimitStudy:
    """Few figures, and a part of every kind that has none."""
    return replace(of_axis(study, "mass-ratio"), determinism=study.determinism, needs=study.needs)


def test_the_same_study_gives_the_same_bytes(study: LimitStudy, tmp_path: Path) -> None:
    batch, again = (limits_report_batch([small(limit_study())], tmp_path, COMMAND) for _ in range(2))
    assert again.files == batch.files
    # Negative control: another measurement is seen.
    other = replace(study, walks=tuple(quietened(study.walks)))
    assert limits_report_batch([small(other)], tmp_path, COMMAND).files != batch.files


def test_a_saved_report_renders_without_any_engine(study: LimitStudy, tmp_path: Path) -> None:
    batch = limits_report_batch([small(study)], tmp_path, COMMAND)
    write_together([batch])
    for name in batch.files:
        if name != "results.json":
            (tmp_path / name).unlink()
    # In a process in which no engine can be imported; that it cannot is looked at too.
    code = (
        "import sys; from pathlib import Path\n"
        "class Absent:\n"
        "    def find_spec(self, name, path=None, target=None):\n"
        "        if name.split('.')[0] in ('mujoco', 'pymunk'): raise ImportError(name)\n"
        "sys.meta_path.insert(0, Absent())\n"
        "from conrod.studies.frame.files import write_together\n"
        "from conrod.report.limits.writer import limits_report_again\n"
        f"write_together([limits_report_again(Path({str(tmp_path)!r}))])\n"
        "from conrod.engines import engine_named\n"
        "try: engine_named('pymunk')\n"
        "except ImportError: print('no engine')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=120)
    assert done.stdout.strip() == "no engine"
    assert {name: (tmp_path / name).read_text(encoding="utf-8") for name in batch.files} == batch.files


def test_without_a_saved_report_there_is_none_to_render(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no report of limits"):
        limits_report_again(tmp_path)


def test_values_are_kept_as_they_are_and_measurements_rounded(study: LimitStudy, batch: Batch) -> None:
    kept = LimitStudy.of(json.loads(str(batch.files["results.json"]))["limits"][SCENE]["study"])
    assert [[p.value for p in walk.probes] for walk in kept.walks] == [
        [p.value for p in walk.probes] for walk in study.walks
    ]
    assert [walk.boundaries for walk in kept.walks] == [walk.boundaries for walk in study.walks]
    assert kept.determinism == study.determinism
    assert kept.parameters == dict(study.parameters)
    assert rounded({"value": 0.123456789, "torque": 0.123456789}) == {"value": 0.123456789, "torque": 0.1235}


def test_a_flight_keeps_the_digits_of_its_landing(study: LimitStudy, tmp_path: Path) -> None:
    cam = replace(of_axis(study, "rounding"), name="cam-follower", floats=(follower("mujoco", "tuned"),))
    batch = limits_report_batch([cam], (), tmp_path, COMMAND)
    kept = LimitStudy.of(json.loads(str(batch.files["results.json"]))["limits"]["cam-follower"]["study"]).floats[0]
    assert (kept.held, kept.flown) == (0.998, 0.9995)
    # A landing is told to a thousandth of a degree, which four digits of the angle would not tell.
    assert math.degrees(kept.flights[0].landing_error or 0.0) == pytest.approx(0.05, abs=1e-5)
    page = str(batch.files["cam-follower.md"])
    assert "+0.050 deg" in page
    assert "](figures/cam-follower-follower-float.svg)" in page
    assert "figures/cam-follower-follower-float.svg" in batch.files
