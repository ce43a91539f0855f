"""An input of the command line, what has to be said of it, and what was said."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

TIME_LIMIT = 300.0  # [s] of one command
# Ways in which conrod says that it does not know a cause.
NOT_KNOWN = re.compile(
    r"none of the common causes|(cause|reason|why)\b[^.;\n]* (is|are|was) not known|is unknown\b", re.I
)
# Words of an alarm, which nothing that is said of a healthy input may have.
ALARM = re.compile(
    r"OUT OF TOLERANCE|CANNOT BE TRUSTED|STRAYS|NOT NOTICED|likely cause|looks like a wrong|did not pass|as it stands"
    r"|Traceback|ended as|diverged|exploded|opened:|stands in the way|\bfailed\b"
)
WRONG = ("named rightly", "unknown said", "named otherwise", "silent", "traceback")
HEALTHY = ("no alarm", "not said to be measured", "alarm", "traceback")


@dataclass(frozen=True)
class Input:
    """A command with its files, wrong or healthy.

    Attributes:
        kind, name: for the table; the name says what was changed.
        files: by the name that they have in the working folder.
        arguments: of `conrod`.
        expected: of a wrong input what the cause is called, a regular expression; of a healthy one what is said of it.
        healthy: whether nothing is wrong with it.
        statuses: that the command may end with.
    """

    kind: str
    name: str
    files: Mapping[str, str | bytes]
    arguments: tuple[str, ...]
    expected: str
    healthy: bool
    statuses: tuple[int, ...]

    @property
    def key(self) -> str:
        """Digest of all that the answer depends on but for conrod itself."""
        files = {name: hashlib.sha256(_bytes(content)).hexdigest() for name, content in self.files.items()}
        text = json.dumps([self.kind, self.name, files, self.arguments])
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def wrong(
    kind: str, name: str, files: Mapping[str, str | bytes], arguments: str, expected: str,
    statuses: tuple[int, ...] = (1, 2),
) -> Input:  # fmt: skip
    """An input with a fault, and what its cause is called."""
    return Input(kind, name, files, tuple(arguments.split()), expected, False, statuses)


def healthy(kind: str, name: str, files: Mapping[str, str | bytes], arguments: str, expected: str) -> Input:
    """An input with no fault, and the words of the verdict that it is to have."""
    return Input(kind, name, files, tuple(arguments.split()), expected, True, (0,))


def _bytes(content: str | bytes) -> bytes:
    return content if isinstance(content, bytes) else content.encode("utf-8")


@dataclass(frozen=True)
class Answer:
    """What conrod said of an input.

    Attributes:
        status: with which the command ended; -1 where it did not end.
        output: all that it wrote, standard output first.
        first: the first line that says anything of the input.
    """

    status: int
    output: str
    first: str


def ask(given: Input, ledger: Path | None = None) -> Answer:
    """Run the command as a user types it, in a folder of its own."""
    folder = Path(tempfile.mkdtemp(prefix="conrod-input-"))
    try:
        for name, content in given.files.items():
            (folder / name).write_bytes(_bytes(content))
        kept = str(ledger or folder / "ledger.sqlite")
        surroundings = {**os.environ, "CONROD_LEDGER": kept, "OMP_NUM_THREADS": "1", "COLUMNS": "400", "NO_COLOR": "1"}
        command = [sys.executable, "-m", "conrod", *given.arguments]
        try:
            ended = subprocess.run(
                command, cwd=folder, env=surroundings, capture_output=True, text=True, timeout=TIME_LIMIT, check=False
            )
        except subprocess.TimeoutExpired:
            return Answer(-1, f"no answer within {TIME_LIMIT:g} s", f"no answer within {TIME_LIMIT:g} s")
        return answer_of(ended.returncode, ended.stdout, ended.stderr)
    finally:
        shutil.rmtree(folder, ignore_errors=True)


PROGRESS = re.compile(r"^(runs: |.*: running \()")


def answer_of(status: int, written: str, errors: str) -> Answer:
    """The answer without words in passing."""
    lines = [line for text in (written, errors) for line in text.splitlines() if not PROGRESS.match(line)]
    return Answer(status, "\n".join(lines), next((line for line in lines if line.strip()), ""))


def judge(given: Input, answer: Answer) -> str:
    """One of `WRONG`, or of `HEALTHY`."""
    refused = answer.status == 2
    if "Traceback (most recent" in answer.output or answer.status not in (0, 1, 2):
        return "traceback"
    if given.healthy:
        if answer.status not in given.statuses or ALARM.search(answer.output):
            return "alarm"
        return "no alarm" if re.search(given.expected, answer.output) else "not said to be measured"
    if answer.status not in given.statuses:
        return "silent"
    if re.search(given.expected, answer.output, re.IGNORECASE) and not (refused and "\n" in answer.output):
        return "named rightly"
    return "unknown said" if NOT_KNOWN.search(answer.output) else "named otherwise"
