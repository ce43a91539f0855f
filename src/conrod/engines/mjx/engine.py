"""MJX, as one of conrod's engines."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import version

from conrod.engines.engine import DOUBLE, PIECE, SINGLE, Engine, Machine
from conrod.engines.mjx import law, rollout
from conrod.engines.mjx.settings import PRESETS, MJXSettings
from conrod.engines.mujoco import dynamics
from conrod.engines.mujoco.engine import ENGINE as MUJOCO
from conrod.engines.mujoco.model import build
from conrod.runs.trajectory import Piece


class MJX(Engine[MJXSettings]):
    """MuJoCo's algorithms in JAX, on models that MuJoCo has compiled."""

    name = "mjx"
    version = version("mujoco-mjx")
    presets = PRESETS
    expected_error = staticmethod(law.expected_error)
    stepper = staticmethod(rollout.stepper)
    reference_loop = staticmethod(rollout.reference_loop)

    def refusal(self, machine: Machine, settings: MJXSettings) -> str | None:
        if machine.kinematics.mechanism.cam_contacts:
            return "mjx looks at every face of a mesh in every step: no cams, which have thousands"
        if settings.rounded_state or settings.autoreset:
            return "mjx neither rounds its state nor resets it"
        if reason := MUJOCO.refusal(machine, settings):
            return reason
        made = build(machine, settings)
        try:
            rollout.put(made, *made.start_state(machine, 0.0), settings.precision == "double")
        except NotImplementedError as lacking:
            return f"mjx lacks what the model has: {lacking}"
        return None

    def run(
        self, machine: Machine, settings: MJXSettings, revolutions: float, start_angle: float = 0.0, steps: int = PIECE
    ) -> Iterator[Piece]:
        made = build(machine, settings)
        recorder = rollout.Recorder(made, settings, *made.start_state(machine, start_angle))
        yield from dynamics.recorded(made, recorder, machine, settings, revolutions, start_angle, steps, self.version)

    def spacing(self, settings: MJXSettings) -> float:
        return DOUBLE if settings.precision == "double" else SINGLE


ENGINE = MJX()
