"""A command line of before is answered in one line with the new one, which runs; and help fits on a screen."""

from __future__ import annotations

import shlex
from pathlib import Path
from subprocess import CompletedProcess

import click
import pytest
from command_line import conrod, refusal
from four_bars import four_bar
from table_files import csv_text, exact_table

from conrod.cli import VERBS, cli
from conrod.cli.moved import VERB_OF_OPTION, new_spelling
from conrod.cli.options import OUTPUT, RUNS
from conrod.scenes import SCENES

MODEL = Path(__file__).parents[2] / "mjcf" / "saw-500rpm.xml"
QUICK = "--engine pymunk --preset tuned --steps-per-rev 60 --revolutions 1"
ON_MODEL = "--crank crank --point C=site:C --revolutions 1"
# Each row of the table of commands that moved: what was typed, and what is to be typed now.
MOVED = {
    "validate bar.xml --drive crank=60rpm --seconds 0.05": "check bar.xml --drive crank=60rpm --seconds 0.05",
    "validate --drive=crank=60rpm --seconds=0.05 bar.xml": "check --drive crank=60rpm --seconds 0.05 bar.xml",
    f"validate saw.xml --scene saw-500rpm {ON_MODEL}": f"check saw.xml --scene saw-500rpm {ON_MODEL}",
    f"validate --scene=saw-500rpm saw.xml {ON_MODEL}": f"check --scene saw-500rpm saw.xml {ON_MODEL}",
    "validate t.csv --scene saw-500rpm": "check t.csv --scene saw-500rpm",
    "validate T.CSV --scene saw-500rpm --estimate time": "check T.CSV --scene saw-500rpm --estimate time",
    "validate t.csv --scene saw-500rpm --report r.html": "check t.csv --scene saw-500rpm --verification r.html",
    "validate pendulum --motion free --engine pymunk --seconds 0.02 --preset tuned":
        "free pendulum --engine pymunk --seconds 0.02 --preset tuned",
    "validate --motion=free pendulum --step=1ms --seconds 0.02 --engine pymunk --preset tuned":
        "free pendulum --step 1ms --seconds 0.02 --engine pymunk --preset tuned",
    "validate press-cutting --motion torque --seconds 0.02 --engine pymunk --preset tuned":
        "free press-cutting --torque --seconds 0.02 --engine pymunk --preset tuned",
    "validate press-cutting --motion=torque --seconds=0.02 --engine=pymunk --preset=tuned":
        "free press-cutting --torque --seconds 0.02 --engine pymunk --preset tuned",
    f"validate saw-40rpm --quantity torque {QUICK}": f"forces saw-40rpm --quantity torque {QUICK}",
    f"validate --quantity=torque,reactions saw-40rpm {QUICK}": f"forces --quantity torque,reactions saw-40rpm {QUICK}",
    "validate saw.xml --invariances --seconds 0.01": "invariances saw.xml --seconds 0.01",
    "validate --invariances saw-40rpm --seconds 0.01": "invariances saw-40rpm --seconds 0.01",
    f"validate saw-40rpm {QUICK} --report r.html": f"validate saw-40rpm {QUICK} --verification r.html",
    f"validate saw-40rpm {QUICK} --report=r.html": f"validate saw-40rpm {QUICK} --verification r.html",
    "check t.csv --scene saw-500rpm --report r.html": "check t.csv --scene saw-500rpm --verification r.html",
    "validate bennett --drive hinge=60rpm": None,
}  # fmt: skip


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with what the commands read."""
    tmp_path = tmp_path_factory.mktemp("moved")
    (tmp_path / "bar.xml").write_text(four_bar())
    (tmp_path / "saw.xml").write_text(MODEL.read_text())
    for name in ("t.csv", "T.CSV"):
        (tmp_path / name).write_text(csv_text(exact_table(SCENES["saw-500rpm"])))
    return tmp_path


@pytest.fixture(scope="module")
def ran() -> dict[str, CompletedProcess[str]]:
    """Commands of now that have been run, each once, and how each ended."""
    return {}


@pytest.mark.usefixtures("at_once", "undrawn")
@pytest.mark.parametrize("before", MOVED)
def test_a_moved_command_is_answered_with_one_that_runs(
    before: str, folder: Path, ran: dict[str, CompletedProcess[str]], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("conrod.execution.paired_timing.BLOCK_TIME", 2e-5)
    kept = sorted(folder.iterdir())
    line = refusal(*shlex.split(before), cwd=folder, ledger=folder / "ledger.sqlite")
    assert sorted(folder.iterdir()) == kept
    typed, now = line.removeprefix("conrod: ").split(" is now ")
    assert typed == f"`conrod {before}`"
    (program, *words) = shlex.split(now.strip("`"))
    assert program == "conrod"
    if (expected := MOVED[before]) is not None:
        assert words == expected.split()
        if expected not in ran:  # as another old spelling is answered with it
            ran[expected] = conrod(*words, cwd=folder, ledger=folder / "ledger.sqlite")
        assert ran[expected].returncode in (0, 1), ran[expected].stderr
        assert ran[expected].stdout


def test_validate_of_an_fmu_is_answered_with_check(folder: Path) -> None:
    (folder / "x.fmu").write_bytes(b"")
    now = "`conrod check x.fmu --scene saw-500rpm --preset co-simulation`"
    assert refusal("validate", "x.fmu", *now.strip("`").split()[3:], cwd=folder).endswith(f" is now {now}")
    # It is the FMU that is wrong now, not the command.
    assert "x.fmu" in refusal(*now.strip("`").split()[1:], cwd=folder)


@pytest.mark.usefixtures("at_once", "undrawn")
def test_a_file_that_an_option_names_is_no_subject(folder: Path) -> None:
    # Negative controls: a command that is spelled as it is now runs, whatever its values are called.
    for target in (("--json", "found.xml"), ("--json=found.csv",), ("--out", "rep.csv"), ("--ledger", "l.dat")):
        done = conrod("validate", "saw-40rpm", *QUICK.split(), *target, cwd=folder, ledger=folder / "ledger.sqlite")
        assert done.returncode == 0, done.stderr
    assert (folder / "found.xml").read_text().startswith("<?xml")
    assert new_spelling(["validate", "saw-40rpm", "--json", "found.xml"]) is None
    assert new_spelling(["show", "saw-40rpm", "--quantity", "torque"]) is None
    assert new_spelling([]) is None


@pytest.mark.parametrize("option", [one for one in VERB_OF_OPTION if VERB_OF_OPTION[one] == "check"])
def test_an_option_of_files_is_not_moved_for_a_scene(option: str) -> None:
    line = refusal("validate", "saw-40rpm", option, "value")
    assert line == f"conrod: {option} does not go with a scene: it is for a file, in `conrod check`"


def test_unknown_option_is_answered_with_the_nearest() -> None:
    assert "did you mean" in refusal("validate", "saw-40rpm", "--step-per-rev", "60").lower()


# -- help --------------------------------------------------------------------------------------------------------------

WIDTH, LINES, MOST_OPTIONS = 80, 40, 14


def help_of(verb: str, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    monkeypatch.setenv("COLUMNS", str(WIDTH))
    command = cli.get_command(click.Context(cli), verb)
    assert command is not None
    context = click.Context(command, info_name=f"conrod {verb}", terminal_width=WIDTH)
    return command.get_help(context).splitlines()


@pytest.mark.parametrize("verb", VERBS)
def test_help_of_a_verb_fits_on_a_screen(verb: str, monkeypatch: pytest.MonkeyPatch) -> None:
    lines = help_of(verb, monkeypatch)
    assert len(lines) <= LINES, "\n".join(lines)
    assert max(map(len, lines)) <= WIDTH


@pytest.mark.parametrize("verb", VERBS)
def test_a_verb_has_few_options_of_its_own(verb: str) -> None:
    command = cli.get_command(click.Context(cli), verb)
    assert command is not None
    own = [
        one.name
        for one in command.params
        if isinstance(one, click.Option) and not one.hidden and getattr(one, "heading", "") not in (OUTPUT, RUNS)
    ]
    assert len(own) <= MOST_OPTIONS, own


@pytest.mark.parametrize("verb", VERBS)
def test_help_explains_each_option(verb: str, monkeypatch: pytest.MonkeyPatch) -> None:
    command = cli.get_command(click.Context(cli), verb)
    assert command is not None
    options = [one for one in command.params if isinstance(one, click.Option) and not one.hidden]
    assert [one.name for one in options if not one.help] == []
    text = " ".join(" ".join(help_of(verb, monkeypatch)).split())
    assert [one.name for one in options if " ".join(str(one.help).split()) not in text] == []
