"""`conrod explain`."""

from __future__ import annotations

import click
from click.shell_completion import CompletionItem

from conrod.cli import options


def _words(context: click.Context, parameter: click.Parameter, typed: str) -> list[CompletionItem]:
    from conrod.cli.completion import matching_names
    from conrod.guide.explain.sources import words_to_complete

    before = "".join(f"{word} " for word in context.params.get("words") or ())  # of a term of several words
    words = (word.removeprefix(before) for word in words_to_complete() if word.startswith(before))
    return matching_names(words, typed)


@options.verb()
@click.argument("words", nargs=-1, metavar="[WORD...]", shell_complete=_words)
@options.document
def explain(words: tuple[str, ...], document: str | None) -> None:
    """Explain a WORD that conrod prints: an outcome, verdict, preset, rule, ingredient, axis, quantity, column or
    term.

    Without a WORD all that can be explained are listed.
    """
    from conrod.comparison.plain_values import json_document
    from conrod.execution.files import files_to_write
    from conrod.execution.writing import single_file, write_together
    from conrod.guide.explain import api
    from conrod.guide.explain.sources import as_plain_values, explanations
    from conrod.report.table import table
    from conrod.report.terminal import print_parts

    files = files_to_write({"--json": document})
    if words:
        found = api.explain(" ".join(words))
        for one in found:
            print_parts([f"{one.word} ({one.kind}): {one.meaning}"])
            print_parts([f"  what to do: {one.advice}"] if one.advice else [])
            print_parts([f"  more: docs/{one.page}"] if one.page else [])
    else:
        found = tuple(explanations())
        by_kind: dict[str, list[str]] = {}
        for one in found:
            by_kind.setdefault(one.kind, []).append(one.word)
        print_parts([table(("kind", "words"), [(kind, ", ".join(names)) for kind, names in by_kind.items()])])
    if "--json" in files:
        text = json_document([as_plain_values(one) for one in found])
        write_together([single_file(files["--json"], text)])
