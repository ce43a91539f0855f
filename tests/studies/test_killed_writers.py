"""What a killed process leaves of the files that it was writing is completed or undone; other ends leave nothing."""

from __future__ import annotations

import hashlib
import json
import subprocess
import sys
from pathlib import Path

from conrod.studies.frame.files import check_writable_folder
from conrod.studies.frame.writing import PLANNED, STAGING, staging_in

NAMES = ("README.md", "results.json", "data/a.json", "figures/b.svg", "same")
FILES = {name: f"new {name}" for name in NAMES} | {"same": "old same"}
# Writes a report's folder and a file elsewhere, again and again, killed before its first step, its second, and so on; a
# step is whatever Python reports of a call on the file system. Prints what is there then, and after one of the folders,
# in turns, was looked at.
WRITER = f"""
import json, os, shutil, signal, sys
from pathlib import Path
from conrod.studies.frame.files import check_writable_folder
from conrod.studies.frame.writing import Batch, single, write_together, staging_in
root = Path(sys.argv[1])
def state():
    return {{str(file.relative_to(root)): file.read_text() for file in root.rglob("*") if file.is_file()}}
def killed(step):
    process = os.fork()
    if process:
        return os.waitpid(process, 0)[1] != 0
    def count(event, _):
        nonlocal step
        step -= event in ("open", "os.rename", "os.remove", "os.rmdir", "os.mkdir")
        if step < 0:
            os.kill(os.getpid(), signal.SIGKILL)
    sys.addaudithook(count)
    write_together([Batch(root / "report", {FILES!r}, ("obsolete",)), single(root / "beside" / "all.json", "new")])
    os._exit(0)
step, more = 0, True
while more:
    shutil.rmtree(root, ignore_errors=True)
    for name in ("report/README.md", "report/data/a.json", "report/obsolete", "report/same", "report/mine", "beside/x"):
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(f"old {{Path(name).name}}")
    more = killed(step)
    torn = state()
    for folder in ("report", "beside")[:: 1 if step % 2 else -1]:
        check_writable_folder(root / folder)
    print(json.dumps([torn, state()]))
    step += 1
"""


def test_a_kill_at_any_step_leaves_all_or_nothing_once_a_folder_is_looked_at(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, "-c", WRITER, tmp_path / "root"], check=True, capture_output=True, text=True)
    states = [json.loads(line) for line in done.stdout.splitlines()]
    old = {name: f"old {Path(name).name}" for name in states[0][0]}
    new = {f"report/{name}": text for name, text in FILES.items()}
    new |= {"report/mine": "old mine", "beside/x": "old x", "beside/all.json": "new"}
    for place in ("report", "beside"):
        before, after = ({name: text for name, text in files.items() if name.startswith(place)} for files in (old, new))
        found = [{name: text for name, text in files.items() if name.startswith(place)} for _, files in states]
        switch = found.index(after)
        assert found == [before] * switch + [after] * (len(found) - switch)
        assert 20 < switch < len(found) - 5
    # Negative control: it was killed in the middle, too, and left its hidden folder.
    torn = [{name: text for name, text in before.items() if STAGING not in name} for before, _ in states]
    assert sum(files not in (old, new) for files in torn) > 4
    assert any(STAGING in name for before, _ in states for name in before)


def left_behind(folder: Path, plan: object, *contents: str) -> None:
    """What a killed process leaves in a folder: files, and a plan of where they go."""
    left = folder / f"{STAGING}x"
    left.mkdir(parents=True, exist_ok=True)
    for k, content in enumerate(contents):
        (left / f"{k}").write_text(content)
    (left / PLANNED).write_text(json.dumps(plan))


def digest(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()


def test_what_was_edited_since_the_kill_stays_and_a_living_writer_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "a").write_text("edited")
    (tmp_path / "b").write_text("old b")
    left_behind(tmp_path, {name: digest(f"old {name}") for name in "ab"}, "new a", "new b")
    with staging_in(tmp_path) as waiting:
        check_writable_folder(tmp_path)
        assert waiting.is_dir()
    assert {file.name: file.read_text() for file in tmp_path.iterdir()} == {"a": "edited", "b": "new b"}


def test_a_planted_plan_touches_nothing_outside_its_folder(tmp_path: Path) -> None:
    precious, folder = tmp_path / "precious", tmp_path / "folder"
    precious.write_text("mine")
    for plan in ({"../precious": digest("mine")}, {str(precious): digest("mine")}, {"..": None}, {"a": 7}, "nonsense"):
        left_behind(folder, plan, "theirs")
        check_writable_folder(folder)
        assert precious.read_text() == "mine"
        assert list(folder.iterdir()) == []
