"""Engines of other packages that each misbehave in one way; the rest of each is the planted engine."""

from __future__ import annotations

import locale
import os
import signal
import sys
import time
import warnings
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
from planted_engine import ORDERS, PlantedEngine, PlantedSettings, preset

from conrod.comparison.trajectory import BodyStates, Piece, PointTracks, Track
from conrod.engines.engine import Preset
from conrod.errors import InvalidInput
from conrod.exact.motion import Array, Instants

# -- pieces ------------------------------------------------------------------------------------------------------------

Edit = Callable[[Array], Any]


def with_arrays(edit: Edit) -> Callable[[Piece], Any]:
    """A change of every array of a piece."""

    def instants(at: Instants) -> Instants:
        return Instants(*(edit(values) for values in vars(at).values()))

    def states(one: BodyStates) -> BodyStates:
        return BodyStates(instants(one.instants), *(edit(v) for v in (one.poses, one.rates, one.accelerations)))

    def change(piece: Piece) -> Piece:
        found = piece.trajectory
        assert found.bodies is not None
        points = {
            name: PointTracks(*(Track(instants(t.instants), edit(t.values)) for t in vars(tracks).values()))
            for name, tracks in found.points.items()
        }
        bodies = type(found.bodies)(*map(states, vars(found.bodies).values()))
        return replace(piece, trajectory=replace(found, points=points, bodies=bodies), clock=edit(piece.clock))

    return change


def with_times(edit: Edit) -> Callable[[Piece], Any]:
    """A change of the stamps of the observed points."""

    def change(piece: Piece) -> Piece:
        def track(one: Track) -> Track:
            return Track(replace(one.instants, times=edit(one.instants.times)), one.values)

        points = {n: PointTracks(*map(track, vars(t).values())) for n, t in piece.trajectory.points.items()}
        return replace(piece, trajectory=replace(piece.trajectory, points=points))

    return change


class Edited(PlantedEngine):
    """Changes each piece."""

    def __init__(self, edit: Callable[[Piece], Any]) -> None:
        self.edit = edit

    def run(self, *arguments: Any, **named: Any) -> Iterator[Any]:
        return map(self.edit, super().run(*arguments, **named))


class Does(PlantedEngine):
    """Does something before its run, with the machine and the settings."""

    def __init__(self, act: Callable[[Any, Any], Any]) -> None:
        self.act = act

    def run(self, machine: Any, settings: Any, *arguments: Any, **named: Any) -> Iterator[Piece]:
        self.act(machine, settings)
        return super().run(machine, settings, *arguments, **named)


class Yields(PlantedEngine):
    """Yields something else in place of pieces."""

    def __init__(self, pieces: Callable[[Iterator[Piece]], Any]) -> None:
        self.pieces = pieces

    def run(self, *arguments: Any, **named: Any) -> Any:
        return self.pieces(super().run(*arguments, **named))


def endless(found: Iterator[Piece]) -> Iterator[Piece]:
    first = next(found)
    while True:
        yield first


def raiser(error: BaseException | type[BaseException]) -> Callable[..., Any]:
    def act(*_: Any) -> None:
        raise error

    return act


class Unspeakable(Exception):
    def __str__(self) -> str:
        raise RuntimeError("nor can it say so")


class OfItsOwn(BaseException):
    """No Exception."""


class Subclass(np.ndarray):  # type: ignore[type-arg]
    """Subclass of a numpy array."""


# -- what it does to its surroundings ----------------------------------------------------------------------------------


def patch_numpy(*_: Any) -> None:
    np.linalg.norm = lambda values, *a, **k: np.zeros(len(values))  # type: ignore[assignment]


def patch_surroundings(*_: Any) -> None:
    os.chdir("/")
    locale.setlocale(locale.LC_ALL, "C")
    signal.signal(signal.SIGTERM, signal.SIG_IGN)
    warnings.simplefilter("error")
    np.seterr(all="raise")
    mujoco.set_mju_user_warning(lambda _: os._exit(5))
    mujoco.set_mjcb_control(lambda _, data: data.qvel.__setitem__(slice(None), 1e6))
    os.environ["OMP_NUM_THREADS"] = "nonsense"
    sys.path.clear()


class Mutates(PlantedEngine):
    """Changes the machine and the settings that it was given, once it needs them no more."""

    def run(self, machine: Any, settings: Any, *arguments: Any, **named: Any) -> Iterator[Piece]:
        found = list(super().run(machine, settings, *arguments, **named))
        mutate(machine, settings)
        return iter(found)


def mutate(machine: Any, settings: Any) -> None:
    object.__setattr__(machine, "speed", 1e-3 * machine.speed)
    machine.kinematics.start[:] = 0.0
    object.__setattr__(settings, "timestep", 1.0)


def fork_and_abort(*_: Any) -> None:
    if os.fork():
        os.abort()
    time.sleep(600.0)


# -- what it says of itself --------------------------------------------------------------------------------------------


class Refuses(PlantedEngine):
    """Gives something as its refusal."""

    def __init__(self, reason: Callable[[], Any]) -> None:
        self.reason = reason

    def refusal(self, *_: Any) -> Any:
        return self.reason()


@dataclass(frozen=True)
class NamedSettings(PlantedSettings):
    """Settings of the engines of this module."""

    engine: str = field(default="", kw_only=True)  # type: ignore[misc]


class Settles(PlantedEngine):
    """Its presets make other settings."""

    def __init__(self, change: Callable[[PlantedSettings], Any]) -> None:
        self.change = change


def named_presets(engine: PlantedEngine) -> dict[str, Preset[Any]]:
    """The presets of the planted engine for one of another name."""

    def rule(name: str, machine: Any, steps: int, /) -> Any:
        own = preset(name, judged=True)(machine, steps)
        made = NamedSettings(name, steps, own.timestep, own.order, engine=engine.name)
        return getattr(engine, "change", lambda same: same)(made)

    return {name: Preset(partial(rule, name), judged=ORDERS[name] > 1) for name in ORDERS}


class Renamed(PlantedEngine):
    """Has another name in every trajectory."""

    def run(self, *arguments: Any, **named: Any) -> Iterator[Piece]:
        for k, piece in enumerate(super().run(*arguments, **named)):
            yield replace(piece, trajectory=replace(piece.trajectory, engine=f"mujoco-{k}"))


class WrongLaw(PlantedEngine):
    """Its law allows any error, in a form that no law has."""

    def expected_error(self, *_: Any) -> Any:
        return {"position": "any"}


class NanLaw(PlantedEngine):
    def expected_error(self, *_: Any) -> Any:
        from conrod.engines.capabilities import ExpectedError

        return ExpectedError(float("nan"), float("inf"), -1.0)


class WrongKinematics(PlantedEngine):
    def solve_kinematics(self, machine: Any, angle: Array) -> Any:
        return {"poses": angle}


# By name: the engine, and a part of the reason for which its run ends.
CASES: dict[str, tuple[PlantedEngine, str]] = {
    "nan": (Edited(with_arrays(lambda values: values * np.nan)), "nan"),
    "nan-states": (Edited(with_arrays(lambda v: v if v.ndim == 1 else v * np.nan)), "not finite from"),
    "infinite": (Edited(with_times(lambda times: times + np.inf)), "with inf"),
    "nothing": (Yields(lambda _: iter(())), "no sample of the run"),
    "none": (Yields(lambda _: None), "not iterable"),
    "no-piece": (Yields(lambda _: iter([3])), "a piece of a run that is of int"),
    "endless": (Yields(endless), "its pieces do not join"),
    "begins-late": (Yields(lambda found: (replace(piece, first_step=7) for piece in found)), "do not join"),
    "reversed": (Edited(with_times(lambda times: times[::-1].copy())), "stamps of"),
    "same-stamps": (Edited(with_times(lambda times: times * 0.0)), "stamps of"),
    "object": (Edited(with_arrays(lambda values: values.astype(object))), "as object, not as float64"),
    "complex": (Edited(with_arrays(lambda values: values.astype(complex))), "as complex128"),
    "single": (Edited(with_arrays(lambda values: values.astype(np.float32))), "as float32"),
    "lists": (Edited(with_arrays(lambda values: values.tolist())), "as list, not as a numpy array"),
    "subclass": (Edited(with_arrays(lambda values: values.view(Subclass))), "as Subclass"),
    "masked": (Edited(with_arrays(np.ma.masked_array)), "as MaskedArray"),  # type: ignore[arg-type]
    "huge": (Edited(with_arrays(lambda v: np.concatenate([v] * 50))), "samples"),
    "transposed": (Edited(with_arrays(lambda values: values.T.copy())), "of shape"),
    "short": (Edited(with_arrays(lambda values: values[: len(values) // 2])), "the run ended after"),
    "other-outcome": (Edited(lambda p: replace(p, trajectory=replace(p.trajectory, outcome="fine"))), "not of Outcome"),
    "no-points": (Edited(lambda p: replace(p, trajectory=replace(p.trajectory, points={}))), "points []"),
    "no-bodies": (Edited(lambda p: replace(p, trajectory=replace(p.trajectory, bodies=None))), "tracks of the bodies"),
    "renamed": (Renamed(), "a run of engine 'mujoco-0'"),
    "raises": (Does(raiser(RuntimeError("the solver is lost"))), "RuntimeError: the solver is lost"),
    "refuses-late": (Does(raiser(InvalidInput("rod = 3 m is too long"))), "InvalidInput: rod = 3 m is too long"),
    "exits": (Does(lambda *_: sys.exit(0)), "SystemExit: 0"),
    "leaves": (Does(lambda *_: os._exit(0)), "ended with status 0"),
    "aborts": (Does(lambda *_: os.abort()), "ended by signal SIGABRT"),
    "forks": (Does(fork_and_abort), "ended by signal SIGABRT"),
    "interrupts": (Does(raiser(KeyboardInterrupt)), "KeyboardInterrupt"),
    "of-its-own": (Does(raiser(OfItsOwn("lost"))), "OfItsOwn: lost"),
    "unspeakable": (Does(raiser(Unspeakable())), "Unspeakable"),
    "in-colours": (Does(raiser(ValueError("\x1b[31mred\x1b[0m\nand a second line"))), "ValueError"),
    "numpy": (Does(patch_numpy), "it changed numpy.linalg.norm"),
    "int-refusal": (Refuses(lambda: 3), "a reason of a refusal that is of int"),
    "raising-refusal": (Refuses(lambda: 1 / 0), "ZeroDivisionError"),
    "exiting-refusal": (Refuses(lambda: os._exit(7)), "ended with status 7"),
    "other-step": (Settles(lambda s: replace(s, timestep=-s.timestep)), "a time step of -"),
    "nan-step": (Settles(lambda s: replace(s, timestep=float("nan"))), "a time step [s] = nan"),
    "no-settings": (Settles(lambda s: None), "AttributeError"),
    "other-preset": (Settles(lambda s: replace(s, preset="tuned")), "settings of"),
    "raising-preset": (Settles(lambda s: 1 / 0), "ZeroDivisionError"),
    "leaving-preset": (Settles(lambda s: os._exit(3)), "ended with status 3"),
    "law": (WrongLaw(), "a law of its errors that is of dict"),
    "nan-law": (NanLaw(), "a bound of position = nan"),
}
# Those whose runs are as good as any, whatever they do to their own process or to what they were given.
HARMLESS: dict[str, PlantedEngine] = {
    "patches": Does(patch_surroundings),
    "mutates": Mutates(),
}
# Those of a study that takes seconds, for each takes two processes: of each kind of them one. The others are slow.
FAST = ("nan", "nothing", "exits", "numpy", "int-refusal", "raising-preset", "mutates")
ENGINES = {name: engine for name, (engine, _) in CASES.items()} | HARMLESS
for _name, _engine in ENGINES.items():
    _engine.name, _engine.presets = _name, named_presets(_engine)  # type: ignore[misc]


def __getattr__(name: str) -> Any:
    if (known := name.removeprefix("ENGINE_").replace("_", "-")) in ENGINES:
        return ENGINES[known]
    raise AttributeError(name)


def install_in(folder: Path) -> Path:
    """Install a distribution with all these engines into a folder for `sys.path`."""
    return install_engines(folder, "misbehaving_engines", ENGINES)


def install_engines(folder: Path, module: str, names: Iterable[str]) -> Path:
    """Install a distribution with the engines that a module has by `ENGINE_name` into a folder for `sys.path`."""
    info = folder / f"{module}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module.replace('_', '-')}\nVersion: 1.0\n")
    points = "".join(f"{name} = {module}:ENGINE_{name.replace('-', '_')}\n" for name in names)
    (info / "entry_points.txt").write_text(f"[conrod.engines]\n{points}")
    return folder
