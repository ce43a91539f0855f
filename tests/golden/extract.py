"""What commands write, as golden records: the one module that knows columns, JSON keys, messages and the ledger.

Left out are costs, wording (reasons, titles) and what is a quotient of other records. A name is golden's own: where a
key of conrod changes, this module follows and the data stay.
"""

from __future__ import annotations

import csv
import hashlib
import json
import math
import re
import sqlite3
import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from conrod.exact.link_rotations import ROTATION_COLUMNS, ROTATIONS
from tests.golden.record import Record, leaves

Records = Iterator[tuple[str, Record]]
Entry = Mapping[str, Any]

ROOT = Path(__file__).parents[2]
NORMALISED = 1.0


def written(group: str, file: Path) -> Records:
    """Records of the file that a command of a group wrote."""
    yield from EXTRACTORS[group](file)


def _json(file: Path, key: str) -> list[Any]:
    found = json.loads(file.read_text(encoding="utf-8"))[key]
    assert isinstance(found, list)
    return found


def _exactly(name: str, tree: Any) -> Records:
    for place, value in leaves(name, tree):
        yield place, Record(value)


def _measured(name: str, tree: Any, unit: float = NORMALISED) -> Records:
    for place, value in leaves(name, tree):
        yield place, Record(value, unit)


def _verdict(name: str, passed: bool | None) -> Records:
    yield f"{name}/verdict", Record({True: "passed", False: "failed", None: "not judged"}[passed])


def _orders(
    name: str, orders: Entry | None, sizes: Mapping[str, Sequence[float | None]], unit: float = NORMALISED
) -> Records:
    """Orders by quantity.

    An order is the logarithm of a quotient of errors, each known to a share of its unit: so it is known to that over
    the smallest of them.

    Args:
        sizes: errors that the orders are taken from.
        unit: of the errors.
    """
    for quantity, order in (orders or {}).items():
        known = [size for size in sizes.get(quantity, ()) if size]
        spread = 2.0 / math.log(2.0) * unit / min(known) if known else unit
        yield from _measured(f"{name}/order/{quantity}", order, spread)


def _series(points: Iterable[Entry] | None, quantities: Iterable[str]) -> dict[str, list[float | None]]:
    """Quantity -> its sizes over the points of a refinement."""
    points = list(points or ())
    return {quantity: [point.get(quantity) for point in points] for quantity in quantities}


# -- validate ----------------------------------------------------------------------------------------------------------

VALIDATED = ("errors", "closure", "phase", "drive", "prediction", "refinement")


def _validation(file: Path) -> Records:
    parts = json.loads(file.read_text(encoding="utf-8"))["parts"].values()
    for entry in (one for part in parts for one in part["findings"]["results"]):
        name = f"{entry['scene']}/{entry['engine']}/{entry['preset'] or entry['mode']}"
        for key in ("mode", "outcome", "steps_per_revolution", "revolutions"):
            yield from _exactly(f"{name}/{key}", entry[key])
        for key in VALIDATED:
            yield from _measured(f"{name}/{key}", entry[key] or None)
        yield from _orders(name, entry["order"], _series(entry["refinement"], entry["order"] or ()))
        # Links' rotations are younger than the data; tests/comparison/test_link_errors.py has them.
        tolerance = _without(entry["tolerance"], "reason", *ROTATIONS)
        yield from _exactly(f"{name}/tolerance", tolerance if any(tolerance.values()) else {})
        yield from _verdict(name, entry["passed"])


def _without(entry: Entry | None, *keys: str) -> dict[str, Any]:
    return {key: value for key, value in (entry or {}).items() if key not in keys}


def _forces(file: Path) -> Records:
    for part in json.loads(file.read_text(encoding="utf-8"))["parts"].values():
        for entry, summary in zip(part["findings"]["results"], part["summary"]["results"], strict=True):
            name = f"{entry['scene']}/{entry['engine']}/{entry['preset']}"
            for key in ("outcome", "steps_per_revolution", "revolutions", "tolerance"):
                yield from _exactly(f"{name}/{key}", entry[key] or None)
            # pymunk's forces are impulses over a step, and with it their rounding: by the steps larger than a
            # velocity's.
            unit = NORMALISED * (entry["steps_per_revolution"] if entry["engine"] == "pymunk" else 1)
            for key in ("errors", "likeness", "refinement"):
                yield from _measured(f"{name}/{key}", entry[key] or None, unit)
            yield from _measured(f"{name}/largest", summary["largest"], unit)
            refined = [point["errors"] or {} for point in entry["refinement"]]
            sizes = {key: _sizes(key, refined) for key in entry["order"] or ()}
            yield from _orders(name, entry["order"], sizes, unit)
            yield f"{name}/unsupported", Record(", ".join(sorted(entry["unsupported"] or ())))
            yield from _verdict(name, entry["passed"])


def _sizes(key: str, refined: Sequence[Entry]) -> list[float | None]:
    """Errors that an order is taken from: those of its quantity, or of all where it is of a group of them."""
    return [size for point in refined for quantity, size in point.items() if key == quantity or key not in point]


def _motion(file: Path) -> Records:
    for part in json.loads(file.read_text(encoding="utf-8"))["parts"].values():
        entry, judged = part["findings"], part["summary"]["results"]
        whole, told = f"{entry['name']}/{entry['motion']}", entry["results"][0]["exact"]
        exact = {"drift": told["drift"], "continuation": told["continuation"] or None}
        yield from _measured(f"{whole}/exact", exact)
        yield from _exactly(f"{whole}/left_out", entry["left_out"])
        yield from _verdict(whole, part["summary"]["passed"])
        for result, verdict in zip(entry["results"], judged, strict=True):
            name = f"{whole}/{result['engine']}/{result['preset']}"
            for key in ("outcome", "step", "seconds", "leaving", "leaves", "tolerance"):
                yield from _exactly(f"{name}/{key}", result[key] or None)
            for key in ("errors", "energy", "refinement"):
                yield from _measured(f"{name}/{key}", result[key] or None)
            yield from _orders(name, result["order"], _series(result["refinement"], result["order"] or ()))
            yield from _verdict(name, verdict["passed"])


# -- studies -----------------------------------------------------------------------------------------------------------


def _limits(file: Path) -> Records:
    for part in json.loads(file.read_text(encoding="utf-8"))["parts"].values():
        study = part["findings"]
        for walk in study["walks"]:
            name = f"{walk['scene']}/{walk['axis']}/{walk['engine']}/{walk['preset']}"
            yield f"{name}/refused", Record(bool(walk["refusal"]))
            for probe in walk["probes"]:
                yield from _probe(f"{name}/{probe['value']!r}", probe)
            for edge in walk["boundaries"]:
                place = f"{name}/boundary/{edge['criterion']}"
                yield from _exactly(place, _without(edge, "criterion", "undetected"))
                yield f"{place}/undetected", Record(edge["undetected"])
        for entry in study["determinism"]:
            name = f"{entry['scene']}/{entry['engine']}/{entry['preset']}"
            prints = entry["fingerprints"]
            first, *others = prints
            same = {run: prints[run] == prints[first] for run in others}
            for key, value in (("outcome", entry["outcome"]), ("fingerprints", prints), ("identical", same)):
                yield from _exactly(f"{name}/{key}", value)


def _probe(name: str, probe: Entry) -> Records:
    yield f"{name}/level", Record(probe["level"])
    yield f"{name}/outcome", Record(probe["outcome"])
    yield f"{name}/undetected", Record(probe["undetected"])
    yield from _measured(f"{name}/errors", probe["errors"])
    yield from _measured(f"{name}/torque", probe["torque"])


# Words of the day when the data were made.
BEFORE = {"full": "dressed", "required": "needed", "undecided": "not told"}


def _findings(file: Path) -> Iterator[Any]:
    """Findings of each part of a report's document."""
    for part in json.loads(file.read_text(encoding="utf-8"))["parts"].values():
        yield part["findings"]


def _ablate(file: Path) -> Records:
    for study in _findings(file):
        for engine in study["engines"]:
            whole = f"{study['name']}/{engine['engine']}"
            for ingredient in engine["ingredients"]:
                yield from _ingredient(f"{whole}/{ingredient['name']}", ingredient)
            for variant in engine["variants"]:
                name = f"{whole}/{BEFORE.get(variant['role'], variant['role'])}/{variant['ingredient']}"
                yield f"{name}/outcome", Record(variant["outcome"])
                for key in ("errors", "change"):
                    yield from _measured(f"{name}/{key}", variant[key])


def _ingredient(name: str, ingredient: Entry) -> Records:
    for key in ("minimal", "needed_by"):
        yield from _exactly(f"{name}/{key}", ingredient[key])
    # Free or costly is a matter of time, which is not golden.
    verdict = {"free": "right without it", "costly": "right without it", "undecided": "not told"}
    yield f"{name}/verdict", Record(str(verdict.get(ingredient["verdict"], ingredient["verdict"])))
    for evidence in ingredient["evidence"]:
        place = f"{name}/{'in full' if evidence['full'] else 'in minimal'}"
        yield from _measured(f"{place}/change", evidence["change"])
        yield f"{place}/effect", Record(str(BEFORE.get(evidence["effect"], evidence["effect"])))


def _sweep(file: Path) -> Records:
    runs = kept_runs(file.parent / "own.sqlite")
    for sweep in _findings(file):
        for point in sweep["points"]:
            name = f"{point['engine']}/{point['key']}"
            yield f"{name}/steps", Record(point["steps_per_revolution"])
            yield from _measured(
                name, _without(json.loads(zlib.decompress(runs[point["key"]][-1])), "reason", "signed", "sizes")
            )
        for rule in sweep["rules"]:
            own = [p for p in sweep["points"] if (p["engine"], p["rule"]) == (rule["engine"], rule["name"])]
            sizes = _series([point["errors"] or {} for point in own], rule["orders"])
            claimed = {quantity: order["claimed"] for quantity, order in rule["orders"].items()}
            yield from _orders(f"{rule['engine']}/{rule['name']}", claimed, sizes)


# -- exports -----------------------------------------------------------------------------------------------------------

# A heading such as `A.vx [m/s]`: point, quantity, axis.
LINK_COLUMNS = tuple(f"{word}_" for word in ROTATION_COLUMNS.values())
HEADING = re.compile(r"(?P<name>.+?)(\.(?P<quantity>[vaj]?)[xy])? \[.*\]")


def _exact(file: Path) -> Records:
    with file.open(newline="", encoding="utf-8") as stream:
        headings, *rows = csv.reader(stream)
    columns = dict(zip(headings, ([float(text) for text in column] for column in zip(*rows, strict=True)), strict=True))
    # Columns of links are younger than the data; tests/exact/test_link_rotations.py has them.
    columns = {heading: values for heading, values in columns.items() if not heading.startswith(LINK_COLUMNS)}
    # A machine's rounding goes by its size: a component near zero is a difference of lengths that are not.
    sizes: dict[object, float] = {}
    for heading, values in columns.items():
        kind = _kind(heading)
        sizes[kind] = max(sizes.get(kind, 0.0), *map(abs, values))
    for heading, values in columns.items():
        yield heading, Record(values, sizes[_kind(heading)])


def _kind(heading: str) -> str:
    """Position, velocity, acceleration or jerk of the points; another column is of its own kind."""
    found = HEADING.fullmatch(heading)
    assert found is not None, heading
    return found["name"] if found["quantity"] is None else f".{found['quantity']}"


def _mjcf(file: Path) -> Records:
    content = file.read_bytes()
    yield "sha256", Record(hashlib.sha256(content).hexdigest())
    yield "bytes", Record(len(content))
    yield "is the committed one", Record(content == (ROOT / "mjcf" / file.name).read_bytes())


# -- the ledger --------------------------------------------------------------------------------------------------------

# What a study says before it runs anything.
TO_DO = re.compile(r"^runs: (\d+) (?:more )?to do, (\d+) in the ledger$", re.MULTILINE)
# Of the rows of `conrod results`; the others name the run or tell its cost.
ROW = ("position", "velocity", "acceleration", "total", "closure", "phase", "drive", "predicted")


def announced(messages: str) -> tuple[int, int]:
    """Runs that a study had to do, and those that the ledger had; of what it wrote to standard error.

    Raises:
        ValueError: it says nothing of that.
    """
    rounds = [tuple(map(int, found)) for found in TO_DO.findall(messages)]
    if not rounds:
        raise ValueError(f"nothing is said of the ledger in: {messages}")
    return sum(new for new, _ in rounds), sum(kept for _, kept in rounds)


def kept_runs(ledger: Path) -> dict[str, tuple[Any, ...]]:
    """Key of a run -> all that the ledger keeps of it."""
    connection = sqlite3.connect(ledger)
    try:
        return {key: row for key, *row in connection.execute("SELECT key, outcome, allowed, result FROM runs")}
    finally:
        connection.close()


def compact(ledger: Path) -> None:
    """Make a ledger one small file."""
    connection = sqlite3.connect(ledger)
    try:
        connection.execute("PRAGMA journal_mode = DELETE")
        connection.execute("VACUUM")
    finally:
        connection.close()


def result_rows(file: Path) -> Records:
    """Records of the tidy rows that `conrod results` wrote.

    A case that was timed on several machines has a row for each; they differ in machine and cost alone, so they
    are one record.

    Raises:
        RuntimeError: two rows of one case differ in what was measured.
    """
    seen: dict[str, dict[str, Any]] = {}
    for row in json.loads(file.read_text(encoding="utf-8")):
        measured = {column: value for column, value in row.items() if column == "outcome" or column.startswith(ROW)}
        if (before := seen.setdefault(row["key"], measured)) is not measured:
            if before != measured:
                raise RuntimeError(f"two rows of the case {row['key']} differ in what was measured")
            continue
        name = f"row/{row['key']}"
        yield f"{name}/outcome", Record(row["outcome"])
        for column, value in measured.items():
            if column != "outcome":
                yield from _measured(f"{name}/{column}", value)


EXTRACTORS: dict[str, Callable[[Path], Records]] = {
    "scenes": _validation,
    "catalogue": _validation,
    "forces": _forces,
    "motion": _motion,
    "limits": _limits,
    "determinism": _limits,
    "ablate": _ablate,
    "sweep": _sweep,
    "exact": _exact,
    "mjcf": _mjcf,
}
