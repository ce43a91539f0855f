"""`conrod explain`: each word that conrod prints has a meaning, and what goes wrong has an advice."""

from __future__ import annotations

import json
import zipfile
from functools import cache
from pathlib import Path

import pytest
from click.testing import CliRunner

import conrod
from conrod.cli import cli
from conrod.comparison.trajectory import COMPARED_QUANTITIES, Outcome
from conrod.engines import engine_names, presets_of
from conrod.errors import InvalidInput
from conrod.guide.explain import sources
from conrod.guide.explain.sources import WordMeaning, explanations, glossary_terms
from conrod.models.lint.linting import RULES
from conrod.studies.ablate.findings import IngredientVerdict
from conrod.studies.limits.axes import AXES


@cache
def known() -> tuple[WordMeaning, ...]:
    return tuple(explanations())


def test_explain_knows_what_results_and_tables_print() -> None:
    words = {one.word for one in known()}
    presets = {preset for engine in engine_names() for preset in presets_of(engine)}
    printed = {*(one.slug for one in Outcome), *presets, *RULES, *COMPARED_QUANTITIES, *AXES}
    printed |= {one.value for one in IngredientVerdict} | {"strays", "its own run", "as it is"}
    assert printed | {"within tolerance", "out of tolerance", "measured", "cannot be trusted"} <= words
    assert all(one.advice for one in known() if one.kind == "outcome of a run")
    assert all(one.meaning for one in known())


def test_explain_fails_when_an_outcome_has_no_advice() -> None:
    with pytest.raises(KeyError, match="completed"):
        list(sources._outcomes({}))


def test_explain_points_to_pages_and_headings_that_exist() -> None:
    docs = Path(__file__).parents[2] / "docs"
    for one in known():
        page, _, heading = one.page.partition("#")
        text = (docs / page).read_text("utf-8")
        lines = [line.lstrip("# ").lower().rstrip("?") for line in text.splitlines()]
        anchors = [line.replace(",", "").replace("`", "").replace("-", " ") for line in lines]
        assert not heading or heading.replace("-", " ") in anchors, one.page


def test_explain_knows_ingredients_of_all_committed_ablations() -> None:
    studies = json.loads((Path(__file__).parents[2] / "reports" / "ablate" / "results.json").read_text("utf-8"))
    words = {(one.kind, one.word) for one in known()}
    named = {
        (f"ingredient of {engine}", name)
        for part in studies["parts"].values()
        for engine, verdicts in part["summary"]["verdicts"].items()
        for name in verdicts
    }
    assert len(named) > 25
    assert named <= words
    # Negative control: an ingredient of the other engine.
    assert ("ingredient of pymunk", "fwdinv") not in words


def test_column_of_the_ledger_is_explained_by_its_parts() -> None:
    assert [one.word for one in conrod.explain("position_max")] == ["position", "max"]
    with pytest.raises(InvalidInput, match="unknown word 'position_mux'"):
        conrod.explain("position_mux")


def test_glossary_gives_each_heading_and_emphasised_word() -> None:
    text = "## Part\n\n### Order, rate\nHow [an error](design.md#x) falls; at its\n*floor* no more.\n\n### Next\nB.\n"
    found = {one.word: (one.meaning, one.page) for one in glossary_terms(text)}
    order = ("How an error falls; at its floor no more.", "design.md#x")
    assert found == {"order": order, "rate": order, "floor": order, "next": ("B.", "glossary.md")}


def test_explain_finds_a_word_in_any_case_and_number() -> None:
    assert conrod.explain("Lost contact")[0].word == "lost-contact"
    assert [one.kind for one in conrod.explain("STOCK")][:2] == ["preset of mujoco", "preset of pymunk"]
    assert conrod.explain("outcomes")[0].word == "outcome"
    with pytest.raises(InvalidInput, match=r"unknown word 'opned': did you mean 'opened'"):
        conrod.explain("opned")


def test_explain_prints_what_to_do_and_writes_json(tmp_path: Path) -> None:
    said = CliRunner().invoke(cli, ["explain", "out", "of", "tolerance", "--json", str(tmp_path / "x.json")])
    assert said.exit_code == 0
    assert "what to do: " in said.output
    assert "docs/validation.md" in said.output
    (written,) = json.loads((tmp_path / "x.json").read_text("utf-8"))
    assert written["kind"] == "verdict"
    assert written["advice"]
    listed = CliRunner().invoke(cli, ["explain"])
    assert listed.exit_code == 0
    assert "soft-closure" in listed.output
    assert "lost-contact" in listed.output


@pytest.mark.slow  # builds a wheel
def test_explain_finds_the_glossary_in_a_wheel(tmp_path: Path) -> None:
    import subprocess
    import sys

    root = Path(__file__).parents[2]
    subprocess.run(
        [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(tmp_path), str(root)],
        check=True,
        capture_output=True,
    )
    (wheel,) = tmp_path.glob("*.whl")
    packed = zipfile.ZipFile(wheel).read("conrod/guide/explain/glossary.md")
    assert packed == (root / "docs" / "glossary.md").read_bytes()
