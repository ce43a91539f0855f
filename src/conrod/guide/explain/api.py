"""Explain a word that conrod prints or asks for."""

from __future__ import annotations

import re

from conrod.errors import unknown_choice
from conrod.guide.explain.sources import WordMeaning, explanations

STATISTIC = re.compile(r"(position|velocity|acceleration|total|phase|drive|closure)_(\w+)")


def explain(word: str) -> tuple[WordMeaning, ...]:
    """Explain an outcome, verdict, preset, rule of lint, ingredient, axis, quantity, column or term.

    Args:
        word: as conrod prints it, in any case; of several meanings all are returned.

    Raises:
        InvalidInput: the word is none of conrod's; names the nearest.
    """
    wanted = _normalise_word(word)
    known = tuple(explanations())
    found = tuple(one for one in known if _normalise_word(one.word) == wanted)
    if not found and (column := STATISTIC.fullmatch(word.strip())):
        # A column of the ledger, such as position_max.
        parts = [[one for one in known if _normalise_word(one.word) == part] for part in column.groups()]
        found = tuple(one for meanings in parts for one in meanings) if all(parts) else ()
    if not found:
        raise unknown_choice("word", word, dict.fromkeys(one.word for one in known), "conrod explain")
    return found


def _normalise_word(word: str) -> str:
    """Return a word without case, hyphens, underscores and a plural's s, by which it is looked up."""
    plain = " ".join(word.lower().replace("-", " ").replace("_", " ").split())
    return plain.removesuffix("s") if len(plain) > 3 else plain
