"""Settings of many runs as lines to paste, kept small: the texts that runs share, and the numbers of each in them."""

from __future__ import annotations

import re
from collections.abc import Sequence
from itertools import chain, zip_longest
from typing import Any

from conrod.engines import Engine
from conrod.engines.capabilities import Lacking, Pasted, capability
from conrod.runs.trajectory import Settings
from conrod.scenes import Scene

NUMBER = re.compile(r"(?<![\w.])-?\d[\d.]*(?:e[-+]?\d+)?")
Text = tuple[str, ...]  # what stands between the numbers


def paste_of(engine: Engine[Any], scene: Scene, settings: Settings) -> str:
    """Settings as lines for a model or a program; the reason where the engine gives none."""
    can = capability(engine, Pasted)
    return f"# {can.reason}" if isinstance(can, Lacking) else can.paste(scene, settings)


def shared(pastes: Sequence[str]) -> tuple[tuple[Text, ...], list[tuple[int, Text]]]:
    """The texts that occur, and of each paste the number of its text with the numbers that others have otherwise."""
    split = [(tuple(NUMBER.split(paste)), tuple(NUMBER.findall(paste))) for paste in pastes]
    alike: dict[Text, list[Text]] = {}
    for text, values in split:
        alike.setdefault(text, []).append(values)
    varied = {text: [len(set(column)) > 1 for column in zip(*rows, strict=True)] for text, rows in alike.items()}
    order = list(varied)
    texts = []
    for text, rows in alike.items():
        pieces = [text[0]]
        for value, other, after in zip(rows[0], varied[text], text[1:], strict=True):
            if other:
                pieces.append(after)
            else:
                pieces[-1] += value + after
        texts.append(tuple(pieces))
    given = [
        (order.index(text), tuple(v for v, other in zip(row, varied[text], strict=True) if other))
        for text, row in split
    ]
    return tuple(texts), given


def filled(text: Text, values: Text) -> str:
    """A text with its numbers."""
    return "".join(chain.from_iterable(zip_longest(text, values, fillvalue="")))
