"""An engine of another package in the process that has loaded it: all that it hands over passes the door."""

from __future__ import annotations

import copy
import json
import pickle
from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np

from conrod.engines import door
from conrod.engines.brought import BroughtEngine, BroughtSettings, Description
from conrod.engines.capabilities import MEANINGS, ExpectedError, KinematicResult
from conrod.engines.door import EngineFault, demand, guarded, number_of, text_of, typed
from conrod.engines.engine import OTHER_LINE, PIECE, LineStyle, Machine, Preset, with_fields
from conrod.engines.piece_door import PieceDoor
from conrod.engines.tracks import ForceTracks, FreeRun
from conrod.runs.trajectory import Piece, Settings

CAPABILITIES: Mapping[str, type[Any]] = {kind.__name__: kind for kind in MEANINGS}


def describe(engine: Any, name: str) -> Description:
    """Description of an engine that was loaded by a name.

    Raises:
        EngineFault: something that it says of itself cannot be used.
    """
    with guarded():
        demand(engine.name == name, f"the name {door.one_line(repr(engine.name))}")
        version = text_of(engine.version, "a version")
        demand(bool(version), "no version")
        demand(version == engine.version == str(engine.version), "another version each time")
        presets = {}
        for known, preset in dict(engine.presets).items():
            typed(preset, Preset, "a preset")
            presets[text_of(known, "the name of a preset")] = _preset_facts(preset)
        demand(bool(presets), "no preset")
        able = tuple(known for known, kind in CAPABILITIES.items() if isinstance(engine, kind))
    return Description(name, version, presets, able)


def _preset_facts(preset: Preset[Any]) -> dict[str, Any]:
    numbers = {one: door.checked_numbers(getattr(preset, one), f"{one} of a preset") for one in ("forces", "order")}
    return {
        "meaning": text_of(preset.meaning, "the meaning of a preset"),
        "judged": typed(preset.judged, bool, "`judged` of a preset"),
        "judged_free": typed(preset.judged_free, bool, "`judged_free` of a preset"),
        "forces": numbers["forces"],
        "forces_order": door.count_of(preset.forces_order, "an order of forces"),
        "order": {quantity: round(order) for quantity, order in numbers["order"].items()},
        "style": preset.style if type(preset.style) is LineStyle else OTHER_LINE,
    }


class CheckedEngine(BroughtEngine):
    """An engine of another package in the process that has loaded it."""

    def __init__(self, plugin: Any, name: str, unchanged: Mapping[str, Any]) -> None:
        """Ask it what it is.

        Args:
            unchanged: functions of numpy by name, before it was loaded.
        """
        self._plugin, self._numpy = plugin, unchanged
        self.handed_over = 0  # pieces and results, by which is known who is at fault
        super().__init__(describe(plugin, name))

    def ask(self, what: str, *arguments: Any, **named: Any) -> Any:
        return getattr(self, what)(*arguments, **named)

    # -- settings ------------------------------------------------------------------------------------------------------

    def settings(self, preset: str, machine: Machine, steps: int) -> BroughtSettings:
        """Settings of a preset."""
        with guarded():
            return self._wrapped(self._plugin.presets[preset](copy.deepcopy(machine), steps), preset, machine, steps)

    def _wrapped(self, own: Any, preset: str, machine: Machine | None, steps: int) -> BroughtSettings:
        plain = door.checked_fields(own, self.name, preset, machine, steps)
        times = [number_of(own.time_constant(contact), "a time constant [s]", 0.0) for contact in (False, True)]
        return BroughtSettings(
            self.name, preset, steps, float(own.timestep), (times[0], times[1]), json.dumps(plain), pickle.dumps(own)
        )

    def changed(self, settings: BroughtSettings, values: Mapping[str, Any]) -> BroughtSettings:
        """Settings with other values of some fields."""
        with guarded():
            return self._of_machine(with_fields(self._own(settings), **values), None)

    def _of_machine(self, own: Any, machine: Machine | None) -> BroughtSettings:
        return self._wrapped(own, own.preset, machine, own.steps_per_revolution)

    def _own(self, settings: Any) -> Any:
        """A fresh copy of the engine's own settings."""
        if not isinstance(settings, BroughtSettings):
            return copy.deepcopy(settings)
        if settings.fault:
            raise EngineFault(settings.fault)
        return pickle.loads(settings.pickled)

    # -- runs ----------------------------------------------------------------------------------------------------------

    def reason(self, machine: Machine, settings: Settings) -> str | None:
        """The reason why settings cannot be used on a machine, or None."""
        with guarded():
            found = self._plugin.refusal(copy.deepcopy(machine), self._own(settings))
            self._check_surroundings()
            return None if found is None else text_of(found, "a reason of a refusal") or "it gives no reason"

    def pieces(
        self, machine: Machine, settings: Settings, revolutions: float, start_angle: float, steps: int
    ) -> list[Piece]:
        """All pieces of a run."""
        return list(self.run(machine, settings, revolutions, start_angle, steps))

    def run(
        self, machine: Machine, settings: Settings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
    ) -> Iterator[Piece]:
        samples = round(settings.steps_per_revolution * revolutions) + 1
        way = PieceDoor(self.name, self.version, machine, settings, revolutions, samples)
        with guarded():
            given = copy.deepcopy(machine), self._own(settings), revolutions, start_angle
            found = iter(self._plugin.run(*given, steps))
        while True:
            with guarded():
                piece = next(found, None)
                self._check_surroundings()
                if piece is None:
                    break
                self.handed_over += 1
                piece = way.check(piece)
            yield piece
        demand(way.taken > 0, "no sample of the run")

    def _check_surroundings(self) -> None:
        """Refuse an engine that changes what its own errors are worked out with."""
        now = numpy_functions()
        changed = [name for name, function in self._numpy.items() if now.get(name) is not function]
        if changed:
            raise EngineFault(f"it changed {changed[0]}, which its errors are worked out with")

    # -- capabilities --------------------------------------------------------------------------------------------------

    def call(self, name: str, *arguments: Any, **named: Any) -> Any:
        """What a method of a capability returns, as far as it can be used."""
        self.handed_over += 1
        with guarded(refusals=name == "free_run"):
            if name == "releases":
                return self._plugin.releases
            machine = next((one for one in arguments if hasattr(one, "kinematics")), None)
            given = [self._own(one) if isinstance(one, BroughtSettings) else copy.deepcopy(one) for one in arguments]
            found = getattr(self._plugin, name)(*given, **named)
            self._check_surroundings()
            return self._checked(name, found, machine, arguments)

    def _checked(self, name: str, found: Any, machine: Any, arguments: tuple[Any, ...]) -> Any:
        """What a capability returned, as it may be used; see the protocols."""
        checks: dict[str, Callable[[], Any]] = {
            "expected_error": lambda: door.checked_law(found, ExpectedError),
            "solve_kinematics": lambda: _checked_kinematics(found, machine, len(arguments[1])),
            "forces": lambda: _checked_forces(found),
            "free_run": lambda: _checked_free_run(found, arguments),
            "paste": lambda: typed(found, str, "lines to paste"),
            "model": lambda: typed(found, str, "a file of a model"),
            "probes": lambda: {text_of(one, "a name"): self._of_machine(own, machine) for one, own in found.items()},
        }
        checks |= dict.fromkeys(("stepper", "reference_loop"), lambda: partial(_step, found))
        settings = ("stabilised", "regularised", "minimal")
        checks |= dict.fromkeys(settings, lambda: None if found is None else self._of_machine(found, machine))
        demand(name in checks, f"nothing for {name}")
        return checks[name]()

    def rules(self, *grid: Any) -> tuple[str, ...]:
        """Names of the rules of a grid."""
        with guarded():
            return tuple(text_of(rule.name, "the name of a rule") for rule in self._plugin.grid(*copy.deepcopy(grid)))

    def rule(self, grid: tuple[Any, ...], place: int, machine: Machine, steps: int) -> BroughtSettings:
        """Settings of a rule of a grid."""
        with guarded():
            own = self._plugin.grid(*copy.deepcopy(grid))[place].settings(copy.deepcopy(machine), steps)
            return self._wrapped(own, own.preset, machine, steps)

    def parts(self, machine: Machine, minimal: BroughtSettings) -> list[dict[str, Any]]:
        """Ingredients by all but what adds and removes them."""
        with guarded():
            found = self._plugin.ingredients(copy.deepcopy(machine), self._own(minimal))
            return [{name: getattr(one, name) for name in ("name", "meaning", "needed_by", "minimal")} for one in found]

    def part(self, of: tuple[Any, Any], place: int, added: bool, settings: BroughtSettings) -> BroughtSettings:
        """Settings with an ingredient or without it."""
        with guarded():
            one = self._plugin.ingredients(copy.deepcopy(of[0]), self._own(of[1]))[place]
            return self._of_machine((one.added if added else one.removed)(self._own(settings)), of[0])


def _step(advance: Callable[[int], Any], steps: int) -> None:
    with guarded():
        advance(steps)


def _checked_kinematics(found: Any, machine: Machine, samples: int) -> KinematicResult:
    typed(found, KinematicResult, "a result of kinematic mode")
    mechanism = machine.kinematics.mechanism
    poses = door.array_of(found.poses, "poses", 3 * len(mechanism.bodies))
    points = {}
    for name, (position, velocity) in dict(found.points).items():
        moving = None if velocity is None else door.array_of(velocity, "velocities", 2)
        points[text_of(name, "a point")] = (door.array_of(position, "positions", 2), moving)
    parts = [poses, *(part for pair in points.values() for part in pair if part is not None)]
    demand(all(len(part) == samples for part in parts), f"poses of other than the {samples} angles")
    demand(set(points) == {one.name for one in mechanism.observed}, f"points {sorted(points)}")
    shape = None if found.shape_error is None else number_of(found.shape_error, "an error of the shape [m]", 0.0)
    return KinematicResult(door.array_of(found.angle, "angles"), poses, points, shape)


def _checked_forces(handed: Any) -> ForceTracks:
    found: ForceTracks = door.finite_arrays(handed, ForceTracks, "forces")
    samples = len(found.instants.times)
    parts = [values for joint in dict(found.joints).values() for values in dict(joint).values()]
    for values in (*parts, *(() if found.drive_torque is None else (found.drive_torque,))):
        demand(len(door.array_of(values, "forces")) == samples, "forces of another number of samples than of stamps")
    demand(bool((np.diff(found.instants.times) > 0.0).all()), "stamps of forces that are out of order")
    return found


def _checked_free_run(handed: Any, arguments: tuple[Any, ...]) -> FreeRun:
    found = typed(handed, FreeRun, "a motion without a drive")
    columns, times = 3 * len(arguments[0].bodies), door.array_of(found.times, "stamps")
    for name, width in (("poses", columns), ("rates", columns), ("energy", None)):
        values = door.array_of(getattr(found, name), name, width, finite=found.outcome.slug == "completed")
        demand(len(values) == len(times), f"{len(values)} samples of {name} for {len(times)} stamps")
    demand(len(times) > 1 and bool((np.diff(times) > 0.0).all()), "stamps that are out of order")
    return found


def numpy_functions() -> dict[str, Any]:
    """Functions of numpy by name, as they are now."""
    return {
        f"{module.__name__}.{name}": function
        for module in (np, np.linalg)
        for name, function in vars(module).items()
        if callable(function) and not name.startswith("_")
    }
