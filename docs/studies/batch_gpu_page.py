"""`python -m docs.studies.batch_gpu_page FILE [FILE ...] --out DIR`: the page of what `batch_gpu` measured.

Reads files of `python -m docs.studies.batch_gpu`, as of a machine that was lent for several calls, and writes `gpu.md`,
its figure and its findings, of which `conrod report` renders it again.
"""

from __future__ import annotations

import argparse
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING, Any

from conrod.crash import run_guarded
from conrod.execution.files import folder_to_write
from conrod.execution.writing import write_together
from conrod.report.figure import Figure
from conrod.report.kind import Kind, Reproduction
from conrod.report.table import Table, table
from conrod.report.writer import report_batch

if TYPE_CHECKING:
    from matplotlib.figure import Figure as Canvas

TITLES = {"mujoco": "MuJoCo", "mjx": "MJX", "warp": "MuJoCo Warp"}
COLOURS = {"mujoco": "#1f77b4", "mjx": "#9467bd", "warp": "#2ca02c"}
MARKERS = {1: "D", 2: "s", 3: "o", "single": "^", "double": "v"}  # one thread, two, more; precision on a GPU
MACHINES = {"saw": "saws", "gripper": "grippers"}
Row = Mapping[str, Any]


@dataclass(frozen=True)
class GpuBatches:
    """What `batch_gpu` measured.

    Attributes:
        rows: a fleet stepped by an engine: cost, error.
        controls: fleets in which a member's model was made another's.
        precision: what single precision can tell.
        machine: processor, devices, versions, date.
    """

    rows: tuple[Row, ...]
    controls: tuple[Row, ...]
    precision: tuple[Row, ...]
    machine: Row


def merge(documents: Sequence[Mapping[str, Any]]) -> GpuBatches:
    """Join the findings of several files of one machine."""
    rows, controls, precision = (
        tuple(one for document in documents for one in document[part]) for part in ("rows", "controls", "precision")
    )
    machines = [document["machine"] for document in documents]
    versions = {name: number for machine in machines for name, number in machine["versions"].items()}
    devices = sorted({name for machine in machines for name in machine["devices"]})
    return GpuBatches(rows, controls, precision, {**machines[0], "versions": versions, "devices": devices})


def name(row: Row) -> str:
    """What stepped a fleet, in words."""
    if row["engine"] == "mujoco":
        return f"MuJoCo {row['integrator']}, {row['where']}"
    return f"{TITLES[row['engine']]} {row['integrator']}, {row['precision']}, GPU"


def curves(found: GpuBatches, machine: str) -> dict[str, list[Row]]:
    """Rows of a machine by what stepped it, by rising number of members."""
    by_name: dict[str, list[Row]] = {}
    for row in found.rows:
        if row["machine"] == machine:
            by_name.setdefault(name(row), []).append(row)
    return {one: sorted(rows, key=lambda row: row["count"]) for one, rows in by_name.items()}


def wins_from(gpu: Sequence[Row], cores: Sequence[Row]) -> float | None:
    """The number of members from which the GPU is cheaper, on lines between the measured ones; None if at none."""
    cost = {row["count"]: row["microseconds"] for row in cores}
    ratios = [(row["count"], row["microseconds"] / cost[row["count"]]) for row in gpu if row["count"] in cost]
    if not ratios or ratios[-1][1] >= 1.0:
        return None
    for (few, dear), (many, cheap) in reversed(list(pairwise(ratios))):
        if dear >= 1.0 > cheap:
            share = math.log(dear) / math.log(dear / cheap)
            return float(few * (many / few) ** share)
    return float(ratios[0][0])


def rounded(count: float) -> str:
    """A number of machines to one digit, since it lies between powers of ten."""
    digit = 10 ** math.floor(math.log10(count))
    return f"{round(count / digit) * digit:,}"


def two_digits(value: float) -> str:
    """A number with two digits, without an exponent."""
    return f"{float(f'{value:.2g}'):g}"


def cost_table(found: GpuBatches, machine: str) -> Table:
    """Microseconds of wall time per machine and step, by what steps and number of members."""
    by_name = curves(found, machine)
    counts = sorted({row["count"] for rows in by_name.values() for row in rows})
    rows = []
    for one, of in by_name.items():
        cells = {row["count"]: two_digits(row["microseconds"]) for row in of}
        rows.append((one, *(cells.get(count, "") for count in counts)))
    headings = (f"a step of a {machine} [µs], of so many at once", *(f"{count:,}" for count in counts))
    return table(headings, rows, headings[1:])


def error_table(found: GpuBatches) -> Table:
    """Errors over all members of the largest fleet that each was measured on in full."""
    rows = []
    for machine, plural in MACHINES.items():
        for one, of in curves(found, machine).items():
            whole = [row for row in of if row["error"]][-1]
            error = whole["error"]
            rows.append((f"{whole['count']:,} {plural}", one, f"{error['median']:.3g}", f"{error['largest']:.3g}"))
    headings = ("fleet", "stepped by", "median error / L", "largest error / L")
    return table(headings, rows, headings[2:])


def crossing_table(found: GpuBatches) -> Table:
    """From which number on the GPU is cheaper than cores, and how many times so with the largest fleet."""
    rows = []
    for machine, plural in MACHINES.items():
        by_name = curves(found, machine)
        for one, gpu in by_name.items():
            if gpu[0]["engine"] == "mujoco":
                continue
            for other, cores in by_name.items():
                if cores[0]["engine"] != "mujoco" or cores[0]["integrator"] != gpu[0]["integrator"]:
                    continue
                many = wins_from(gpu, cores)
                least = "at most " if many == gpu[0]["count"] else ""
                ratio = cores[-1]["microseconds"] / gpu[-1]["microseconds"]
                rows.append((plural, one, other, f"{least}{rounded(many)}" if many else "at none", two_digits(ratio)))
    headings = ("fleet", "GPU", "cores", "GPU is cheaper from", f"times, of {found.rows[-1]['count']:,}")
    return table(headings, rows, headings[3:])


def draw_costs(found: GpuBatches) -> Canvas:
    """Draw cost per machine and step over the number of machines, a panel for each machine."""
    from matplotlib.figure import Figure as Canvas

    canvas = Canvas(figsize=(9.0, 4.4), layout="constrained")
    panels = canvas.subplots(1, len(MACHINES), sharey=True)
    for axes, (machine, plural) in zip(panels, MACHINES.items(), strict=True):
        for one, rows in curves(found, machine).items():
            row = rows[0]
            cores = row["engine"] == "mujoco"
            axes.plot(
                [row["count"] for row in rows], [row["microseconds"] for row in rows], label=one,
                color=COLOURS[row["engine"]], linestyle="--" if row["integrator"] == "RK4" else "-",
                marker=MARKERS[min(row["threads"], 3) if cores else row["precision"]], markersize=4,
                markerfacecolor="white" if cores else COLOURS[row["engine"]],
            )  # fmt: skip
        axes.set(xscale="log", yscale="log", title=plural, xlabel="machines in one call")
        axes.grid(alpha=0.3)
    panels[0].set_ylabel("wall time of a step of one machine [µs]")
    canvas.legend(*panels[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)
    return canvas


def figure(found: GpuBatches) -> Figure:
    """The figure of costs."""
    alt = "Cost of a step of one machine over the number of machines in one call, on cores and on a GPU"
    return Figure("gpu-cost", alt, lambda: draw_costs(found))


def finding(found: GpuBatches) -> str:
    """The finding in a sentence or two."""
    sentences = []
    for machine, plural in MACHINES.items():
        by_name = curves(found, machine)
        cores = [
            rows for rows in by_name.values() if rows[0]["engine"] == "mujoco" and rows[0]["integrator"] == "Euler"
        ]
        gpus = [rows for rows in by_name.values() if rows[0]["engine"] != "mujoco" and rows[0]["integrator"] == "Euler"]
        best = min(gpus, key=lambda rows: rows[-1]["microseconds"])
        most = max(cores, key=lambda rows: int(rows[0]["threads"]))
        ratio = most[-1]["microseconds"] / best[-1]["microseconds"]
        froms = [
            f"than {rows[0]['where']} from about {rounded(many)} on"
            for rows in cores
            if (many := wins_from(best, rows))
        ]
        sentences.append(
            f"{best[-1]['count']:,} {plural} cost {TITLES[best[0]['engine']]} "
            f"{two_digits(best[-1]['microseconds'])} µs a step of each, {two_digits(ratio)} times less than MuJoCo on "
            f"{most[0]['where']}; it is cheaper {' and '.join(froms)}."
        )
    return f"On one {gpu_name(found)}, " + " ".join(sentences)


def gpu_name(found: GpuBatches) -> str:
    """The GPU's name as its driver has it."""
    return str(next(one for one in found.machine["devices"] if "core" not in one))


def precision_lines(found: GpuBatches) -> list[str]:
    """Return what single precision can tell, a point for each engine and machine."""
    against = {
        "mjx": "its errors are those in double precision to",
        "warp": "its errors are MuJoCo's in double precision to",
    }
    return [
        f"{TITLES[one['engine']]}, {one['count']:,} {MACHINES[one['machine']]}: {against[one['engine']]} "
        f"{one['moved']:.1g} of L; the drive's angle is {math.degrees(one['angle']):.1g} deg off after {STEPS} "
        f"steps. The exact motion rounded to single precision has an error of {one['rounded']:.1g}."
        for one in found.precision
    ]


def compiling_line(found: GpuBatches) -> str:
    """What compiling cost."""
    jax = [row["compiling"] for row in found.rows if row["engine"] == "mjx"]
    warp = [row["compiling"] for row in found.rows if row["engine"] == "warp"]
    first = [one for one in warp if one > 1.0]
    rest = max((one for one in warp if one <= 1.0), default=0.0)
    return (
        f"Compiling, once in a process: MJX {max(jax):.2g} s for {len(jax)} functions at once on all cores, one for "
        f"each size, machine and precision; Warp {' and '.join(f'{one:.2g} s' for one in first)} for the kernels of "
        f"the first and of the second machine, whatever the size, and {rest:.1g} s at most for each further size."
    )


def rk4_line(found: GpuBatches) -> str:
    """What RK4 gains each engine on the saw, for four evaluations a step."""
    gains = {}
    for engine in ("mujoco", "warp"):
        errors = {
            row["integrator"]: row["error"]["largest"]
            for row in found.rows if row["engine"] == engine and row["machine"] == "saw" and row["error"]
        }  # fmt: skip
        gains[engine] = two_digits(errors["Euler"] / errors["RK4"])
    return (
        f"On the saw RK4 makes MuJoCo's error {gains['mujoco']} times smaller and MuJoCo Warp's {gains['warp']} times: "
        "Warp takes dJ/dt v of its closures from the stage before, see [engines](../../docs/engines.md#mjx)."
    )


STEPS = 250


def control_lines(found: GpuBatches) -> list[str]:
    """Which planted defects were seen."""
    controls = found.controls
    alone = sum(one["seen"] == [one["planted"]] for one in controls)
    least = min(one["error"] / one["right"] for one in controls)
    others = sum(one["others_seen"] for one in controls)
    return [
        f"In a fleet of {controls[0]['count']} one member's model was made another's: in {alone} of {len(controls)} "
        f"runs its error, and its alone, is more than 5 % above the largest of right ones, {least:.2g} times at least. "
        f"Held against the exact motion of another member, {others} of {sum(one['count'] for one in controls)} are.",
    ]


def versions_text(found: GpuBatches) -> str:
    """Name the packages with their versions."""
    return ", ".join(f"{one} {number}" for one, number in found.machine["versions"].items())


BATCH_GPU_REPORT = Kind(
    name="batch-gpu",
    findings=GpuBatches,
    title=lambda found: "Batches on a GPU",
    summary=lambda found: {"finding": finding(found)},
    printed=lambda findings: [cost_table(found, machine) for found in findings for machine in MACHINES],
    verdict=finding,
    one_part=True,
    results="gpu.json",
    index_file="gpu.md",
    digits=6,
)


def main() -> None:
    """Make the page of batches on a GPU from what was measured."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.batch_gpu_page", description=main.__doc__)
    parser.add_argument("files", type=Path, nargs="+", metavar="FILE", help="of `python -m docs.studies.batch_gpu`")
    parser.add_argument("--out", required=True, metavar="DIR", help="write gpu.md, its figure and its findings")
    asked = parser.parse_args()
    found = merge([json.loads(file.read_text(encoding="utf-8")) for file in asked.files])
    folder, command = folder_to_write(asked.out, "--out"), Reproduction("python -m docs.studies.batch_gpu")
    write_together([report_batch(BATCH_GPU_REPORT, {"gpu": found}, folder, command)])


if __name__ == "__main__":
    run_guarded(main)
