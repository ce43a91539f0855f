"""Where the meanings of words come from: the glossary, the code's own texts, and `words.toml`."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path
from typing import Any

import conrod
from conrod.slices import has_slice

PACKAGE = "conrod.guide.explain"
# Tables of words.toml that have a page for each word, with what their words are.
KINDS = {"verdict": "verdict", "row": "row of `conrod check`", "quantity": "error that is compared"}
EXAMPLES = ("saw-500rpm", "cam-follower")  # machines that between them have all ingredients


@dataclass(frozen=True)
class WordMeaning:
    """Meaning of a word that conrod prints or accepts.

    Attributes:
        kind: what the word names, such as "outcome of a run" or "preset of mujoco".
        advice: what to do where a user meets it; empty if nothing needs to be done.
        page: where docs/ says more, such as "validation.md#outcomes"; empty if nowhere.
    """

    word: str
    kind: str
    meaning: str
    advice: str = ""
    page: str = ""


def explanations() -> Iterator[WordMeaning]:
    """Yield the meanings of all words: words of results first, then the glossary's terms."""
    words = tomllib.loads(files(PACKAGE).joinpath("words.toml").read_text("utf-8"))
    yield from _outcomes(words["outcome"])
    for kind, title in KINDS.items():
        for word, entry in words[kind].items():
            yield WordMeaning(word, title, entry["means"], entry.get("advice", ""), entry["page"])
    yield from _presets()
    yield from _lint_rules()
    yield from _ingredients()
    yield from _axes()
    for word, meaning in words["column"].items():
        yield WordMeaning(word, "column of `conrod results`", meaning, page="running.md")
    yield from glossary_terms(glossary_text())


def words_to_complete() -> dict[str, None]:
    """Words that can be explained, but for presets of engines whose libraries take seconds to load."""
    from conrod.comparison.trajectory import Outcome
    from conrod.engines import engine_names, presets_of

    kinds = tomllib.loads(files(PACKAGE).joinpath("words.toml").read_text("utf-8"))
    presets = (preset for engine in engine_names() for preset in presets_of(engine))
    named = (*(outcome.slug for outcome in Outcome), *(word for kind in KINDS for word in kinds[kind]), *presets)
    terms = (one.word for one in (*_lint_rules(), *_ingredients(), *_axes(), *glossary_terms(glossary_text())))
    return dict.fromkeys((*named, *kinds["column"], *terms))


def _outcomes(advice: dict[str, str]) -> Iterator[WordMeaning]:
    from conrod.comparison.trajectory import Outcome

    for outcome in Outcome:
        yield WordMeaning(
            outcome.slug, "outcome of a run", outcome.meaning, advice[outcome.slug], "validation.md#outcomes"
        )


def _presets() -> Iterator[WordMeaning]:
    from conrod.engines import engine_names, installed_extras, presets_of

    for engine in (*engine_names(), *installed_extras()):
        for name, preset in presets_of(engine).items():
            judged = (
                "judged by the engine's error law" if preset.judged else "measured, not judged, without --tolerance"
            )
            yield WordMeaning(name, f"preset of {engine}", f"{preset.meaning}; {judged}", page="validation.md#presets")


def _lint_rules() -> Iterator[WordMeaning]:
    if not has_slice("models.lint"):
        return
    from conrod.models.lint.linting import RULES

    for name, rule in RULES.items():
        meaning = " ".join((rule.__doc__ or "").split())
        advice = f"A finding gives its own fix; `--ignore {name}` leaves the rule out."
        yield WordMeaning(name, "rule of `conrod lint`", meaning, advice, "lint.md#rules")


def _ingredients() -> Iterator[WordMeaning]:
    if not has_slice("studies.ablate"):
        return
    from conrod.engines import loadable_engines
    from conrod.engines.capabilities import ModelIngredients
    from conrod.engines.engine import default_steps
    from conrod.scenes import SCENES

    for engine in loadable_engines()[0]:
        if not isinstance(engine, ModelIngredients):
            continue
        found: dict[str, str] = {}
        for machine in (SCENES[name] for name in EXAMPLES):
            minimal = engine.minimal_settings(machine, default_steps(machine))
            found = {one.name: one.meaning for one in engine.ingredients(machine, minimal)} | found
        for name, meaning in found.items():
            yield WordMeaning(name, f"ingredient of {engine.name}", meaning, page="ablate.md")


def _axes() -> Iterator[WordMeaning]:
    if not has_slice("studies.limits"):
        return
    from conrod.studies.limits.axes import AXES

    for axis in AXES.values():
        label = "" if axis.label.lower() == axis.title.lower() else f" ({axis.label})"
        meaning = f"{axis.title}{label}: varied by `conrod limits` until the engine fails."
        yield WordMeaning(axis.name, "axis of `conrod limits`", meaning, page="limits.md#the-axes")


# -- glossary ----------------------------------------------------------------------------------------------------------


def glossary_text() -> str:
    """Read the glossary: from the installed package, or else from docs/ of the checkout."""
    beside = files(PACKAGE).joinpath("glossary.md")
    if beside.is_file():
        return beside.read_text("utf-8")
    return Path(conrod.__file__).parents[2].joinpath("docs", "glossary.md").read_text("utf-8")


def glossary_terms(text: str) -> Iterator[WordMeaning]:
    """Yield the terms of a Markdown glossary: in headings `### Term, synonym`, and *in italics* below."""
    for heading, body in re.findall(r"^### (.+?)\n(.+?)(?=^##|\Z)", text, re.DOTALL | re.MULTILINE):
        meaning = _plain_text(body)
        links = re.findall(r"\]\(([a-z-]+\.md[^)]*)\)", body)
        explained = [*heading.split(", "), *re.findall(r"(?<![\w*])\*([^*]+)\*(?![\w*])", " ".join(body.split()))]
        for word in dict.fromkeys(word.lower() for word in explained):
            yield WordMeaning(word, "term", meaning, page=links[-1] if links else "glossary.md")


def _plain_text(markdown: str) -> str:
    """Return a paragraph of Markdown as one line, without links, emphasis, and sentences that only point elsewhere."""
    line = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", " ".join(markdown.split()))
    return re.sub(r"(?<![\w*])\*([^*]+)\*(?![\w*])", r"\1", line).strip()


def as_plain_values(one: WordMeaning) -> dict[str, Any]:
    """Return an explanation as plain values for JSON, without its empty fields."""
    return {name: value for name, value in vars(one).items() if value}
