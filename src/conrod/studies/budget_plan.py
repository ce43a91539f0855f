"""The runs that tell iteration, step and softness apart: each varied alone from one setting."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

from conrod.engines.mujoco.hardening import HARDENING
from conrod.engines.mujoco.settings import MuJoCoSettings
from conrod.engines.pymunk.settings import STOCK_BIAS, PymunkSettings
from conrod.errors import InvalidInput
from conrod.scenes import Scene
from conrod.studies.cell import Cell
from conrod.studies.refinement import refined
from conrod.trajectory import Settings

BUDGET_ANGLES = 100
FINENESS = 16  # the finest step is the given one over this, the one before it twice as long
# Iterations that stand for infinitely many. MuJoCo's Newton method needs one where only joints act. Gauss-Seidel, as in
# pymunk, gains digits in proportion, so a multiple of what the tuned preset takes from the masses. Both are checked.
NEWTON_ITERATIONS, ENOUGH_ITERATIONS = 1000, 4
LEAST_HARDENING = 1e-15
LEAST_CONSTANT = 2.0  # in steps; MuJoCo raises a shorter time constant to this

REGULARISATION, STABILISATION = "regularisation", "stabilisation"
AS_IS, CONVERGED, TWICE, FINER, FINEST = "as is", "converged", "converged twice", "finer", "finest"


@dataclass(frozen=True)
class BudgetPlan:
    """The runs of an error budget.

    Attributes:
        cells: by role. `as is`; `converged` and `converged twice`: with infinitely many iterations and with twice
            that; `finer` and `finest`: converged, at half the fineness and at all of it, softness fixed in seconds.
            `<knob>`, `<knob> finer` and `<knob> finest`: converged, with the softness of one knob varied.
        changes: by knob, the settings that it changes: from and to.
    """

    name: str
    cells: Mapping[str, Cell]
    changes: Mapping[str, Mapping[str, tuple[Any, Any]]]


def budget_plan_of(name: str, scene: Scene, settings: Settings, fineness: int = FINENESS) -> BudgetPlan:
    """The runs that an error budget of one setting needs.

    Args:
        name: of the scene.
        settings: with a number of steps per revolution that is a multiple of 100, the angles that are compared.
        fineness: an even number; how much finer the step is that stands for none.

    Raises:
        InvalidInput: steps that miss the angles, or a fineness that is odd.
    """
    steps = settings.steps_per_revolution
    if steps % BUDGET_ANGLES:
        raise InvalidInput(f"steps_per_revolution = {steps} must be a multiple of {BUDGET_ANGLES} for an error budget")
    if fineness < 2 or fineness % 2:
        raise InvalidInput(f"fineness = {fineness} must be an even number")

    def cell(chosen: Settings, finer: int = 1) -> Cell:
        return Cell(name, scene, refined(scene, chosen, finer * steps), signed_angles=BUDGET_ANGLES)

    solved = converged(scene, settings)
    cells = {
        AS_IS: Cell(name, scene, settings, signed_angles=BUDGET_ANGLES),
        CONVERGED: cell(solved),
        TWICE: cell(converged(scene, settings, 2)),
        FINER: cell(solved, fineness // 2),
        FINEST: cell(solved, fineness),
    }
    changes = {}
    for knob, varied in (
        (REGULARISATION, less_regularised(scene, solved)),
        (STABILISATION, restabilised(scene, solved)),
    ):
        if varied is not None:
            cells |= {knob: cell(varied), f"{knob} finer": cell(varied, fineness // 2)}
            cells[f"{knob} finest"] = cell(varied, fineness)
            changes[knob] = _changes(solved, varied)
    return BudgetPlan(name, cells, changes)


def converged(scene: Scene, settings: Settings, times: int = 1) -> Settings:
    """With as many iterations as stand for infinitely many, or a multiple of them.

    Raises:
        TypeError: settings of an engine that is not known here.
    """
    match settings:
        case MuJoCoSettings():
            iterations = times * max(NEWTON_ITERATIONS, settings.iterations)
            return replace(settings, preset="custom", solver="Newton", iterations=iterations, tolerance=0.0)
        case PymunkSettings():
            needed = PymunkSettings.tuned(scene, settings.steps_per_revolution).iterations
            iterations = times * ENOUGH_ITERATIONS * max(needed, settings.iterations)
            return replace(settings, preset="custom", iterations=iterations)
        case _:
            raise TypeError(f"no error budget for settings of {settings.engine!r}")


def less_regularised(scene: Scene, settings: Settings) -> Settings | None:
    """With less regularisation, all else kept; None where there is none.

    MuJoCo's loops are hardened, or hardened ten times further. Hardening is not for contact, whose impedance comes
    half the way nearer to one instead. pymunk's joints have none; of its contacts the slop is halved.
    """
    contact = bool(scene.kinematics.mechanism.cam_contacts)
    match settings:
        case MuJoCoSettings() if contact:
            return replace(settings, contact_solimp=_stiffer(settings.contact_solimp))
        case MuJoCoSettings():
            further = None if settings.hardening is None else max(settings.hardening / 10.0, LEAST_HARDENING)
            return replace(settings, hardening=further or HARDENING)
        case PymunkSettings() if contact and settings.collision_slop > 0.0:
            return replace(settings, collision_slop=0.5 * settings.collision_slop)
        case _:
            return None


def restabilised(scene: Scene, settings: Settings) -> Settings | None:
    """With another stabilisation of what closes the loops or of the contacts, all else kept.

    MuJoCo: half the time constant, or twice where half would be less than it admits. pymunk: no bias, so that errors
    are mended whole at every step; the default bias where that is so already.
    """
    contact = bool(scene.kinematics.mechanism.cam_contacts)
    match settings:
        case MuJoCoSettings() if contact:
            return replace(settings, contact_solref=_other_constant(settings.contact_solref, settings.timestep))
        case MuJoCoSettings():
            return replace(settings, solref=_other_constant(settings.solref, settings.timestep))
        case PymunkSettings() if contact:
            return replace(settings, collision_bias=_other_bias(settings.collision_bias))
        case PymunkSettings():
            return replace(settings, error_bias=_other_bias(settings.error_bias))
        case _:
            return None


def _other_bias(bias: float) -> float:
    return 0.0 if bias > 0.0 else STOCK_BIAS


def _stiffer(solimp: tuple[float, float, float, float, float]) -> tuple[float, float, float, float, float]:
    return (0.5 * (1.0 + solimp[0]), 0.5 * (1.0 + solimp[1]), *solimp[2:])


def _other_constant(solref: tuple[float, float], timestep: float) -> tuple[float, float]:
    constant, damping = solref
    if constant <= 0.0:  # MuJoCo's other form, minus stiffness and minus damping: half the constant is 4 and 2 times
        return 4.0 * constant, 2.0 * damping
    return (0.5 if 0.5 * constant >= LEAST_CONSTANT * timestep else 2.0) * constant, damping


def _changes(before: Settings, after: Settings) -> dict[str, tuple[Any, Any]]:
    old, new = before.as_dict(), after.as_dict()
    return {key: (old[key], new[key]) for key in old if old[key] != new[key]}
