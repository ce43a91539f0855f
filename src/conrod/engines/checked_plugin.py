"""A plugin's engine in the process that has loaded it: all that it returns is checked before conrod uses it."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from conrod.comparison.trajectory import Piece, Settings
from conrod.engines import plugin_values
from conrod.engines.capabilities import CAPABILITY_TITLES, ExpectedError, KinematicResult
from conrod.engines.engine import DEFAULT_LINE, PIECE_STEPS, LineStyle, Machine, Preset, with_fields
from conrod.engines.plugin import PluginDescription, PluginEngine, PluginSettings
from conrod.engines.plugin_pieces import PieceChecker
from conrod.engines.plugin_space import check_spatial_run
from conrod.engines.plugin_values import (
    EngineFault,
    catch_faults,
    check_finite_number,
    check_text,
    check_type,
    refuse_unless,
)
from conrod.engines.tracks import ForceTracks, FreeRun

CAPABILITY_OF_NAME: Mapping[str, type[Any]] = {kind.__name__: kind for kind in CAPABILITY_TITLES}
CAN_REFUSE = ("free_run", "run_in_space")  # by InvalidInput


def describe(engine: Any, name: str) -> PluginDescription:
    """Describe a plugin's engine that was loaded by a name.

    Raises:
        EngineFault: a name, version, preset or capability of the engine cannot be used.
    """
    with catch_faults():
        refuse_unless(engine.name == name, f"the name {plugin_values.one_line(repr(engine.name))}")
        version = check_text(engine.version, "a version")
        refuse_unless(bool(version), "no version")
        refuse_unless(version == engine.version == str(engine.version), "another version each time")
        presets = {}
        for known, preset in dict(engine.presets).items():
            check_type(preset, Preset, "a preset")
            presets[check_text(known, "the name of a preset")] = _preset_facts(preset)
        refuse_unless(bool(presets), "no preset")
        capabilities = tuple(known for known, kind in CAPABILITY_OF_NAME.items() if isinstance(engine, kind))
    return PluginDescription(name, version, presets, capabilities)


def _preset_facts(preset: Preset[Any]) -> dict[str, Any]:
    """Checked fields of a plugin's preset, without its rule."""
    numbers = {
        one: plugin_values.check_number_table(getattr(preset, one), f"{one} of a preset") for one in ("forces", "order")
    }
    return {
        "meaning": check_text(preset.meaning, "the meaning of a preset"),
        "judged": check_type(preset.judged, bool, "`judged` of a preset"),
        "judged_free": check_type(preset.judged_free, bool, "`judged_free` of a preset"),
        "forces": numbers["forces"],
        "forces_order": plugin_values.check_whole_number(preset.forces_order, "an order of forces"),
        "order": {quantity: round(order) for quantity, order in numbers["order"].items()},
        "style": preset.style if type(preset.style) is LineStyle else DEFAULT_LINE,
    }


class CheckedPlugin(PluginEngine):
    """A plugin's engine, loaded in this process; every result is checked, every exception an `EngineFault`."""

    def __init__(self, plugin: Any, name: str, unchanged: Mapping[str, Any]) -> None:
        """Read and check the plugin's description.

        Args:
            unchanged: functions of numpy by name, as they were before the plugin was loaded.
        """
        self._plugin, self._numpy = plugin, unchanged
        self.handed_over = 0  # number of pieces and results so far: errors after the first are the plugin's
        super().__init__(describe(plugin, name))

    def ask(self, what: str, *arguments: Any, **named: Any) -> Any:
        return getattr(self, what)(*arguments, **named)

    # -- settings ------------------------------------------------------------------------------------------------------

    def settings(self, preset: str, machine: Machine, steps: int) -> PluginSettings:
        """Settings of a preset for a machine and steps per revolution."""
        with catch_faults():
            return self._to_plugin_settings(
                self._plugin.presets[preset](copy.deepcopy(machine), steps), preset, machine, steps
            )

    def _to_plugin_settings(self, own: Any, preset: str, machine: Machine | None, steps: int) -> PluginSettings:
        """Check settings of the plugin's own class and return them as plain values."""
        plain = plugin_values.check_settings(own, self.name, preset, machine, steps)
        times = [
            check_finite_number(own.time_constant(contact), "a time constant [s]", 0.0) for contact in (False, True)
        ]
        return PluginSettings(
            self.name, preset, steps, float(own.timestep), (times[0], times[1]), json.dumps(plain), pickle.dumps(own)
        )

    def replace_fields(self, settings: PluginSettings, values: Mapping[str, Any]) -> PluginSettings:
        """Settings with other values of some fields."""
        with catch_faults():
            return self._settings_for_machine(with_fields(self._own_settings(settings), **values), None)

    def _settings_for_machine(self, own: Any, machine: Machine | None) -> PluginSettings:
        """Check settings that state their own preset and steps per revolution."""
        return self._to_plugin_settings(own, own.preset, machine, own.steps_per_revolution)

    def _own_settings(self, settings: Any) -> Any:
        """A fresh copy of the settings as an object of the plugin's own class."""
        if not isinstance(settings, PluginSettings):
            return copy.deepcopy(settings)
        if settings.fault:
            raise EngineFault(settings.fault)
        return pickle.loads(settings.pickled)

    # -- runs ----------------------------------------------------------------------------------------------------------

    def refusal_reason(self, machine: Machine, settings: Settings) -> str | None:
        """The reason why settings cannot be used on a machine, or None."""
        with catch_faults():
            found = self._plugin.refusal(copy.deepcopy(machine), self._own_settings(settings))
            self._check_surroundings()
            return None if found is None else _check_refusal(found)

    def pieces(
        self, machine: Machine, settings: Settings, revolutions: float, start_angle: float, steps: int
    ) -> list[Piece]:
        """All pieces of a run, as a list."""
        return list(self.run(machine, settings, revolutions, start_angle, steps))

    def run(
        self,
        machine: Machine,
        settings: Settings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE_STEPS,
    ) -> Iterator[Piece]:
        samples = round(settings.steps_per_revolution * revolutions) + 1
        checker = PieceChecker(self.name, self.version, machine, settings, revolutions, samples)
        with catch_faults():
            given = copy.deepcopy(machine), self._own_settings(settings), revolutions, start_angle
            found = iter(self._plugin.run(*given, steps))
        while True:
            with catch_faults():
                piece = next(found, None)
                self._check_surroundings()
                if piece is None:
                    break
                self.handed_over += 1
                piece = checker.check(piece)
            yield piece
        refuse_unless(checker.samples_taken > 0, "no sample of the run")

    def _check_surroundings(self) -> None:
        """Raise EngineFault if the plugin replaced numpy functions that its errors are computed with."""
        now = numpy_functions()
        changed = [name for name, function in self._numpy.items() if now.get(name) is not function]
        if changed:
            raise EngineFault(f"it changed {changed[0]}, which its errors are worked out with")

    # -- capabilities --------------------------------------------------------------------------------------------------

    def call_capability(self, name: str, *arguments: Any, **named: Any) -> Any:
        """Call a method of a capability on copies of its arguments, and check the result."""
        self.handed_over += 1
        with catch_faults(refusals=name in CAN_REFUSE):
            if name == "releases":
                return self._plugin.releases
            machine = next((one for one in arguments if hasattr(one, "kinematics")), None)
            given = [
                self._own_settings(one) if isinstance(one, PluginSettings) else copy.deepcopy(one) for one in arguments
            ]
            found = getattr(self._plugin, name)(*given, **named)
            self._check_surroundings()
            return self._check_result(name, found, machine, arguments, named)

    def _check_result(
        self, name: str, found: Any, machine: Any, arguments: tuple[Any, ...], named: Mapping[str, Any]
    ) -> Any:
        """Check a result of a capability's method against its protocol in `capabilities`."""
        checks: dict[str, Callable[[], Any]] = {
            "expected_error": lambda: plugin_values.check_error_bounds(found, ExpectedError),
            "solve_kinematics": lambda: _check_kinematics(found, machine, len(arguments[1])),
            "forces": lambda: _check_forces(found),
            "free_run": lambda: _check_free_run(found, arguments),
            "refusal_in_space": lambda: None if found is None else _check_refusal(found),
            "run_in_space": lambda: check_spatial_run(found, *arguments, **named),
            "paste": lambda: check_type(found, str, "lines to paste"),
            "model": lambda: check_type(found, str, "a file of a model"),
            "probes": lambda: {
                check_text(one, "a name"): self._settings_for_machine(own, machine) for one, own in found.items()
            },
        }
        steppers = ("stepper", "reference_loop", "stepper_in_space")
        checks |= dict.fromkeys(steppers, lambda: partial(_advance_plugin, found))
        settings = ("with_time_constant", "with_regularisation", "minimal_settings")
        checks |= dict.fromkeys(settings, lambda: None if found is None else self._settings_for_machine(found, machine))
        refuse_unless(name in checks, f"nothing for {name}")
        return checks[name]()

    def rule_names(self, *grid: Any) -> tuple[str, ...]:
        """Names of the rules of a grid, in order."""
        with catch_faults():
            return tuple(
                check_text(rule.name, "the name of a rule") for rule in self._plugin.grid(*copy.deepcopy(grid))
            )

    def rule_settings(self, grid: tuple[Any, ...], place: int, machine: Machine, steps: int) -> PluginSettings:
        """Settings of the rule at a place in a grid."""
        with catch_faults():
            own = self._plugin.grid(*copy.deepcopy(grid))[place].settings(copy.deepcopy(machine), steps)
            return self._to_plugin_settings(own, own.preset, machine, steps)

    def ingredient_facts(self, machine: Machine, minimal: PluginSettings) -> list[dict[str, Any]]:
        """Fields of all ingredients of a minimal model, without the functions that add and remove them."""
        with catch_faults():
            found = self._plugin.ingredients(copy.deepcopy(machine), self._own_settings(minimal))
            names = ("name", "meaning", "needed_by", "minimal", "refusal")
            return [{name: getattr(one, name) for name in names} for one in found]

    def ingredient_settings(
        self, of: tuple[Any, Any], place: int, added: bool, settings: PluginSettings
    ) -> PluginSettings:
        """Settings with an ingredient added, or removed."""
        with catch_faults():
            one = self._plugin.ingredients(copy.deepcopy(of[0]), self._own_settings(of[1]))[place]
            return self._settings_for_machine(
                (one.added if added else one.removed)(self._own_settings(settings)), of[0]
            )


def _check_refusal(found: Any) -> str:
    """Return the reason of a refusal on one line; a text that says so if it is empty."""
    return check_text(found, "a reason of a refusal") or "it gives no reason"


def _advance_plugin(advance: Callable[[int], Any], steps: int) -> None:
    """Advance a plugin's stepper by a number of steps."""
    with catch_faults():
        advance(steps)


def _check_kinematics(found: Any, machine: Machine, samples: int) -> KinematicResult:
    """Check a result of kinematic mode for its shapes, points and numbers."""
    check_type(found, KinematicResult, "a result of kinematic mode")
    mechanism = machine.kinematics.mechanism
    poses = plugin_values.check_array(found.poses, "poses", 3 * len(mechanism.bodies))
    points = {}
    for name, (position, velocity) in dict(found.points).items():
        moving = None if velocity is None else plugin_values.check_array(velocity, "velocities", 2)
        points[check_text(name, "a point")] = (plugin_values.check_array(position, "positions", 2), moving)
    parts = [poses, *(part for pair in points.values() for part in pair if part is not None)]
    refuse_unless(all(len(part) == samples for part in parts), f"poses of other than the {samples} angles")
    refuse_unless(set(points) == {one.name for one in mechanism.observed}, f"points {sorted(points)}")
    shape = (
        None if found.shape_error is None else check_finite_number(found.shape_error, "an error of the shape [m]", 0.0)
    )
    return KinematicResult(plugin_values.check_array(found.angle, "angles"), poses, points, shape)


def _check_forces(handed: Any) -> ForceTracks:
    """Check reported forces for their shapes, order of stamps and numbers."""
    found: ForceTracks = plugin_values.check_finite_arrays(handed, ForceTracks, "forces")
    samples = len(found.instants.times)
    parts = [values for joint in dict(found.joints).values() for values in dict(joint).values()]
    for values in (*parts, *(() if found.drive_torque is None else (found.drive_torque,))):
        refuse_unless(
            len(plugin_values.check_array(values, "forces")) == samples,
            "forces of another number of samples than of stamps",
        )
    refuse_unless(bool((np.diff(found.instants.times) > 0.0).all()), "stamps of forces that are out of order")
    return found


def _check_free_run(handed: Any, arguments: tuple[Any, ...]) -> FreeRun:
    """Check a motion without a drive for its shapes, order of stamps and numbers."""
    found = check_type(handed, FreeRun, "a motion without a drive")
    columns, times = 3 * len(arguments[0].bodies), plugin_values.check_array(found.times, "stamps")
    for name, width in (("poses", columns), ("rates", columns), ("energy", None)):
        values = plugin_values.check_array(getattr(found, name), name, width, finite=found.outcome.slug == "completed")
        refuse_unless(len(values) == len(times), f"{len(values)} samples of {name} for {len(times)} stamps")
    refuse_unless(len(times) > 1 and bool((np.diff(times) > 0.0).all()), "stamps that are out of order")
    return found


def numpy_functions() -> dict[str, Any]:
    """All public functions of numpy and numpy.linalg by name, as they are now."""
    return {
        f"{module.__name__}.{name}": function
        for module in (np, np.linalg)
        for name, function in vars(module).items()
        if callable(function) and not name.startswith("_")
    }
