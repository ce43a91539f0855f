"""A kill at any moment leaves each file as it was or as it is to be; a report says that it is not whole."""

from __future__ import annotations

import hashlib
import json
import os
import pickle
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
from command_line import conrod

from conrod.execution.writing import ABANDONED_AGE, Batch, single_file, write_together
from conrod.report.folder import UNFINISHED, ReportFolder
from conrod.report.kind import Reproduction
from conrod.report.writer import render_again, report_batch
from conrod.studies.free_motion.report import FREE_MOTION_REPORT
from tests.report.test_frame import COMMAND, contents, study, write

# What Python reports of calls on the file system, and those of them that can change a file that is no temporary one.
CALLS = ("open", "os.mkdir", "os.rmdir", "os.rename", "os.remove")
CHANGES = ("os.rename", "os.remove")
# Writes batches again and again, killed before its first step, its second, and so on. Keeps what is there then.
WRITER = """
import os, pickle, shutil, signal, sys
from pathlib import Path
from conrod.execution.writing import write_together
root, before, states = map(Path, sys.argv[1:4])
batches, steps = pickle.loads(Path(sys.argv[4]).read_bytes())
def killed(step):
    process = os.fork()
    if process:
        status = os.waitstatus_to_exitcode(os.waitpid(process, 0)[1])
        assert status in (0, -signal.SIGKILL), status
        return status != 0
    def count(event, _):
        nonlocal step
        if event in steps:  # and not in the kill itself, which is reported, too
            step -= 1
            if step < 0:
                os.kill(os.getpid(), signal.SIGKILL)
    sys.addaudithook(count)
    write_together(batches)
    os._exit(0)
step, more = 0, True
states.mkdir()
shutil.rmtree(root)
while more:
    shutil.copytree(before, root)
    more = killed(step)
    root.rename(states / f"{step:04}")
    step += 1
"""


def states_of_killed_writers(
    batches: list[Batch], root: Path, aside: Path, steps: tuple[str, ...] = CALLS
) -> Iterator[Path]:
    """The folder `root` as a writer of batches left it that was killed at its first step, its second, and so on."""
    aside.mkdir()
    shutil.copytree(root, aside / "before")
    (aside / "batches").write_bytes(pickle.dumps((batches, steps)))
    places = [root, aside / "before", aside / "states", aside / "batches"]
    subprocess.run([sys.executable, "-c", WRITER, *places], check=True)
    for state in sorted((aside / "states").iterdir()):
        shutil.rmtree(root, ignore_errors=True)
        state.rename(root)
        yield root


def named(folder: Path) -> dict[str, bytes]:
    """Files but those that are temporary."""
    return {name: text for name, text in contents(folder).items() if not Path(name).name.startswith(".conrod-")}


def test_a_kill_at_any_step_leaves_each_file_old_or_new(tmp_path: Path) -> None:
    root = tmp_path / "root"
    for name in ("report/README.md", "report/data/a.json", "report/obsolete", "report/same", "report/mine", "beside/x"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(f"old {Path(name).name}")
    old = contents(root)
    files = {name: f"new {name}" for name in ("README.md", "data/a.json", "figures/b.svg", "results.json")}
    batch = Batch(root / "report", files | {"same": "old same"}, ("obsolete",), {"results.json": "meanwhile"})
    new = {**old, **{f"report/{name}": text.encode() for name, text in files.items()}, "beside/all.json": b"new"}
    del new["report/obsolete"]
    found = [
        named(root)
        for _ in states_of_killed_writers(
            [batch, single_file(root / "beside/all.json", "new")], root, tmp_path / "aside"
        )
    ]
    assert found[0] == old
    assert found[-1] == new
    meanwhile = {b"meanwhile", new["report/results.json"]}
    for state in found:
        for name, text in state.items():
            assert text in (old.get(name), new.get(name)) or (name, text) == ("report/results.json", b"meanwhile")
        assert old.keys() & new.keys() <= state.keys()
        # Whatever is new of the folder, it says of itself that it is being written, until all of it is.
        others = {name for name in old | new if name.startswith("report/") and name != "report/results.json"}
        if any(state.get(name) != old.get(name) for name in others):
            assert state["report/results.json"] in meanwhile
        if state.get("report/results.json") == new["report/results.json"]:
            assert all(state.get(name) == new.get(name) for name in others)
    # Negative control: it was killed in the middle, too.
    assert sum(state not in (old, new) for state in found) > 4


@pytest.mark.usefixtures("undrawn")
def test_report_is_made_whole_after_its_writer_is_killed(tmp_path: Path) -> None:
    folder, again = tmp_path / "report", Reproduction("conrod free {scene} --jobs 3 --out reports")
    old = [study("saw-40rpm"), study("whitworth")]
    new = [study("saw-40rpm", 1e-4, curves=False), study("shear-press")]
    write(folder, *old)
    batch = report_batch(FREE_MOTION_REPORT, {one.name: one for one in new}, folder, again)
    assert UNFINISHED not in ReportFolder(folder, FREE_MOTION_REPORT).document
    wanted, unfinished = {}, 0
    for k, _ in enumerate(states_of_killed_writers([batch], folder, tmp_path / "aside", CHANGES)):
        report = ReportFolder(folder, FREE_MOTION_REPORT)
        unfinished += report.unfinished
        there = {one.name for one in new if report.entries.get(one.name, {}).get("command", "").count("--jobs")}
        batches = render_again(folder)
        write_together(batches)
        if (key := frozenset(there)) not in wanted:
            mixed = tmp_path / f"mixed{k}"
            write(mixed, *old)
            if replaced := {one.name: one for one in new if one.name in there}:
                write_together([report_batch(FREE_MOTION_REPORT, replaced, mixed, again)])
            wanted[key] = contents(mixed)
        assert named(folder) == wanted[key]
        assert not ReportFolder(folder, FREE_MOTION_REPORT).unfinished
    assert unfinished > 4
    assert len(wanted) > 2


@pytest.mark.usefixtures("undrawn")
def test_a_report_that_is_not_whole_says_so(tmp_path: Path) -> None:
    write(tmp_path / "report", study("saw-40rpm"))
    whole = contents(tmp_path / "report")
    batch = report_batch(FREE_MOTION_REPORT, {"saw-40rpm": study("saw-40rpm", 1e-4)}, tmp_path / "report", COMMAND)
    (tmp_path / "report" / FREE_MOTION_REPORT.results).write_text(str(batch.meanwhile[FREE_MOTION_REPORT.results]))
    (tmp_path / "report/saw-40rpm-motion.md").write_text("new")
    done = conrod("report", str(tmp_path / "report"))
    assert done.returncode == 0
    assert f"{FREE_MOTION_REPORT.results}: writing this report was stopped; it is made whole" in done.stderr
    assert contents(tmp_path / "report").keys() == whole.keys()
    assert (tmp_path / "report/saw-40rpm-motion.md").read_text() != "new"
    assert conrod("report", str(tmp_path / "report")).stderr == ""


# -- what others leave ------------------------------------------------------------------------------------------------


def test_file_in_the_output_folder_is_never_executed(tmp_path: Path) -> None:
    # A hidden folder with a plan is what earlier versions left, and what anybody can put there.
    folder, private = tmp_path / "shared", tmp_path / "private"
    left = folder / ".conrod-x"
    for made in (left, private):
        made.mkdir(parents=True)
    (left / "0").write_text("print('executed')")
    names = ("../private/sitecustomize.py", "sitecustomize.py", str(private / "sitecustomize.py"))
    (left / "planned.json").write_text(json.dumps(dict.fromkeys(names)))
    for arguments in (
        ["show", "saw-500rpm", "--svg", str(folder / "x.svg")],
        ["export", "saw-500rpm", "--format", "csv", "-o", str(folder / "x.csv")],
    ):
        assert conrod(*arguments).returncode == 0
    assert list(private.iterdir()) == []
    assert {file.name for file in folder.iterdir()} == {".conrod-x", "x.svg", "x.csv"}
    assert {file.name for file in left.iterdir()} == {"0", "planned.json"}


def test_only_old_temporary_files_are_removed(tmp_path: Path) -> None:
    names = [".conrod-" + letter * 16 for letter in "abc"] + [".conrod-notes", ".conrod-" + "d" * 16 + ".md"]
    for name in names:
        (tmp_path / name).write_text("left")
        os.utime(tmp_path / name, (time.time() - 2 * ABANDONED_AGE,) * 2)
    os.utime(tmp_path / names[1])
    (tmp_path / names[2]).unlink()
    (tmp_path / names[2]).mkdir()
    write_together([single_file(tmp_path / "a", "text")])
    assert {file.name for file in tmp_path.iterdir()} == {"a", *names[1:]}


def test_a_private_file_stays_private(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("old")
    (tmp_path / "a").chmod(0o600)
    write_together([single_file(tmp_path / "a", "new"), single_file(tmp_path / "b", "new")])
    assert (tmp_path / "a").stat().st_mode & 0o777 == 0o600
    (tmp_path / "c").touch()
    assert (tmp_path / "b").stat().st_mode == (tmp_path / "c").stat().st_mode


def test_a_link_that_is_put_in_a_folder_leads_no_file_elsewhere(tmp_path: Path) -> None:
    private, folder = tmp_path / "private", tmp_path / "folder"
    for made in (private, folder):
        made.mkdir()
    (private / "b").write_text("mine")
    (folder / "sub").symlink_to(private)
    (folder / "b").symlink_to(private / "b")
    with pytest.raises(OSError, match="sub/b"):
        write_together([Batch(folder, {"sub/b": "theirs"})])
    write_together([Batch(folder, {"b": "new"})])
    assert (private / "b").read_text() == "mine"
    assert not (folder / "b").is_symlink()


MINE, THEIRS = 1001, 1002
PLAN = ["show", "saw-500rpm", "--svg", "shared/planned.svg"]
# By what it names: a link of another user, and the command.
LINKED = {
    "link": ("x.svg", ["show", "saw-500rpm", "--svg", "shared/x.svg"]),
    "link, roundabout": ("x.svg", ["show", "saw-500rpm", "--svg", "shared/../shared/x.svg"]),
    "linked folder": ("x", ["export", "saw-500rpm", "--format", "pack", "-o", "shared/x"]),
    "below linked folder": ("x", ["export", "saw-500rpm", "--format", "pack", "-o", "shared/x/new"]),
    "linked ledger": ("x.sqlite", ["validate", "saw-500rpm", "--ledger", "shared/x.sqlite"]),
}
OWN = ["show", "saw-500rpm", "--svg", "shared/own/own.svg"]
# Runs one command after another, and prints status and errors of each.
COMMAND_LINES = """
import contextlib, io, json, sys
from conrod.__main__ import main
print("imported")
for arguments in json.loads(sys.argv[1]):
    sys.argv, said = ["conrod", *arguments], io.StringIO()
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        try:
            main()
        except SystemExit as ended:
            print(json.dumps([ended.code or 0, said.getvalue()]), file=sys.__stdout__)
"""


def as_user(uid: int, code: str, *arguments: str, cwd: Path) -> subprocess.CompletedProcess[str]:
    """What another user runs; reading is allowed to all, for Python itself may lie in a folder of root's."""
    user = ["--reuid", f"{uid}", "--regid", f"{uid}", "--clear-groups"]
    reading = ["--inh-caps", "+dac_read_search", "--ambient-caps", "+dac_read_search"]
    return subprocess.run(
        ["setpriv", *user, *reading, sys.executable, "-c", code, *arguments],
        cwd=cwd, capture_output=True, text=True, check=False, env={**os.environ, "HOME": str(cwd)},
    )  # fmt: skip


@pytest.fixture(scope="module")
def home() -> Iterator[Path]:
    """A folder in which all may write and each remove only what is theirs, beside a private one of user 1001."""
    if os.geteuid() != 0 or shutil.which("setpriv") is None:
        pytest.skip("only root can be two users, by setpriv")
    with tempfile.TemporaryDirectory() as name:
        home = Path(name)
        home.chmod(0o755)
        (home / "shared").mkdir()
        (home / "shared").chmod(0o1777)
        (home / "private").mkdir(mode=0o700)
        (home / "private/notes.md").write_text("mine")
        for path in (home / "private", home / "private/notes.md"):
            os.chown(path, MINE, MINE)
        plant_links(home)
        plant_plan(home / "shared/.conrod-x")
        yield home


def plant_links(home: Path) -> None:
    """Put links into the shared folder, of user 1002 but for `own`, that lead into the private one of user 1001."""
    for link, owner in (("x", THEIRS), ("x.svg", THEIRS), ("x.sqlite", THEIRS), ("own", MINE)):
        target = home / "private" if "." not in link else home / "private" / link
        (home / "shared" / link).symlink_to(target)
        os.chown(home / "shared" / link, owner, owner, follow_symlinks=False)


def plant_plan(left: Path) -> None:
    """Leave what an earlier version left when it was killed, as user 1002."""
    left.mkdir()
    left.chmod(0o777)
    plan = {"../private/sitecustomize.py": None, "../private/notes.md": hashlib.sha256(b"mine").hexdigest()}
    for name, text in (("0", "theirs"), ("1", "theirs"), ("planned.json", json.dumps(plan))):
        (left / name).write_text(text)
    for path in (left, *left.iterdir()):
        os.chown(path, THEIRS, THEIRS)


@pytest.fixture(scope="module")
def ended(home: Path) -> dict[str, tuple[int, str]]:
    """Status and errors of each command of user 1001, all run by one Python."""
    commands = {"plan": PLAN, **{what: arguments for what, (_, arguments) in LINKED.items()}, "own link": OWN}
    done = as_user(MINE, COMMAND_LINES, json.dumps(list(commands.values())), cwd=home)
    if not done.stdout.startswith("imported\n"):
        pytest.skip("root has not the right to let others read")
    assert done.returncode == 0, done.stderr
    found = [json.loads(line) for line in done.stdout.splitlines()[1:]]
    return {what: (status, said) for what, (status, said) in zip(commands, found, strict=True)}


def test_another_users_plan_touches_nothing(home: Path, ended: dict[str, tuple[int, str]]) -> None:
    assert ended["plan"][0] == 0, ended["plan"]
    assert (home / "private/notes.md").read_text() == "mine"
    assert (home / "shared/planned.svg").stat().st_uid == MINE


@pytest.mark.parametrize("what", LINKED)
def test_another_users_link_is_not_followed(what: str, ended: dict[str, tuple[int, str]]) -> None:
    link, _ = LINKED[what]
    status, said = ended[what]
    assert status == 2
    assert f"shared/{link} is a link of another user (uid {THEIRS}); name the place that it leads to" in said


def test_only_a_link_of_ones_own_is_followed(home: Path, ended: dict[str, tuple[int, str]]) -> None:
    # Nothing else was written behind a link, and nothing by a plan.
    assert ended["own link"][0] == 0, ended["own link"]
    found = contents(home / "private")
    assert found.keys() == {"notes.md", "own.svg"}
    assert found["notes.md"] == b"mine"


def test_a_report_claims_no_file_that_is_none_of_a_report(tmp_path: Path) -> None:
    # As unpacked from an archive: its results claim what it does not contain.
    folder = tmp_path / "report"
    write(folder, study("saw-40rpm"))
    for claimed in ("thesis.tex", "sub/thesis.md", "../thesis.md", "figures/../../thesis.md", "/etc/passwd"):
        document = json.loads((folder / FREE_MOTION_REPORT.results).read_text())
        document["files"] = ["README.md", FREE_MOTION_REPORT.results, claimed]
        (folder / FREE_MOTION_REPORT.results).write_text(json.dumps(document))
        done = conrod("report", str(folder))
        assert done.returncode == 2
        assert "is no file of a report" in done.stderr or "is not in its folder" in done.stderr
