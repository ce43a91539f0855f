"""`python -m docs.studies.inputs [--write docs/detection.md]`: two hundred inputs, and what conrod says of each.

Answers are kept in `build/` by input and by the digest of conrod's own files: what is interrupted goes on where it
stopped, and a change of conrod asks all inputs again.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import asdict
from pathlib import Path

from docs.studies.inputs import data, files, geometry, motion
from docs.studies.inputs.edits import ROOT
from docs.studies.inputs.input import HEALTHY, WRONG, Answer, Input, ask, judge

KINDS = (
    geometry.lengths, geometry.joints, geometry.closures, motion.starts, motion.drives, motion.besides,
    data.columns, data.sensors, files.mechanisms, files.printed,
)  # fmt: skip
BEGIN, END = "<!-- inputs: made by `make inputs` -->", "<!-- end of inputs -->"
GOOD = ("named rightly", "unknown said", "no alarm")
LONGEST = 200  # characters of what was said


def all_inputs() -> Iterator[Input]:
    """All inputs, kind by kind, the wrong ones first."""
    for kind in KINDS:
        yield from kind()


def code_digest() -> str:
    """Digest of conrod's own files, on which every answer depends."""
    found = hashlib.sha256()
    for path in sorted((ROOT / "src").rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts and "egg-info" not in str(path):
            found.update(str(path.relative_to(ROOT)).encode() + path.read_bytes())
    return found.hexdigest()[:12]


def answers(asked: Sequence[Input], kept: Path, jobs: int) -> dict[str, Answer]:
    """Answers by the keys of inputs, those that were kept among them; each new one is kept at once."""
    lines = kept.read_text(encoding="utf-8").splitlines() if kept.exists() else []
    known = {one["key"]: Answer(**one["answer"]) for one in map(json.loads, lines)}
    found = {given.key: known[given.key] for given in asked if given.key in known}
    missing = [given for given in asked if given.key not in found]
    kept.parent.mkdir(exist_ok=True)
    with ThreadPoolExecutor(jobs) as threads, kept.open("a", encoding="utf-8") as file:
        running = {threads.submit(ask, given): given for given in missing}
        for done in as_completed(running):
            given, answer = running[done], done.result()
            found[given.key] = answer
            file.write(json.dumps({"key": given.key, "answer": asdict(answer)}) + "\n")
            file.flush()
            print(f"{len(found)} of {len(asked)}: {judge(given, answer)}: {given.kind}: {given.name}", flush=True)
    return found


def table(found: Mapping[str, Answer], asked: Iterable[Input], healthy: bool) -> list[str]:
    """A Markdown table: a row for each kind, a column for each judgement."""
    columns = HEALTHY if healthy else WRONG
    counts = {given.kind: Counter[str]() for given in asked}
    for given in asked:
        if given.healthy == healthy:
            counts[given.kind][judge(given, found[given.key])] += 1
    rows = [
        [kind, *(str(n) for n in (counted.total(), *(counted[c] for c in columns)))] for kind, counted in counts.items()
    ]
    rows.append(["all", *(str(sum(int(row[k]) for row in rows)) for k in range(1, len(columns) + 2))])
    head = f"| {'healthy' if healthy else 'wrong'} inputs | tried | {' | '.join(columns)} |"
    return [head, "|---" * (len(columns) + 2) + "|", *(f"| {' | '.join(row)} |" for row in rows)]


def misses(found: Mapping[str, Answer], asked: Iterable[Input]) -> list[str]:
    """Inputs that were not judged as they should be, with what was said of each."""
    judged = [(given, judge(given, found[given.key]), found[given.key]) for given in asked]
    return [
        f"- {verdict}: {given.kind}: {given.name} (status {answer.status}): `{answer.first[:LONGEST].replace('`', '')}`"
        for given, verdict, answer in judged
        if verdict not in GOOD
    ]


def section(found: Mapping[str, Answer], asked: Sequence[Input]) -> str:
    """What stands in docs/detection.md between the markers."""
    missed = misses(found, asked)
    listed = ["Not as it should be:", "", *missed] if missed else ["All are as they should be."]
    parts = [BEGIN, "", *table(found, asked, False), "", *table(found, asked, True), "", *listed, "", END]
    return "\n".join(parts)


def main() -> None:
    """Ask all inputs, print the tables, and write them between the markers of a page."""
    given = argparse.ArgumentParser(description=__doc__)
    given.add_argument("--write", type=Path, help="page that holds the tables between its markers")
    given.add_argument("--jobs", type=int, default=2)
    given.add_argument("--only", default="", help="part of a kind's or an input's name")
    given.add_argument("--say", action="store_true", help="print all that was said of what is missed")
    options = given.parse_args()
    asked = [one for one in all_inputs() if options.only in f"{one.kind}: {one.name}"]
    found = answers(asked, ROOT / "build" / f"inputs-{code_digest()}.jsonl", options.jobs)
    text = section(found, asked)
    print(text)
    for one in asked if options.say else ():
        if judge(one, found[one.key]) not in GOOD:
            print(f"\n=== {one.kind}: {one.name}: {judge(one, found[one.key])}\n{found[one.key].output}")
    if options.write and not options.only:
        page = options.write.read_text(encoding="utf-8")
        before, _, rest = page.partition(BEGIN)
        options.write.write_text(before + text + rest.partition(END)[2], encoding="utf-8")


if __name__ == "__main__":
    main()
