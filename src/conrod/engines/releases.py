"""Releases of an engine: versions, how to install each, and the relevant entries of its changelog."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from importlib.resources import files
from typing import Any

import msgspec

from conrod.comparison.trajectory import Settings
from conrod.engines.engine import Machine
from conrod.errors import InvalidInput

VERSION_PATTERN = re.compile(r"\d+(\.\d+)+((a|b|rc|\.post|\.dev)\d+)?")


def version_numbers(version: str) -> tuple[int, ...]:
    """The numbers of a version, as a key to sort versions by."""
    return tuple(int(digits) for digits in re.findall(r"\d+", version))


@dataclass(frozen=True)
class ChangelogEntry:
    """A statement of the engine's changelog on one release, in conrod's words.

    Attributes:
        version: the release.
        words: what the release changed.
        settings: values of settings' fields for which the entry matters; empty if it matters for all.
        contact: whether the entry concerns machines with a cam (True) or without one (False); None if both.
        rounding: whether the change can affect only last bits.
    """

    version: str
    words: str
    settings: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    contact: bool | None = None
    rounding: bool = False

    def can_affect(self, machine: Machine, settings: Settings) -> bool:
        """Return True if the entry can matter to a run of a machine with these settings."""
        return self.concerns(bool(machine.kinematics.mechanism.cam_contacts), settings.as_dict())

    def concerns(self, contact: bool, given: Mapping[str, Any]) -> bool:
        """Return True if the entry can matter to a run with these settings by name, with contacts or without."""
        fields = all(
            not set(values).isdisjoint(one if isinstance(one := given.get(name), list) else [one])
            for name, values in self.settings.items()
        )
        return fields and self.contact in (None, contact)


@dataclass(frozen=True)
class Releases:
    """The releases of an engine that conrod works with.

    Attributes:
        source: address of the engine's own changelog.
        distributions: name of the distribution to install, by the first version under that name.
        versions: known versions, the oldest first; later ones may exist.
        facts: entries of the changelog that can matter to a machine that conrod runs.
    """

    source: str
    distributions: Mapping[str, str]
    versions: tuple[str, ...]
    facts: tuple[ChangelogEntry, ...] = ()

    def requirement(self, version: str) -> str:
        """The pip requirement that installs a version."""
        names = [d for first, d in self.distributions.items() if version_numbers(first) <= version_numbers(version)]
        return f"{names[-1]}=={version}"

    def select_versions(self, text: str | None) -> tuple[str, ...]:
        """Parse a comma-separated list of versions; all known versions without one. Oldest first.

        Raises:
            InvalidInput: a text is no version, or older than all that conrod works with.
        """
        if text is None:
            return self.versions
        named = [word.strip() for word in text.split(",")]
        for word in named:
            if not VERSION_PATTERN.fullmatch(word):
                raise InvalidInput(f"--versions: {word!r} is no version; give some with commas, such as 3.6.0,3.7.0")
            if version_numbers(word) < version_numbers(self.versions[0]):
                raise InvalidInput(f"--versions: {word} is older than {self.versions[0]}, the first that conrod runs")
        return tuple(sorted(dict.fromkeys(named), key=version_numbers))

    def matching_entries(self, version: str, machine: Machine, settings: Settings, rounding: bool) -> tuple[str, ...]:
        """Changelog entries of a version that can affect a run; without `rounding`, only by more than last digits."""
        return tuple(
            fact.words
            for fact in self.facts
            if fact.version == version and (rounding or not fact.rounding) and fact.can_affect(machine, settings)
        )


@cache
def read_releases(package: str) -> Releases:
    """Read the releases from the file `releases.toml` of an engine's package."""
    text = files(package).joinpath("releases.toml").read_text(encoding="utf-8")
    return msgspec.convert(tomllib.loads(text), Releases)
