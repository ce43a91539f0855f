"""conrod on systems that are not Linux: one module knows what POSIX has, and lines end alike (docs/platforms.md)."""

from __future__ import annotations

import ast
import io
import os
import subprocess
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path, PureWindowsPath
from typing import Any

import pytest
from four_bars import four_bar
from table_files import csv_text, exact_table, read_file

from conrod import SCENES, InvalidInput, Runs, cli, export, system
from conrod.execution.files import file_to_write
from conrod.execution.ledger_file import Claims
from conrod.execution.local import LocalProcesses
from conrod.execution.writing import Batch, write_together
from conrod.mechanism.files import read_tables
from conrod.mjcf.document import Document
from conrod.models.torque_runs.torque import split_way

SOURCE = Path(__file__).parents[1] / "src"
MODULES = sorted(SOURCE.rglob("*.py"))


@cache
def module_trees() -> dict[str, ast.Module]:
    """Syntax trees of all modules, by their paths."""
    return {path.relative_to(SOURCE).as_posix(): ast.parse(path.read_bytes()) for path in MODULES}


# -- what only POSIX has -----------------------------------------------------------------------------------------------

POSIX_MODULES = {"fcntl", "grp", "pty", "pwd", "resource", "termios", "tty"}
POSIX_NAMES = {
    "O_CLOEXEC", "O_DIRECTORY", "O_NOFOLLOW", "SIGKILL", "chown", "fchmod", "fork", "geteuid", "getpgrp", "getuid",
    "killpg", "setsid",
}  # fmt: skip


def posix_names(tree: ast.Module) -> list[str]:
    """What a module uses of Python's library that Windows does not have."""
    found = list[str]()
    for node in ast.walk(tree):
        match node:
            case ast.Import(names=names):
                found += [one.name for one in names if one.name in POSIX_MODULES]
            case ast.ImportFrom(module=str(module)) if module in POSIX_MODULES:
                found.append(module)
            case ast.Attribute(value=ast.Name(id="os" | "signal"), attr=name) if name in POSIX_NAMES:
                found.append(name)
            case _:
                pass
    return found


def test_one_module_uses_what_posix_alone_has() -> None:
    users = {name for name, tree in module_trees().items() if posix_names(tree)}
    assert users == {"conrod/system.py"}
    # Negative control: a lock and a signal, as other modules had them.
    assert posix_names(ast.parse("import fcntl\nos.killpg(1, signal.SIGKILL)")) == ["fcntl", "killpg", "SIGKILL"]


AS_ON_WINDOWS = """
import multiprocessing.connection, os, shutil, signal, subprocess, sys, tempfile

for name in ("fcntl", "resource"):
    sys.modules[name] = None
missing = "O_CLOEXEC O_DIRECTORY O_NOFOLLOW O_NONBLOCK fchmod geteuid getpgrp killpg sched_getaffinity"
for name in missing.split():
    delattr(os, name)
del signal.SIGKILL
os.supports_dir_fd.clear()

from conrod.__main__ import main
from conrod.execution import local


class HereWorker:
    ready = True

    def __init__(self, limits, interpreter=None):
        pass

    def call(self, function, *arguments, **named):
        return function(*arguments, **named)

    def kill(self):
        pass

    end = kill


local.WorkerProcess = HereWorker
for words in sys.argv[1:]:
    sys.argv = ["conrod", *words.split()]
    try:
        main()
    except SystemExit as ended:
        if ended.code:
            raise
"""


def test_conrod_validates_where_posix_modules_are_missing(tmp_path: Path) -> None:
    validate = (
        "validate saw-40rpm --engine pymunk --preset tuned --steps-per-rev 60 --revolutions 1 "
        "--ledger ledger.sqlite --json found.json"
    )
    done = subprocess.run(
        [sys.executable, "-c", AS_ON_WINDOWS, "--help", validate],
        cwd=tmp_path, capture_output=True, text=True, check=False, timeout=120,
    )  # fmt: skip
    assert (done.returncode, done.stderr.count("Traceback")) == (0, 0), done.stderr
    assert "saw-40rpm: pymunk" in done.stdout
    assert b'"passed": true' in (tmp_path / "found.json").read_bytes()


@pytest.fixture
def without_posix(monkeypatch: pytest.MonkeyPatch) -> None:
    """A system without locks, limits of memory and folders that can be opened."""
    monkeypatch.setattr(system, "fcntl", None)
    monkeypatch.setattr(system, "resource", None)
    monkeypatch.setattr(os, "supports_dir_fd", set())


def test_files_are_written_together_without_folder_handles(without_posix: None, tmp_path: Path) -> None:
    for content in ("one\n", "two\n"):
        write_together([Batch(tmp_path / "report", {"README.md": content, "data/saw.json": content}, ("old.md",))])
        (tmp_path / "report" / "old.md").write_bytes(b"")
    write_together([Batch(tmp_path / "report", {}, ("old.md",))])
    files = {path.relative_to(tmp_path).as_posix() for path in tmp_path.rglob("*") if path.is_file()}
    assert files == {"report/README.md", "report/data/saw.json"}
    assert (tmp_path / "report" / "data" / "saw.json").read_bytes() == b"two\n"


def test_claims_are_granted_where_there_are_no_locks(without_posix: None, tmp_path: Path) -> None:
    with pytest.raises(OSError, match="lock"):
        system.lock_byte(0, 0)
    claims = Claims(tmp_path / "ledger.sqlite")
    assert claims.take("a run")
    claims.give_back("a run")
    claims.close()


def test_memory_limit_is_refused_where_there_is_none(without_posix: None) -> None:
    assert system.address_space_limit() is None
    system.limit_address_space(1)  # does nothing: the next lines need more
    with pytest.raises(InvalidInput, match="--cell-memory: this system cannot limit the memory of a run"):
        Runs(memory=1 << 30).executor()
    # Negative controls: without a limit, and the limit of users' files, which holds where it can.
    with Runs(jobs=1).executor(), LocalProcesses(1, memory=1 << 30):
        pass


def test_memory_is_limited_on_linux_and_not_on_macos(monkeypatch: pytest.MonkeyPatch) -> None:
    set_limits = list[Any]()
    monkeypatch.setattr("resource.getrlimit", lambda _: (-1, -1))
    monkeypatch.setattr("resource.setrlimit", lambda _, limits: set_limits.append(limits))
    for platform in ("darwin", "linux"):
        monkeypatch.setattr(sys, "platform", platform)
        system.limit_address_space(1 << 30)
    assert set_limits == [(1 << 30, -1)]


# -- paths -------------------------------------------------------------------------------------------------------------


def test_paths_of_windows_become_addresses() -> None:
    assert system.file_address(PureWindowsPath(r"C:\my models\saw.xml")) == "file:///C:/my%20models/saw.xml"
    assert system.file_address(PureWindowsPath(r"my models\saw.xml")) == "my%20models/saw.xml"


def test_a_drive_letter_is_no_way_of_a_torque() -> None:
    assert split_way(r"C:\runs\run.csv") == (r"C:\runs\run.csv", None)
    assert split_way(r"C:\runs\run.csv:previous") == (r"C:\runs\run.csv", "previous")


def test_a_name_that_ends_with_a_slash_is_no_file(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "sep", "\\")
    for name in ("report/", "report\\"):
        with pytest.raises(InvalidInput, match="give the name of a file"):
            file_to_write(name, "--json")


# -- line ends and encodings -------------------------------------------------------------------------------------------


def with_crlf(text: str) -> str:
    return text.replace("\n", "\r\n")


def test_files_with_windows_line_ends_are_read_alike(tmp_path: Path) -> None:
    mechanism = (SOURCE / "conrod/scenes/catalogue/crank-shaper.toml").read_text(encoding="utf-8")
    saw = SCENES["saw-40rpm"]
    table = csv_text(exact_table(saw, rows=12))
    for text, name, read in ((mechanism, "m.toml", read_tables), (table, "t.csv", lambda file: read_file(file, saw))):
        file, found = tmp_path / name, list[str]()
        for ends in (text, with_crlf(text)):
            file.write_bytes(ends.encode())
            found.append(repr(read(file)))
        assert found[0] == found[1]


def test_edits_of_a_model_end_their_lines_as_the_file_does(tmp_path: Path) -> None:
    file = tmp_path / "model.xml"
    for text, line_end in ((four_bar(), b"\n"), (with_crlf(four_bar()), b"\r\n")):
        file.write_bytes(text.encode())
        edited = Document(file).text_with(["<option/>", "<option/>"])
        assert edited.count(b"  <option/>" + line_end) == 2
        assert edited.count(b"\r\n") in (0, edited.count(b"\n"))


def test_what_is_printed_into_a_file_has_plain_line_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("signal.signal", lambda *_: None)
    monkeypatch.setattr(os, "environ", dict(os.environ))
    written = io.BytesIO()
    for prepare, ends in ((lambda: None, b"\r\n"), (cli._prepare, b"\n")):  # the first as on Windows
        monkeypatch.setattr(sys, "stdout", stream := io.TextIOWrapper(written, "utf-8", newline="\r\n"))
        prepare()
        print("a row", flush=True)
        stream.detach()
        assert written.getvalue() == b"a row" + ends
        written.seek(0)
        written.truncate()


def test_exports_have_plain_line_ends() -> None:
    for kind in ("mjcf", "pymunk", "csv"):
        text = export("saw-40rpm", kind)
        assert isinstance(text, str)
        assert "\n" in text
        assert "\r" not in text


def vague_calls(tree: ast.Module) -> Iterator[str]:
    """Calls that read or write text in the encoding, or with the line ends, of the system that they run on."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        words = {word.arg for word in node.keywords}
        texts = [one.value for one in node.args if isinstance(one, ast.Constant) and isinstance(one.value, str)]
        vague = {
            "open": isinstance(node.func, ast.Name) and "encoding" not in words and "b" not in "".join(texts[-1:]),
            "read_text": "encoding" not in words and not texts,
            "write_text": not {"encoding", "newline"} <= words,
        }
        if vague.get(name, False):
            yield ast.unparse(node)


def test_text_is_read_and_written_alike_on_every_system() -> None:
    found = {name: calls for name, tree in module_trees().items() if (calls := [*vague_calls(tree)])}
    assert found == {}
    # Negative controls.
    vague = ["open(name)", "path.read_text()", "path.write_text(text, encoding='utf-8')"]
    assert [*vague_calls(ast.parse("\n".join(vague)))] == vague
