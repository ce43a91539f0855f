"""The grid of pymunk settings that a sweep varies. Imports no engine."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import product

from conrod.engines.engine import Machine, as_preset
from conrod.engines.massless_rod import BODY, ROD_FORMS
from conrod.engines.pymunk.settings import PRESETS, STOCK_BIAS, PymunkSettings
from conrod.engines.rule import Grid, Rule, distinct, texts_of

# Share of an error that is left after a second: Chipmunk's default, the same for a machine ten times as fast, none.
BIASES = {"stock": STOCK_BIAS, "stock^10": STOCK_BIAS**10, "0": 0.0}
STOCK_SLOP = 0.1  # [m]
AS_TUNED = "tuned"  # a knob that stands where the preset's rule puts it


@dataclass(frozen=True)
class JointRule(Rule):
    """Settings of a machine whose links are held by joints."""

    iterations: str = "10"
    error_bias: str = "stock"
    rod: str = BODY

    @property
    def name(self) -> str:
        words = [f"error_bias {self.error_bias}", _iterations(self.iterations)]
        return ", ".join(words + ([f"rod as {self.rod}"] if self.rod != BODY else []))

    @property
    def softness_follows_step(self) -> bool:
        # Without a bias a joint is mended whole at every step, so its softness is the step's; a bias is per second.
        return self.error_bias == "0"

    def knobs(self) -> dict[str, str]:
        return texts_of(self)

    def settings(self, machine: Machine, steps_per_revolution: int) -> PymunkSettings:
        tuned = PymunkSettings.tuned(machine, steps_per_revolution)
        made = replace(
            PymunkSettings.stock(machine, steps_per_revolution),
            preset="custom",
            iterations=tuned.iterations if self.iterations == AS_TUNED else int(self.iterations),
            error_bias=BIASES[self.error_bias],
            rod=self.rod,
        )
        # What concerns contact has no part in a machine without one, and must not keep it from being a preset.
        if self.error_bias == "0":
            made = replace(made, collision_bias=0.0, collision_slop=tuned.collision_slop)
        return as_preset(made, PRESETS, machine)


@dataclass(frozen=True)
class ContactRule(Rule):
    """Settings of a machine with a cam that its follower is kept on by contact."""

    slop: str = AS_TUNED  # overlap that a contact may keep
    bias: str = "0"
    iterations: str = AS_TUNED
    vertices: int = 4000

    @property
    def name(self) -> str:
        slop = {AS_TUNED: "slop half a fall a step", "stock": "slop 0.1 m", "0": "slop 0"}[self.slop]
        words = [slop, f"collision_bias {self.bias}", _iterations(self.iterations)]
        return ", ".join(words + ([f"{self.vertices} vertices"] if self.vertices != 4000 else []))

    @property
    def softness_follows_step(self) -> bool:
        return self.bias == "0" and self.slop != "stock"

    def knobs(self) -> dict[str, str]:
        return texts_of(self)

    def settings(self, machine: Machine, steps_per_revolution: int) -> PymunkSettings:
        tuned = PymunkSettings.tuned(machine, steps_per_revolution)
        slops = {AS_TUNED: tuned.collision_slop, "stock": STOCK_SLOP, "0": 0.0}
        made = replace(
            PymunkSettings.stock(machine, steps_per_revolution),
            preset="custom",
            iterations=tuned.iterations if self.iterations == AS_TUNED else int(self.iterations),
            error_bias=BIASES[self.bias],
            collision_bias=BIASES[self.bias],
            collision_slop=slops[self.slop],
            cam_vertices=self.vertices,
        )
        return as_preset(made, PRESETS, machine)


def rules(machine: Machine, grid: Grid) -> tuple[Rule, ...]:
    """All rules of a grid, without repetition."""
    return _contact_rules(grid) if machine.kinematics.mechanism.cam_contacts else _joint_rules(grid)


def _joint_rules(grid: Grid) -> tuple[Rule, ...]:
    presets = (JointRule(), JointRule(AS_TUNED, "0"))
    if grid == "coarse":
        return presets
    counts = ("1", "3", "10", "30", "100", AS_TUNED) + (("300", "1000") if grid == "fine" else ())
    found = [JointRule(*knobs) for knobs in product(counts, BIASES, ROD_FORMS)]
    return distinct([*presets, *found])


def _contact_rules(grid: Grid) -> tuple[Rule, ...]:
    tuned = ContactRule()
    presets = (ContactRule("stock", "stock", "10"), tuned)
    if grid == "coarse":
        return presets
    counts = ("1", "10", AS_TUNED) + (("100",) if grid == "fine" else ())
    found = [ContactRule(*knobs) for knobs in product(("stock", "0", AS_TUNED), ("stock", "0"), counts)]
    return distinct([*presets, *found, *(replace(tuned, vertices=n) for n in (250, 1000))])


def _iterations(text: str) -> str:
    return "16 (1 + mass ratio) iterations" if text == AS_TUNED else f"{text} iterations"
