"""Engines that other packages bring: spoken to through one door alone, in whatever process they are loaded.

A process that pursues studies loads none of them: it has a `BroughtEngine` whose calls go to a process of its own
(`conrod.studies.execution.hosting`). A worker, or a user's own program, loads the engine itself
(`conrod.engines.checked_engine`).
"""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from conrod.engines.door import EngineFault
from conrod.engines.engine import CUSTOM, PIECE, Engine, Machine, Preset, step_length
from conrod.engines.variants import Ingredient, Rule
from conrod.runs.trajectory import Piece, Settings


@dataclass(frozen=True)
class BroughtSettings:
    """Settings of an engine of another package, in a form that any process can read without its code.

    Attributes:
        constants: time constants [s] of joints and of contacts.
        fields: all of them as JSON.
        pickled: the engine's own object, for the process that runs it.
        fault: why there is none; empty where there is.
    """

    engine: str
    preset: str
    steps_per_revolution: int
    timestep: float
    constants: tuple[float, float] = (0.0, 0.0)
    fields: str = "{}"
    pickled: bytes = field(default=b"", repr=False)
    fault: str = ""

    def time_constant(self, contact: bool) -> float:
        """Time [s] in which what closes the joints, or a contact, mends an error."""
        return self.constants[contact]

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        found: dict[str, Any] = json.loads(self.fields)
        return found | ({"fault": self.fault} if self.fault else {})

    def changed(self, **values: Any) -> BroughtSettings:
        """The settings with other values, made by the engine that they are of."""
        from conrod.engines import engine_named

        try:
            found: BroughtSettings = engine_named(self.engine).ask("changed", self, values)  # type: ignore[attr-defined]
            return found
        except EngineFault as fault:
            return replace(self, preset=CUSTOM, fault=str(fault))

    @classmethod
    def faulty(cls, engine: str, preset: str, machine: Machine, steps: int, fault: str) -> BroughtSettings:
        """Settings that an engine could not make: a run with them ends with the reason."""
        own = {"preset": preset, "steps_per_revolution": steps}
        step = step_length(machine, steps)
        return cls(engine, preset, steps, step, fields=json.dumps(own), fault=fault)


@dataclass(frozen=True)
class Description:
    """What an engine says of itself, as plain values.

    Attributes:
        presets: by name all but the rule.
        capabilities: names of protocols of `conrod.engines.capabilities`.
    """

    name: str
    version: str
    presets: Mapping[str, Mapping[str, Any]]
    capabilities: tuple[str, ...]


class BroughtEngine(Engine[Any]):
    """An engine of another package as the rest of conrod has it."""

    def __init__(self, description: Description) -> None:
        self.description = description
        self.name, self.version = description.name, description.version
        self.presets = {
            name: Preset(rule=partial(self._settings_of, name), **facts) for name, facts in description.presets.items()
        }

    def has(self, kind: type[Any]) -> bool:
        """True if the engine has a capability."""
        return kind.__name__ in self.description.capabilities

    def _settings_of(self, preset: str, machine: Machine, steps: int, /) -> BroughtSettings:
        """The settings of a preset; those of one that fails say so when they are used."""
        try:
            found: BroughtSettings = self.ask("settings", preset, machine, steps)
            return found
        except EngineFault as fault:
            return BroughtSettings.faulty(self.name, preset, machine, steps, str(fault))

    @abstractmethod
    def ask(self, what: str, *arguments: Any, **named: Any) -> Any:
        """What the method of this name of a `CheckedEngine` returns, or an `EngineFault`."""

    def refusal(self, machine: Machine, settings: Settings) -> str | None:
        found: str | None = self.ask("reason", machine, settings)
        return found

    def run(
        self, machine: Machine, settings: Settings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
    ) -> Iterator[Piece]:
        for piece in self.ask("pieces", machine, settings, revolutions, start_angle, steps):
            yield replace(piece, trajectory=replace(piece.trajectory, settings=settings))

    def __getattr__(self, name: str) -> Any:
        """A method of a capability."""
        if name.startswith("_") or name in ("description", "name", "version", "presets"):
            raise AttributeError(name)
        if name == "releases":
            return self.ask("call", name)
        return partial(self._called, name)

    def _called(self, name: str, *arguments: Any, **named: Any) -> Any:
        match name:
            case "grid":
                names = self.ask("rules", *arguments)
                return tuple(Rule(one, partial(self._rule, arguments, k)) for k, one in enumerate(names))
            case "ingredients":
                found = self.ask("parts", *arguments)
                return tuple(
                    Ingredient(added=partial(part, True), removed=partial(part, False), **facts)
                    for facts, part in ((facts, partial(self._part, arguments, k)) for k, facts in enumerate(found))
                )
        return self.ask("call", name, *arguments, **named)

    def _rule(self, grid: tuple[Any, ...], place: int, machine: Machine, steps: int) -> BroughtSettings:
        try:
            found: BroughtSettings = self.ask("rule", grid, place, machine, steps)
            return found
        except EngineFault as fault:
            return BroughtSettings.faulty(self.name, CUSTOM, machine, steps, str(fault))

    def _part(self, of: tuple[Any, ...], place: int, added: bool, settings: Any) -> Any:
        return self.ask("part", of, place, added, settings)
