"""`conrod lint`."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import click
from click.shell_completion import CompletionItem
from rich.text import Text

from conrod.cli import FAILED, completion, options, waiting
from conrod.cli.options import controls_in, option
from conrod.comparison.plain_values import json_document
from conrod.errors import InvalidInput, name_file_in_os_errors
from conrod.execution.files import files_to_write
from conrod.execution.writing import single_file, write_together
from conrod.models.lint.findings import Finding, FixedModel, Report, Severity, Value, sarif
from conrod.report.terminal import PrintedPart, print_parts
from conrod.system import real_path
from conrod.user_files import MODELS
from conrod.user_files.files import check_model_readable, protected_model_files

COLOURS = {Severity.ERROR: "red", Severity.NOTE: "cyan"}


def complete_rules(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    """Complete names of rules."""
    from conrod.models.lint.linting import RULES

    return completion.matching_names(RULES, typed)


@dataclass(frozen=True)
class LintOptions:
    """Options of `conrod lint`, as typed; None or empty where nothing was given."""

    keyframe: str | None = option("--keyframe")
    controls: tuple[str, ...] = option("--ctrl")
    unit: str | None = option("--unit", metavar="UNIT", help="Of the models' lengths: m, cm, mm or inch [m].")
    seconds: float | None = option("--seconds", type=float, metavar="T", help="Duration of the run [2000 steps].")
    ignored: tuple[str, ...] = option(
        "--ignore", multiple=True, metavar="RULE", help="Leave a rule out.", shell_complete=complete_rules
    )
    fail_on: str = option(
        "--fail-on",
        type=click.Choice([one.value for one in Severity]),
        default=Severity.ERROR.value,
        show_default=True,
        help="Exit status 1 for errors alone, or for notes too.",
    )
    form: str = option(
        "--format", type=click.Choice(["text", "sarif"]), default="text", help="For people, or a build server [text]."
    )
    document: str | None = option("--json")
    fixed: str | None = option("--fix", metavar="OUT.xml", help="Write the model with the safe fixes made.")


@options.verb(LintOptions)
@click.argument("models", nargs=-1, required=True, metavar="MODEL.xml...", shell_complete=completion.files_with(MODELS))
def lint(models: tuple[str, ...], asked: LintOptions) -> None:
    """List parts of MuJoCo models that their motion does not need, and parts that will cause trouble.

    A model is run from its first keyframe, and run again without each suspect; the file is only read.

    Findings are errors (they make this motion wrong) or notes.

    Exit status 0: no errors, or what --fail-on says; 1: some; 2: bad usage.
    """
    paths = [Path(model) for model in models]
    for path in paths:
        check_model_readable(path, "lint")
    if len(paths) > 1 and (asked.document or asked.fixed):
        option = "--fix" if asked.fixed else "--json"
        raise InvalidInput(f"{option}: it is of one model, and {len(paths)} are given: lint them one by one")
    files = files_to_write({"--json": asked.document, "--fix": asked.fixed}, protected_model_files(paths[0]))
    reports = [_lint_one(path, asked, files) for path in paths]
    if asked.form == "text":
        for report in reports:
            print_parts(report_to_print(report, files.get("--fix")))
    else:
        with name_file_in_os_errors("standard output"):
            click.echo(sarif(reports), nl=False)
    fixed = reports[0].fixed
    texts: dict[str, str | bytes] = {
        "--json": json_document(reports[0].document()),
        "--fix": fixed.text if fixed else "",
    }
    write_together([single_file(file, texts[option]) for option, file in files.items() if texts[option]])
    failing = (Severity.ERROR.value, asked.fail_on)
    if any(finding.severity.value in failing for report in reports for finding in report.findings):
        sys.exit(FAILED)


def _lint_one(path: Path, asked: LintOptions, files: Mapping[str, Path]) -> Report:
    """Lint a model as the options ask, and show that it is under way."""
    from conrod.execution.local import FILE_TIMEOUT
    from conrod.models.lint.api import lint

    with waiting(path, FILE_TIMEOUT):
        return lint(
            path,
            keyframe=asked.keyframe,
            controls=controls_in(asked.controls),
            seconds=asked.seconds,
            ignore=asked.ignored,
            fix_for=real_path(files["--fix"]).parent if "--fix" in files else None,
            unit=asked.unit,
        )


# -- printing --------------------------------------------------------------------------------------------------------


def report_to_print(report: Report, out_file: Path | None) -> Iterator[PrintedPart]:
    """A block for each finding, the most harmful first, then what else was judged otherwise."""
    yield f"{report.model}: {report.run}"
    for finding in report.findings:
        yield from _print_finding(finding)
    yield from ("", *report.notes, report.verdict)
    if report.fixed is not None:
        yield _fix_words(report.fixed, out_file)


def _print_finding(finding: Finding) -> Iterator[PrintedPart]:
    severity = finding.severity
    yield from ("", Text(f"{severity.value}: {finding.rule}", COLOURS[severity]))
    lines = [finding.what, "evidence: " + "; ".join(f"{name} {_value_text(v)}" for name, v in finding.evidence.items())]
    if finding.change is not None:
        lines.append(f"change of motion without it: {_value_text(finding.change)}")
    lines += [f"why: {finding.why}", f"fix: {finding.fix}"]
    lines += [f"     {edit}" for edit in finding.edits]
    if finding.edits:
        lines.append("safe: --fix makes it" if finding.safe else "not made by --fix: say yourself which was meant")
    yield from (f"  {line}" for line in lines)


def _fix_words(fixed: FixedModel, file: Path | None) -> str:
    if not fixed.text:
        return f"nothing can be fixed safely; {file} is not written"
    number = len(fixed.edits)
    moved = "did not change" if fixed.change == 0.0 else f"changed by {_value_text(fixed.change)} of its travel"
    return f"{file}: {number} edit{'' if number == 1 else 's'}; the motion {moved}"


def _value_text(value: Value) -> str:
    if isinstance(value, float):
        return "beyond all bounds" if value >= 1e300 else f"{value:.4g}"
    return str(value)
