"""How much of conrod has to be read to follow the commonest command: the files whose functions it calls."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import conrod

MOST = 50
COUNTING = """
import sys, threading
called = set()
def seen(frame, event, _):
    if event == "call" and frame.f_code.co_flags & 1:  # a function, not the body of a module or class
        called.add(frame.f_code.co_filename)
threading.setprofile(seen)
sys.setprofile(seen)
from conrod.cli import main
sys.argv = ["conrod", "validate", "saw-500rpm", "--fresh", "--ledger", sys.argv[1]]
main()
sys.setprofile(None)
print(*sorted(called), sep="\\n", file=sys.stderr)
"""


def test_a_validation_calls_functions_in_few_files(tmp_path: Path) -> None:
    command = [sys.executable, "-c", COUNTING, tmp_path / "l.sqlite"]
    done = subprocess.run(command, check=True, capture_output=True, text=True)
    own = [file for file in done.stderr.splitlines() if file.startswith(str(Path(conrod.__file__).parent))]
    assert 20 < len(own) <= MOST, own
