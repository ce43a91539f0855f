"""What `conrod lint` prints."""

from __future__ import annotations

from pathlib import Path

from rich.console import Console

from conrod.console import console
from conrod.engines.mujoco.lint.finding import Finding, Fixed, Harm, Report, Value
from conrod.paired_timing import PairedCost

COLOURS = {Harm.WRONG: "red", Harm.LATENT: "yellow", Harm.WASTE: "cyan"}


def print_report(report: Report, out_file: Path | None) -> None:
    """A block for each finding, the most harmful first, then what is good to know."""
    out = console()
    out.print(f"{report.model}: {report.run}", markup=False, soft_wrap=True)
    for finding in report.findings:
        _print_finding(out, finding)
    if report.notes:
        out.print("\nnoted, no findings:")
    for note in report.notes:
        cost = "" if note.cost is None else f"; {_cost(note.cost)}"
        out.print(f"  {note.rule}: {note.what}{cost}", markup=False, soft_wrap=True)
    number = len(report.findings)
    out.print(f"\n{number or 'no'} finding{'' if number == 1 else 's'}")
    if report.fixed is not None:
        _print_fixed(out, report.fixed, out_file)


def _print_finding(out: Console, finding: Finding) -> None:
    out.print(f"\n[{COLOURS[finding.harm]}]{finding.rule}[/] ({finding.harm.meaning})", soft_wrap=True)
    lines = [finding.what, "evidence: " + "; ".join(f"{name} {_value(value)}" for name, value in finding.evidence)]
    if finding.cost is not None:
        lines.append(f"cost: {_cost(finding.cost)}")
    lines += [f"why: {finding.why}", f"fix: {finding.fix}"]
    lines += [f"     {edit.told}" for edit in finding.edits]
    if finding.edits:
        lines.append("safe: --fix makes it" if finding.safe else "not made by --fix: say yourself which was meant")
    for line in lines:
        out.print(f"  {line}", markup=False, soft_wrap=True)


def _print_fixed(out: Console, fixed: Fixed, file: Path | None) -> None:
    if not fixed.text:
        out.print(f"nothing can be fixed safely; {file} is not written", markup=False, soft_wrap=True)
        return
    number = len(fixed.edits)
    moved = "did not change" if fixed.change == 0.0 else f"changed by {_value(fixed.change)} of its travel"
    cost = "" if fixed.cost is None else f"; the original takes {_cost(fixed.cost)} of it"
    out.print(
        f"{file}: {number} edit{'' if number == 1 else 's'}; the motion {moved}{cost}", markup=False, soft_wrap=True
    )


def _cost(cost: PairedCost) -> str:
    seen = "" if not cost.low <= 1.0 <= cost.high else ", no difference seen"
    return f"{cost.ratio:.2f} x a step ({cost.low:.2f} to {cost.high:.2f}{seen})"


def _value(value: Value) -> str:
    if isinstance(value, float):
        return "beyond all bounds" if value >= 1e300 else f"{value:.4g}"
    return str(value)
