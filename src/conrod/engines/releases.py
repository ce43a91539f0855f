"""Releases of an engine: their versions, how each is installed, and what its own changelog says of them."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

import msgspec

from conrod.engines.engine import Machine
from conrod.errors import InvalidInput
from conrod.runs.trajectory import Settings

VERSION = re.compile(r"\d+(\.\d+)+((a|b|rc|\.post|\.dev)\d+)?")


def numbers_of(version: str) -> tuple[int, ...]:
    """The numbers of a version, by which versions are ordered."""
    return tuple(int(digits) for digits in re.findall(r"\d+", version))


@dataclass(frozen=True)
class Fact:
    """A statement of an engine's own changelog on a release, in our words.

    Attributes:
        version: the release.
        words: what it changed.
        settings: fields of settings with the values for which it matters; all settings where it is empty.
        contact: whether it is of machines with a cam (True) or without one (False); None of both.
        rounding: whether it can change last bits alone.
    """

    version: str
    words: str
    settings: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    contact: bool | None = None
    rounding: bool = False

    def touches(self, machine: Machine, settings: Settings) -> bool:
        """True if it matters to a run of a machine with some settings."""
        contact, given = bool(machine.kinematics.mechanism.cam_contacts), settings.as_dict()
        fields = all(
            not set(values).isdisjoint(one if isinstance(one := given.get(name), list) else [one])
            for name, values in self.settings.items()
        )
        return fields and self.contact in (None, contact)


@dataclass(frozen=True)
class Releases:
    """Releases of an engine that conrod works with.

    Attributes:
        source: where the engine's own changelog is.
        distributions: what is installed, by the first version of which that holds.
        versions: that are known, the oldest first; later ones may be there.
        facts: of the changelog, as far as they can matter to a machine that conrod runs.
    """

    source: str
    distributions: Mapping[str, str]
    versions: tuple[str, ...]
    facts: tuple[Fact, ...] = ()

    def requirement(self, version: str) -> str:
        """Requirement, as pip has it, for a version."""
        names = [d for first, d in self.distributions.items() if numbers_of(first) <= numbers_of(version)]
        return f"{names[-1]}=={version}"

    def chosen(self, text: str | None) -> tuple[str, ...]:
        """Versions of a list with commas, all that are known where there is none; the oldest first.

        Raises:
            InvalidInput: what is no version, or older than all that conrod works with.
        """
        if text is None:
            return self.versions
        named = [word.strip() for word in text.split(",")]
        for word in named:
            if not VERSION.fullmatch(word):
                raise InvalidInput(f"--versions: {word!r} is no version; give some with commas, such as 3.6.0,3.7.0")
            if numbers_of(word) < numbers_of(self.versions[0]):
                raise InvalidInput(f"--versions: {word} is older than {self.versions[0]}, the first that conrod runs")
        return tuple(sorted(dict.fromkeys(named), key=numbers_of))

    def named(self, version: str, machine: Machine, settings: Settings, rounding: bool) -> tuple[str, ...]:
        """Changelog entries of a release that can have changed a run, by last bits alone or by more."""
        return tuple(
            fact.words
            for fact in self.facts
            if fact.version == version and (rounding or not fact.rounding) and fact.touches(machine, settings)
        )


@cache
def read_releases(package: str) -> Releases:
    """The releases that stand in the file `releases.toml` of an engine's package."""
    text = files(package).joinpath("releases.toml").read_text(encoding="utf-8")
    return msgspec.convert(tomllib.loads(text), Releases)
