"""An engine of conrod's core alone, brought by an entry point: exact motion with an error of known size and order.

Its machine is at the crank angle theta + LEAD (omega h)^p where it reports theta. So positions are off by the way that
the exact motion goes in that lead, velocities and accelerations by what its derivatives change, all at order p.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from conrod.comparison.trajectory import BodyStates, BodyTracks, Piece
from conrod.engines.capabilities import ExpectedError
from conrod.engines.engine import PIECE_STEPS, STOCK, Engine, Machine, Preset, step_length
from conrod.engines.numerics import largest_derivatives
from conrod.engines.run import RecordedPiece, observed_tracks, record_pieces
from conrod.exact.motion import Array, Instants

NAME = "planted"
LEAD = 0.5  # [rad], at one step per radian
ORDERS = {STOCK: 1, "sharp": 3}


@dataclass(frozen=True)
class PlantedSettings:
    """Settings of the planted engine."""

    engine: ClassVar[str] = NAME

    preset: str
    steps_per_revolution: int
    timestep: float  # [s]
    order: int = 1

    def time_constant(self, contact: bool) -> float:
        """Time constant [s] of the joints: 0, as they never open."""
        return 0.0

    def as_dict(self) -> dict[str, Any]:
        """All fields as plain values."""
        return asdict(self)

    @property
    def lead(self) -> float:
        """The planted error, as a crank angle [rad]."""
        return float(LEAD * (2.0 * np.pi / self.steps_per_revolution) ** self.order)


def preset(name: str, judged: bool) -> Preset[PlantedSettings]:
    """A preset of an order."""

    def rule(machine: Machine, steps_per_revolution: int, /) -> PlantedSettings:
        step = step_length(machine, steps_per_revolution)
        return PlantedSettings(name, steps_per_revolution, step, ORDERS[name])

    return Preset(rule, judged=judged)


class PlantedEngine(Engine[PlantedSettings]):
    """The generic solver's poses, a little ahead of themselves.

    Attributes:
        step_error: share by which its steps are longer than they are said to be.
        late: steps by which its time stamps are.
    """

    step_error, late = 0.0, 0

    name = NAME
    version = "1.0"
    presets: ClassVar = {STOCK: preset(STOCK, judged=False), "sharp": preset("sharp", judged=True)}

    def refusal(self, machine: Machine, settings: PlantedSettings) -> str | None:
        return "the planted engine knows no contact" if machine.kinematics.mechanism.cam_contacts else None

    def run(
        self,
        machine: Machine,
        settings: PlantedSettings,
        revolutions: float,
        start_angle: float = 0.0,
        steps: int = PIECE_STEPS,
    ) -> Iterator[Piece]:
        kinematics, speed = machine.kinematics, machine.speed * (1.0 + self.step_error)

        def record(_: int, times: Array) -> RecordedPiece:
            poses, slopes, bends = kinematics.derivatives(speed * times + settings.lead, 2)
            stamps = times + self.late * settings.timestep
            instants = Instants(stamps, speed * times, np.full_like(times, speed), np.zeros_like(times))
            states = BodyStates(instants, poses, speed * slopes, speed**2 * bends)
            return RecordedPiece(BodyTracks(states, states, states), observed_tracks(kinematics, states), times)

        return record_pieces(machine, settings, self.version, revolutions, start_angle, steps, record)


class LawfulEngine(PlantedEngine):
    """The same with the law of its errors: the way that a point goes in the lead."""

    def __init__(self, step_error: float = 0.0, late: int = 0) -> None:
        self.step_error, self.late = step_error, late

    def expected_error(self, machine: Machine, settings: PlantedSettings) -> ExpectedError:
        position = settings.lead * largest_derivatives(machine.kinematics, 1)[1]
        return ExpectedError(position, None, None, law="the way gone in the lead")


ENGINE = PlantedEngine()


def install_in(
    folder: Path, value: str = "planted_engine:ENGINE", name: str = NAME, distribution: str = "planted-engine"
) -> Path:
    """Install a distribution with the engine into a folder for `sys.path`, as pip would."""
    info = folder / f"{distribution.replace('-', '_')}-1.0.dist-info"
    info.mkdir(parents=True)
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(f"[conrod.engines]\n{name} = {value}\n")
    return folder
