"""A ledger on a disk of the network: no shared memory, one file a machine, refused where locks do nothing."""

from __future__ import annotations

import ast
import os
import platform
import sqlite3
import subprocess
import sys
from contextlib import closing
from pathlib import Path

import platformdirs
import pytest
from cell_tasks import cells

import conrod
from conrod import InvalidInput, system
from conrod.execution.ledger import Ledger, default_ledger_path

CASE = cells(50)[0]
MOUNT = "36 35 {device} / {folder} rw,noatime shared:1 - {kind} server:/home rw,vers=4.2,{options}\n"


def plant_mount(folder: Path, monkeypatch: pytest.MonkeyPatch, kind: str, options: str = "hard") -> None:
    """Say in a list of mounts that a folder's disk is of a kind."""
    device = folder.stat().st_dev
    number = f"{os.major(device)}:{os.minor(device)}"
    mounts = folder / "mountinfo"
    others = MOUNT.format(device="0:999999", folder="/x", kind="nfs4", options="nolock")
    mounts.write_text(others + MOUNT.format(device=number, folder=folder, kind=kind, options=options))
    monkeypatch.setattr(system, "MOUNTS", str(mounts))


def journal_of(path: Path) -> str:
    with closing(sqlite3.connect(path)) as connection:
        return str(connection.execute("PRAGMA journal_mode").fetchone()[0])


@pytest.mark.parametrize(
    ("kind", "options", "found"),
    [
        ("ext4", "", ("", True)),
        ("nfs4", "local_lock=none", ("nfs4", True)),
        ("nfs", "nolock,addr=10.0.0.1", ("nfs", False)),
        ("nfs4", "local_lock=all", ("nfs4", False)),
        ("fuse.sshfs", "", ("fuse.sshfs", True)),
    ],
)
def test_network_disk_is_known_by_the_list_of_mounts(
    kind: str, options: str, found: tuple[str, bool], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    plant_mount(tmp_path, monkeypatch, kind, options)
    assert system.network_file_system(tmp_path) == found


def test_disk_is_local_where_no_mounts_are_listed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(system, "MOUNTS", str(tmp_path / "none"))
    assert system.network_file_system(tmp_path) == ("", True)


def test_ledger_on_a_network_disk_has_no_shared_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    here, there = tmp_path / "here.sqlite", tmp_path / "there.sqlite"
    measured = CASE.perform()
    for path in (here, there):
        with Ledger.open(path) as ledger:
            ledger.keep(CASE, measured)
    assert journal_of(here) == "wal"
    plant_mount(tmp_path, monkeypatch, "nfs4")
    for path in (there, tmp_path / "new.sqlite"):  # one that was made elsewhere, and one that is made there
        with Ledger.open(path) as ledger, Ledger.open(path) as other:
            ledger.keep(CASE, measured)
            assert repr(other.results({CASE.key: CASE})[CASE.key]) == repr(measured)
        assert journal_of(path) == "delete"


def test_ledger_is_refused_where_locks_do_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant_mount(tmp_path, monkeypatch, "cifs")
    assert not system.grants_a_lock_twice(tmp_path)
    Ledger.open(tmp_path / "before.sqlite").close()
    monkeypatch.setattr(system.fcntl, "fcntl", lambda *_: 0)
    assert system.grants_a_lock_twice(tmp_path)
    with pytest.raises(InvalidInput, match=r"l\.sqlite is on cifs, whose locks do nothing: name a file on"):
        Ledger.open(tmp_path / "l.sqlite")
    assert not (tmp_path / "l.sqlite").exists()
    assert not list(tmp_path.glob(".conrod-lock-*"))


def test_ledger_of_many_machines_is_refused_with_local_locks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plant_mount(tmp_path, monkeypatch, "nfs", "nolock")
    with pytest.raises(InvalidInput, match=f"do not reach other machines: .*: l-{platform.node()}.sqlite"):
        Ledger.open(tmp_path / "l.sqlite")
    Ledger.open(tmp_path / f"l-{platform.node()}.sqlite").close()


def test_cache_on_a_network_disk_has_one_ledger_a_machine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("CONROD_LEDGER", raising=False)
    monkeypatch.setattr(platformdirs, "user_cache_path", lambda _: tmp_path / "cache" / "conrod")
    for kind, name in (("ext4", "ledger.sqlite"), ("nfs4", f"ledger-{platform.node()}.sqlite")):
        plant_mount(tmp_path, monkeypatch, kind)
        assert default_ledger_path() == tmp_path / "cache" / "conrod" / name


WRITER = """
import sys
from pathlib import Path
from cell_tasks import cells
from conrod.execution import ledger_file
from conrod.execution.ledger import Ledger
ledger_file.network_file_system = lambda folder: ("nfs4", True)
result = cells(50)[0].perform()
with Ledger.open(Path(sys.argv[1])) as ledger:
    for case in cells(50)[int(sys.argv[2])::2]:
        ledger.keep(case, result)
"""


def test_two_writers_on_a_network_disk_lose_no_result(tmp_path: Path) -> None:
    path, root = tmp_path / "l.sqlite", Path(__file__).parents[2]
    environment = {**os.environ, "PYTHONPATH": f"{root / 'tests/support'}{os.pathsep}{root}"}
    writers = [subprocess.Popen([sys.executable, "-c", WRITER, str(path), str(k)], env=environment) for k in range(2)]
    assert [writer.wait(timeout=120) for writer in writers] == [0, 0]
    assert journal_of(path) == "delete"
    with Ledger.open_for_reading(path) as ledger:
        assert ledger.finished_keys(case.key for case in cells(50)) == {case.key for case in cells(50)}


def test_no_module_decides_by_the_time_of_day() -> None:
    # It may be set back during a run. What reads it only prints the date of a page.
    readers = set()
    for file in Path(conrod.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and ast.unparse(node.func) in ("time.time", "datetime.now", "time.localtime"):
                readers.add(file.name)
    assert readers == {"verb.py"}
