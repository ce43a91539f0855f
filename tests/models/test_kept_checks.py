"""A model whose bytes, options and software are those of before is not judged again; one that changed in a byte is."""

from __future__ import annotations

import math
import os
import sqlite3
import zlib
from collections.abc import Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path

import pytest
from command_line import conrod

from conrod import InvalidInput, Runs, Saw
from conrod.mjcf.loop_results import LoopRequest
from conrod.user_files import kept_checks
from conrod.user_files.files import model_digest

MODEL = """<mujoco>
  <compiler meshdir="meshes"/>
  <include file="part.xml"/>
  <asset><mesh name="tip" file="tip.obj"/></asset>
</mujoco>"""


@dataclass(frozen=True)
class Judged:
    """What the task of these tests finds."""

    text: str
    errors: Mapping[str, float]


class Judge:
    """A task that counts how often it is called; each time it finds something else."""

    def __init__(self) -> None:
        self.calls = 0

    def __call__(self, function: object, path: Path, *arguments: object) -> Judged:
        self.calls += 1
        return Judged(f"{path.name} {self.calls}", {"position": 0.1 + 0.2, "velocity": math.nan})


@pytest.fixture
def judge(monkeypatch: pytest.MonkeyPatch) -> Judge:
    counted = Judge()
    monkeypatch.setattr(kept_checks, "call_on_file", counted)
    return counted


@pytest.fixture
def model(tmp_path: Path) -> Path:
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "tip.obj").write_text("v 0 0 0\n")
    (tmp_path / "part.xml").write_text("<mujocoinclude/>")
    path = tmp_path / "model.xml"
    path.write_text(MODEL)
    return path


QUESTION = LoopRequest({"crank": "60rpm"})


def check(
    path: Path, question: LoopRequest = QUESTION, *, fresh: bool = False, beside: str = "", scene: Saw | None = None
) -> str:
    runs = Runs(ledger=path.parent / "ledger.sqlite", fresh=fresh)
    given = question, ("saw", scene or Saw())
    return kept_checks.check_or_recall("json.dumps", Judged, path, *given, runs=runs, beside=beside).text


def test_a_check_is_recalled_until_a_byte_of_its_files_changes(model: Path, judge: Judge) -> None:
    assert [check(model) for _ in range(3)] == ["model.xml 1"] * 3
    for k, file in enumerate(("model.xml", "part.xml", "meshes/tip.obj"), 2):
        there = model.parent / file
        before = there.read_bytes()
        there.write_bytes(before[:-1] + bytes([before[-1] ^ 1]) if file != "model.xml" else before + b" ")
        assert check(model) == f"model.xml {k}"
        assert check(model) == f"model.xml {k}"
    # Negative control: only the time of change is another.
    os.utime(model, (1.0, 1.0))
    assert check(model) == "model.xml 4"
    # A file that MuJoCo may find instead.
    (model.parent / "tip.obj").write_text("v 0 0 0\n")
    assert check(model) == "model.xml 5"


def test_a_check_is_made_again_by_other_options_or_software(
    model: Path, judge: Judge, monkeypatch: pytest.MonkeyPatch
) -> None:
    other = LoopRequest({"crank": "61rpm"})
    assert [check(model), check(model, other), check(model), check(model, scene=Saw(speed=2.0))] == [
        f"model.xml {k}" for k in (1, 2, 1, 3)
    ]
    assert [check(model, fresh=True), check(model)] == ["model.xml 4"] * 2
    beside = model.parent / "beside.xml"
    beside.write_text("<mujoco/>")
    assert [check(model, beside=str(beside)), check(model, beside=str(beside))] == ["model.xml 5"] * 2
    beside.write_text("<mujoco />")
    assert check(model, beside=str(beside)) == "model.xml 6"
    for name, value in (
        ("_source_stamps", list),
        ("environment", dict),
        ("machine_fingerprint", str),
        ("CACHE_VERSION", 0),
    ):
        with monkeypatch.context() as patch:
            patch.setattr(kept_checks, name, value)
            calls = judge.calls
            assert check(model) == f"model.xml {calls + 1}"
    assert check(model) == "model.xml 4"


def test_a_damaged_check_is_made_again(model: Path, judge: Judge) -> None:
    check(model)
    path = model.parent / "ledger.sqlite"
    swapped = zlib.compress(b'{"key": "another", "found": {"text": "false", "errors": {}}}')
    other_kind = b'{"key": "%s", "found": {"text": 1}}'
    with closing(sqlite3.connect(path)) as ledger:
        ((key, whole),) = ledger.execute("SELECT key, findings FROM checks").fetchall()
    spoilt = [whole[:-1], whole[:40] + bytes([whole[40] ^ 1]) + whole[41:], b"", swapped]
    spoilt.append(zlib.compress(other_kind.replace(b"%s", key.encode())))
    for k, blob in enumerate(spoilt, 2):
        with closing(sqlite3.connect(path)) as ledger, ledger:
            ledger.execute("UPDATE checks SET findings = ?", (blob,))
        assert [check(model), check(model)] == [f"model.xml {k}"] * 2


@pytest.mark.parametrize(
    "changed",
    [
        MODEL.replace("tip.obj", "missing.obj"),
        MODEL.replace("tip.obj", "t&#105;p.obj"),
        MODEL.replace("<asset>", '<extension><plugin plugin="a.b"/></extension><asset>'),
        MODEL.replace('meshdir="meshes"', 'meshdir="meshes" strippath="true"'),
        MODEL.replace('<mesh name="tip" file', '<texture type="cube" fileup="no.png"/><mesh name="tip" file'),
    ],
    ids=["missing", "escaped", "plugin", "strippath", "cube"],
)
def test_a_model_of_unknown_files_is_judged_each_time(changed: str, model: Path, judge: Judge) -> None:
    assert model_digest(model) is not None
    model.write_text(changed)
    assert model_digest(model) is None
    assert [check(model), check(model)] == ["model.xml 1", "model.xml 2"]


def test_a_ledger_that_cannot_be_used_costs_no_check(
    model: Path, judge: Judge, monkeypatch: pytest.MonkeyPatch
) -> None:
    broken = model.parent / "ledger.sqlite"
    broken.write_text("a diary\n")
    monkeypatch.setenv("CONROD_LEDGER", str(broken))
    assert kept_checks.check_or_recall("json.dumps", Judged, model, runs=Runs()).text == "model.xml 1"
    with pytest.raises(InvalidInput, match="not a database"):
        check(model)
    assert broken.read_text() == "a diary\n"


def test_a_check_of_an_odd_name_is_kept_and_of_no_file_is_made(model: Path, judge: Judge) -> None:
    odd = model.rename(model.with_name("m\udce9.xml"))
    assert [check(odd), check(odd)] == ["m\udce9.xml 1"] * 2
    missing = model.with_name("missing.xml")
    assert [check(missing), check(missing)] == ["missing.xml 2", "missing.xml 3"]


@pytest.mark.slow
def test_conrod_check_recalls_a_model_and_sees_a_changed_include(tmp_path: Path) -> None:
    text = (Path(__file__).parents[2] / "mjcf" / "saw-500rpm.xml").read_text()
    begin, end = text.index("<worldbody>"), text.index("</worldbody>") + len("</worldbody>")
    (tmp_path / "bodies.xml").write_text(f"<mujocoinclude>{text[begin:end]}</mujocoinclude>")
    path = tmp_path / "saw.xml"
    path.write_text(f'{text[:begin]}<include file="bodies.xml"/>{text[end:]}')
    words = ("check", str(path), "--scene=saw-500rpm", "--crank=crank", "--point=C=site:C", "--point=M=site:M")
    first, again = conrod(*words), conrod(*words)
    assert (first.returncode, again.returncode) == (0, 0)
    assert (again.stdout, "1 in the ledger" in again.stderr) == (first.stdout, True)
    included = (tmp_path / "bodies.xml").read_text()
    site = included.index('name="C"')
    place = included.index('pos="', site) + 5
    (tmp_path / "bodies.xml").write_text(f"{included[:place]}0.01{included[place + 1 :]}")
    changed = conrod(*words)
    assert changed.returncode == 1
    assert "in the ledger" not in changed.stderr
