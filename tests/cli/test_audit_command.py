"""`conrod audit` as a user calls it."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest
from click.testing import CliRunner, Result

from conrod.cli import cli
from conrod.errors import InvalidInput
from conrod.own.printed.table import audit_file
from conrod.scenes import catalogue_text

ROOT = Path(__file__).parents[2]
HEADING = "scene,quantity,angle_deg,printed,unit\n"
GOOD = "shear-press,G velocity y,10,-33.3,mm/s\n"


def run(*arguments: str) -> Result:
    return CliRunner().invoke(cli, ["audit", *arguments])


def refusal(*arguments: str) -> str:
    result = run(*arguments)
    assert isinstance(result.exception, InvalidInput)
    assert "\n" not in str(result.exception)
    return str(result.exception)


def written(folder: Path, text: str, name: str = "values.csv") -> str:
    path = folder / name
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.fixture
def here(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_example_of_the_documentation_gives_what_it_says(here: Path) -> None:
    text = (ROOT / "docs" / "audit.md").read_text(encoding="utf-8")
    table = re.findall(r"```csv\n(.*?)```", text, re.DOTALL)[0]
    told = re.findall(r"```text\n(.*?)```", text, re.DOTALL)[0]
    written(here, table, "velocities.csv")
    result = run("velocities.csv")
    assert (result.exit_code, result.output) == (0, told)
    # Negative control: with the digits put right nothing is told.
    written(here, table.replace("-146.1", "-164.1"), "velocities.csv")
    assert "should be" not in run("velocities.csv").output


def test_a_users_report_has_a_page_and_its_numbers(here: Path) -> None:
    written(here, HEADING + GOOD + GOOD.replace("-33.3", "-33.4"), "My table.csv")
    result = run("My table.csv", "--out", "found")
    assert result.exit_code == 0
    assert result.output.endswith("report: found/my-table.md\n")
    names = sorted(path.name for path in (here / "found").iterdir())
    assert names == ["README.md", "data", "my-table.md", "results.json"]
    entry = json.loads((here / "found" / "results.json").read_text(encoding="utf-8"))["parts"]["my-table"]
    assert entry["command"] == "conrod audit 'My table.csv' --out found"
    findings = json.loads((here / "found" / entry["data"]).read_text(encoding="utf-8"))
    assert [item["kind"] for item in findings["verdicts"]] == ["agrees", "not reproducible as printed"]
    # Pages of other files stay, and all are rendered again from what was saved.
    page = (here / "found" / "my-table.md").read_text(encoding="utf-8")
    written(here, HEADING + GOOD, "other.csv")
    assert run("other.csv", "--out", "found").exit_code == 0
    assert CliRunner().invoke(cli, ["report", "found", "--out", "again"]).exit_code == 0
    assert (here / "again" / "my-table.md").read_text(encoding="utf-8") == page


def test_a_table_is_tied_to_a_mechanism_file_beside_it(here: Path) -> None:
    (here / "mine.toml").write_text(catalogue_text("slider-crank"), encoding="utf-8")
    row = "mine.toml,B position x,0,860.0,mm\n"
    assert "1" in run(written(here, HEADING + row)).output.splitlines()[2].split()
    own = audit_file(here / "values.csv").verdicts
    written(here, HEADING + row.replace("mine.toml", "slider-crank"), "shipped.csv")
    shipped = audit_file(here / "shipped.csv").verdicts
    assert [(v.exact, v.kind) for v in own] == [(v.exact, v.kind) for v in shipped]


@pytest.mark.parametrize("name", ["sub/../../mine.toml", "link.toml"])
def test_a_mechanism_file_outside_the_tables_folder_is_refused(here: Path, name: str) -> None:
    (here / "mine.toml").write_text(catalogue_text("slider-crank"), encoding="utf-8")
    table = written(here / "tables", HEADING + f"{name.format(here=here)},B position x,0,860.0,mm\n")
    (here / "tables" / "link.toml").symlink_to(here / "mine.toml")
    assert "leads out of the folder of the table" in refusal(table)


@pytest.mark.parametrize(("row", "message"), [
    (GOOD.replace("shear-press", "shear-pres"), "values.csv: row 2: unknown scene .*did you mean 'shear-press'"),
    (GOOD.replace("-33.3", "9" * 400), "values.csv: row 2: printed value '9999"),
    (GOOD + GOOD.replace(",10,", ",ten,"), "values.csv: row 3: angle_deg = 'ten'"),
    ("missing.toml,G velocity y,0,1.0,mm/s\n", r"values.csv: row 2: .*missing.toml: there is no such file"),
    ("swinging-four-bar,B velocity x,170,1.0,m/s\n", "row 2: angle_deg = 170: swinging-four-bar is driven from"),
])  # fmt: skip
def test_an_error_in_a_file_is_one_line_that_names_file_row_and_field(here: Path, row: str, message: str) -> None:
    assert re.search(message, refusal(written(here, HEADING + row)))


def test_files_that_are_no_tables_are_refused(here: Path) -> None:
    assert "there is no such file" in refusal("missing.csv")
    assert "it is a folder, not a file" in refusal(str(here))
    (here / "bytes.csv").write_bytes(b"\xff\xfe\x00")
    assert "no text in UTF-8" in refusal("bytes.csv")
    assert "is taken" in refusal(written(here, HEADING + GOOD), written(here / "again", HEADING + GOOD))
    written(here, HEADING + GOOD, "README.csv")
    assert "is taken" in refusal("README.csv")
