"""Engines of other packages (plugins), called by name and plain values from whatever process they are loaded in.

A process that runs studies loads none of them: its `PluginEngine` sends its calls to a separate process
(`conrod.execution.hosted_engine`). A worker, or a user's own program, loads the plugin itself
(`conrod.engines.checked_plugin`).
"""

from __future__ import annotations

import json
from abc import abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

from conrod.comparison.trajectory import Piece, Settings
from conrod.engines.engine import CUSTOM, PIECE_STEPS, Engine, Machine, Preset, step_length
from conrod.engines.plugin_values import EngineFault
from conrod.engines.variants import Ingredient, SettingsRule


@dataclass(frozen=True)
class PluginSettings:
    """Settings of a plugin's engine, in a form that any process can read without the plugin's code.

    Attributes:
        constants: time constants [s] of joints and of contacts.
        fields: all fields of the plugin's settings, as JSON.
        pickled: the plugin's own settings object, for the process that runs it.
        fault: reason why the plugin made no settings; empty if it made them.
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
        """Time constant [s] with which joints or contacts correct a violation."""
        return self.constants[contact]

    def as_dict(self) -> dict[str, Any]:
        """The fields as JSON values."""
        found: dict[str, Any] = json.loads(self.fields)
        return found | ({"fault": self.fault} if self.fault else {})

    def replace_fields(self, **values: Any) -> PluginSettings:
        """Return the settings with other values of some fields, made by the plugin."""
        from conrod.engines import engine_named

        try:
            found: PluginSettings = engine_named(self.engine).ask("replace_fields", self, values)  # type: ignore[attr-defined]
            return found
        except EngineFault as fault:
            return replace(self, preset=CUSTOM, fault=str(fault))

    @classmethod
    def unusable(cls, engine: str, preset: str, machine: Machine, steps: int, fault: str) -> PluginSettings:
        """Settings that the plugin failed to make; a run with them ends with the reason."""
        own = {"preset": preset, "steps_per_revolution": steps}
        step = step_length(machine, steps)
        return cls(engine, preset, steps, step, fields=json.dumps(own), fault=fault)


@dataclass(frozen=True)
class PluginDescription:
    """Name, version, presets and capabilities of a plugin's engine, as plain values.

    Attributes:
        presets: fields of each preset by its name, without the rule.
        capabilities: names of the protocols of `conrod.engines.capabilities` that the engine has.
    """

    name: str
    version: str
    presets: Mapping[str, Mapping[str, Any]]
    capabilities: tuple[str, ...]


class PluginEngine(Engine[Any]):
    """A plugin's engine as the rest of conrod sees it; each method is one call of `ask`."""

    def __init__(self, description: PluginDescription) -> None:
        self.description = description
        self.name, self.version = description.name, description.version
        self.presets = {
            name: Preset(rule=partial(self._preset_settings, name), **facts)
            for name, facts in description.presets.items()
        }

    def has_capability(self, kind: type[Any]) -> bool:
        """Return True if the plugin declared the capability."""
        return kind.__name__ in self.description.capabilities

    def _preset_settings(self, preset: str, machine: Machine, steps: int, /) -> PluginSettings:
        """Settings of a preset; unusable ones, with the reason, if the plugin fails to make them."""
        try:
            found: PluginSettings = self.ask("settings", preset, machine, steps)
            return found
        except EngineFault as fault:
            return PluginSettings.unusable(self.name, preset, machine, steps, str(fault))

    @abstractmethod
    def ask(self, what: str, *arguments: Any, **named: Any) -> Any:
        """Call the method of `CheckedPlugin` of this name; raises EngineFault if the plugin fails."""

    def refusal(self, machine: Machine, settings: Settings) -> str | None:
        found: str | None = self.ask("refusal_reason", machine, settings)
        return found

    def run(
        self,
        machine: Machine,
        settings: Settings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE_STEPS,
    ) -> Iterator[Piece]:
        for piece in self.ask("pieces", machine, settings, revolutions, start_angle, steps):
            yield replace(piece, trajectory=replace(piece.trajectory, settings=settings))

    def __getattr__(self, name: str) -> Any:
        """Return the method of a capability as a call of the plugin."""
        if name.startswith("_") or name in ("description", "name", "version", "presets"):
            raise AttributeError(name)
        if name == "releases":
            return self.ask("call_capability", name)
        return partial(self._call_capability, name)

    def _call_capability(self, name: str, *arguments: Any, **named: Any) -> Any:
        """Call a capability's method, with rules and ingredients as objects that call the plugin again."""
        match name:
            case "grid":
                names = self.ask("rule_names", *arguments)
                return tuple(
                    SettingsRule(one, partial(self._rule_settings, arguments, k)) for k, one in enumerate(names)
                )
            case "ingredients":
                found = self.ask("ingredient_facts", *arguments)
                return tuple(
                    Ingredient(added=partial(part, True), removed=partial(part, False), **facts)
                    for facts, part in (
                        (facts, partial(self._ingredient_settings, arguments, k)) for k, facts in enumerate(found)
                    )
                )
        return self.ask("call_capability", name, *arguments, **named)

    def _rule_settings(self, grid: tuple[Any, ...], place: int, machine: Machine, steps: int) -> PluginSettings:
        """Settings of the rule at a place in a grid; unusable ones if the plugin fails."""
        try:
            found: PluginSettings = self.ask("rule_settings", grid, place, machine, steps)
            return found
        except EngineFault as fault:
            return PluginSettings.unusable(self.name, CUSTOM, machine, steps, str(fault))

    def _ingredient_settings(self, of: tuple[Any, ...], place: int, added: bool, settings: Any) -> Any:
        """Settings with an ingredient added, or removed."""
        return self.ask("ingredient_settings", of, place, added, settings)
