"""Table of the axes along which engines are driven to their limits.

A new axis is a new row of `AXIS_TABLE`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial

from conrod.comparison.trajectory import Settings
from conrod.engines.engine import with_fields
from conrod.mechanism.units import check_number
from conrod.studies.limits import changed_machines as machines
from conrod.studies.limits.axis import Axis, Scale, Spans
from conrod.studies.limits.case import LimitCase, Setup

FIXED_STEP = 0.6e-3  # [s]; divides the revolutions of 1 rpm and of 50000 rpm, into a hundred thousand and into two
STEPS_AT_ONE_RPM = 60.0 / FIXED_STEP
# Near a change point the motion changes within a small part of a turn: the usual steps would be the first to fail.
NEARNESS_AXIS_STEPS = 5000
# Few steps, so that a thousand revolutions are affordable, and enough for the tuned presets to stay within a hundredth
# of the travel: linkages 7e-6 to 5e-3 over a thousand revolutions, the cam 4e-3 and 5e-3 over ten.
LONG_RUN_LINKAGE_STEPS, LONG_RUN_CONTACT_STEPS = 50, 1000
# 1 - impedance of a contact, at the safe end and at the least that MuJoCo admits (mjMAXIMP).
SAFE_CONTACT_SHARE, MIN_CONTACT_SHARE = 0.5, 1e-4
START_ANGLE_SPACING = 5  # [deg]
SAME_ANGLE = 1e-6  # [deg]; a dead centre this near to another start angle is not run in addition
MAX_ORDERS = 24


# -- functions of the table ------------------------------------------------------------------------------------------


def _count_formatter(noun: str) -> Callable[[Setup, float], str]:
    """Return a function that writes a whole number with a noun whose plural has an s: 2 iterations."""
    return lambda setup, value: f"{round(value)} {noun}{'' if value == 1.0 else 's'}"


def _case_at_fixed_iterations(setup: Setup, ratio: float) -> LimitCase:
    """Return the run with a mass ratio, at the iterations of the unchanged machine."""
    case = setup.case_of_variant(machines.with_mass_ratio(setup, ratio))
    return replace(case, settings=with_fields(case.settings, iterations=_iterations(setup.settings())))


def _iterations(settings: Settings) -> int:
    """Solver iterations that settings allow in a step."""
    return int(settings.as_dict()["iterations"])


def _fixed_iterations_refusal(setup: Setup) -> str | None:
    """Return why a mass ratio at fixed iterations is no separate axis, None if it is one."""
    if reason := machines.mass_ratio_refusal(setup) or setup.variation_refusal():
        return reason
    counts = {_iterations(setup.settings(machines.with_mass_ratio(setup, ratio))) for ratio in (1.0, 1e3)}
    same = f"with iterations of {setup.engine} that follow no masses it is the same as mass-ratio"
    return same if len(counts) == 1 else None


def _share_text(setup: Setup, value: float) -> str:
    """Return a share to three digits."""
    return f"{value:.3g}"


def _steps_at_speed(rpm: float) -> int:
    """Steps per revolution at a crank speed [rpm] and the fixed step."""
    return max(2, round(STEPS_AT_ONE_RPM / rpm))


def _nearest_speed(rpm: float) -> float:
    """Return the nearest speed [rpm] with whole steps per revolution: 100000 / 2, / 3 .."""
    return STEPS_AT_ONE_RPM / _steps_at_speed(rpm)


def _case_at_speed(setup: Setup, rpm: float) -> LimitCase:
    """Return the run at a crank speed [rpm], in the scene's sense of rotation.

    The preload of a cam stays the same multiple of the largest inertia force.
    """
    steps = _steps_at_speed(rpm)
    speed = 2.0 * math.pi / (steps * FIXED_STEP)
    return setup.case_of_variant(setup.variant(speed=math.copysign(speed, setup.scene.speed)), steps)


def _case_near_change_point(setup: Setup, nearness: float) -> LimitCase:
    """Return the run with one length at a share of its limit, at more steps than elsewhere."""
    scene = machines.with_change_point_nearness(setup, nearness)
    return setup.case_of_variant(scene, setup.steps_per_revolution or NEARNESS_AXIS_STEPS)


def _case_of_length(setup: Setup, revolutions: float) -> LimitCase:
    """Return the run over a number of revolutions."""
    steps = LONG_RUN_CONTACT_STEPS if setup.has_contact else LONG_RUN_LINKAGE_STEPS
    return setup.case_with(setup.settings(steps=steps), revolutions=float(round(revolutions)))


def _case_with_time_constant(setup: Setup, steps: float) -> LimitCase:
    """Return the run with a time constant of stabilisation in steps."""
    return setup.case_with(setup.variations.with_time_constant(setup.scene, setup.settings(), steps))


def _time_constant_ends(setup: Setup) -> Spans:
    """Return walks from the preset's time constant up to a revolution and down below a step.

    Either end may fail: hard constraints may be stabilised slowly, soft ones have to be stabilised fast.
    """
    slow, fast = float(setup.steps), AXES["stabilisation"].failing_end
    settings = setup.settings()
    own = min(max(settings.time_constant(setup.has_contact) / settings.timestep, fast), slow)
    return tuple((own, end) for end in (slow, fast) if end != own)


def _case_with_regularisation(setup: Setup, share: float) -> LimitCase:
    """Return the run with a share of regularisation, or with 1 - impedance of a contact.

    Raises:
        InvalidInput: the engine cannot have this impedance.
    """
    if setup.has_contact:
        check_number("regularisation of a contact", share, MIN_CONTACT_SHARE, 1.0)
    settings = setup.variations.with_regularisation(setup.scene, setup.settings(), share)
    assert settings is not None
    return setup.case_with(settings)


def _regularisation_refusal(setup: Setup) -> str | None:
    """Return why an engine's regularisation cannot be varied, None if it can."""
    if setup.variation_refusal():
        return setup.variation_refusal()
    regularised = setup.variations.with_regularisation(setup.scene, setup.settings(), 1.0)
    return f"{setup.engine} does not regularise its constraints" if regularised is None else None


def _start_angles(setup: Setup) -> tuple[float, ...]:
    """Return start angles [deg]: every five degrees, and the dead centres."""
    even = [float(angle) for angle in range(0, 360, START_ANGLE_SPACING)]
    dead = [a for a in machines.dead_centre_angles(setup.scene) if min(abs(a - other) for other in even) > SAME_ANGLE]
    return tuple(sorted([*even, *dead]))


def _flank_excess_text(setup: Setup, value: float) -> str:
    """Return the text of a flank radius over the least one [mm]."""
    return f"{value:.3g} mm over the least" if value > machines.MAX_ONE_CIRCLE_EXCESS else "the least: one circle"


def _declaration_text(setup: Setup, number: float) -> str:
    """List the names of bodies and joints in the order of a number."""
    order = machines.reordered_mechanism(setup, number)
    return "; ".join(", ".join(one.name for one in kind) for kind in (order.bodies, order.joints))


def _one_pass_refusal(rest: str, setup: Setup) -> str | None:
    """Return the reason why an input that makes one pass lacks an axis; None if it has it.

    Args:
        rest: end of the reason, after "the input of ... makes one pass".
    """
    return f"the input of {setup.scene.kind} makes one pass {rest}" if setup.mechanism.driver.span else None


# -- the table -------------------------------------------------------------------------------------------------------

# Settings follow step, masses and lengths along an axis as the preset's rule says. The exact motion depends neither on
# masses nor on units nor on the order of declaration, so these axes show absolute numbers inside an engine.
AXIS_TABLE = (
    Axis(
        "steps", "Steps per revolution", "steps per revolution", Scale.COUNT,
        lambda setup, value: setup.case_with(setup.settings(steps=round(value))),
        safe_end=20000.0, failing_end=2.0, allowed=(2.0, 1e6), ends=lambda setup: ((20000.0, float(setup.min_steps)),),
        text=lambda setup, value: f"{round(value)} steps",
    ),
    Axis(
        "speed", "Crank speed at a fixed step of 0.6 ms", "crank speed [rpm]", Scale.LOG, _case_at_speed,
        safe_end=1.0, failing_end=50000.0, allowed=(1.0, 50000.0),
        ends=lambda setup: ((1.0, min(50000.0, STEPS_AT_ONE_RPM / setup.min_steps)),),
        text=lambda setup, value: f"{_nearest_speed(value):.4g} rpm ({_steps_at_speed(value)} steps)",
        nearest=_nearest_speed,
    ),
    Axis(
        "mass-ratio", "Mass of the slider over that of the rod", "mass of slider : rod", Scale.LOG,
        lambda setup, value: setup.case_of_variant(machines.with_mass_ratio(setup, value)),
        safe_end=1.0, failing_end=1e6, allowed=(1e-6, 1e6),
        missing_reason=machines.mass_ratio_refusal, ends=lambda setup: ((1.0, 1e6), (1.0, 1e-6)),
    ),
    Axis(
        "mass-ratio-at-iterations", "Mass ratio at the iterations of the machine as it is", "mass of slider : rod",
        Scale.LOG, _case_at_fixed_iterations,
        safe_end=1.0, failing_end=1e6, allowed=(1e-6, 1e6),
        missing_reason=_fixed_iterations_refusal, ends=lambda setup: ((1.0, 1e6), (1.0, 1e-6)),
    ),
    Axis(
        "nearness", "Nearness to the change point", "length over its limit (crank : rod, or offset : rod - crank)",
        Scale.NEARNESS,
        _case_near_change_point,
        safe_end=0.1, failing_end=1.0 - 1e-9, allowed=(0.01, 1.0 - 1e-9),
        missing_reason=machines.change_point_refusal,
        text=lambda setup, value: f"{value:.3g}" if value < 0.99 else f"1 - {1.0 - value:.3g}",
    ),
    Axis(
        "stabilisation", "Time constant of stabilisation", "time constant (steps)", Scale.LOG, _case_with_time_constant,
        safe_end=1000.0, failing_end=0.1, allowed=(0.01, 1e6),
        missing_reason=Setup.variation_refusal, ends=_time_constant_ends,
        text=lambda setup, value: f"{value:.4g} steps",
    ),
    Axis(
        "regularisation", "Regularisation left", "share of the engine's own regularisation (contact: 1 - impedance)",
        Scale.LOG, _case_with_regularisation,
        safe_end=1.0, failing_end=1e-15, allowed=(1e-15, 1.0),
        missing_reason=_regularisation_refusal,
        ends=lambda setup: ((SAFE_CONTACT_SHARE, MIN_CONTACT_SHARE) if setup.has_contact else (1.0, 1e-15),),
        text=_share_text,
    ),
    Axis(
        "iterations", "Solver iterations", "iterations allowed in a step", Scale.COUNT,
        lambda setup, value: setup.case_with(with_fields(setup.settings(), iterations=round(value))),
        safe_end=1000.0, failing_end=1.0, allowed=(1.0, 1e5),
        missing_reason=Setup.variation_refusal, text=_count_formatter("iteration"),
    ),
    Axis(
        "run-length", "Length of the run", "revolutions", Scale.COUNT, _case_of_length,
        safe_end=1.0, failing_end=1000.0, allowed=(1.0, 1e6),
        missing_reason=partial(_one_pass_refusal, "and no more"), text=_count_formatter("revolution"),
    ),
    Axis(
        "length-unit", "Unit of length", "numbers of all lengths over those in metres", Scale.LOG,
        lambda setup, value: setup.case_of_variant(setup.variant(**machines.rescaled_parameters(setup.scene, value))),
        safe_end=1.0, failing_end=1e3, allowed=(1e-3, 1e3), ends=lambda setup: ((1.0, 1e3), (1.0, 1e-3)),
        text=lambda setup, value: f"x {value:.4g}",
    ),
    Axis(
        "rounding", "State rounded to single precision", "rounded after each step (0: no, 1: yes)", Scale.LISTED,
        lambda setup, value: setup.case_with(with_fields(setup.settings(), rounded_state=bool(value))),
        missing_reason=Setup.variation_refusal, values=lambda setup: (0.0, 1.0),
        text=lambda setup, value: "single precision" if value else "double precision",
    ),
    Axis(
        "start-pose", "Start pose", "crank angle at the start [deg]", Scale.LISTED,
        lambda setup, value: setup.case_with(start_angle=math.radians(value)),
        missing_reason=partial(_one_pass_refusal, "from its start"), values=_start_angles,
        text=lambda setup, value: f"{value:.5g} deg",
    ),
    Axis(
        "declaration", "Order of declaration", "number of the permutation", Scale.LISTED,
        lambda setup, value: setup.case_with(declared_mechanism=machines.reordered_mechanism(setup, value)),
        values=lambda setup: machines.permutation_numbers(setup, MAX_ORDERS), text=_declaration_text,
    ),
    Axis(
        "float", "Speed against preload", "crank speed over the float speed", Scale.LOG,
        lambda setup, value: setup.case_of_variant(machines.with_float_speed_share(setup, value)),
        safe_end=0.2, failing_end=5.0, allowed=(0.01, 100.0),
        missing_reason=machines.float_refusal, text=lambda setup, value: f"{value:.4g} x the float speed",
    ),
    Axis(
        "flank-radius", "Flank radius towards its minimum", "flank radius over the least one [mm]", Scale.LOG,
        lambda setup, value: setup.case_of_variant(machines.with_flank_excess(setup, value)),
        safe_end=45.5, failing_end=machines.MIN_FLANK_EXCESS, allowed=(machines.MIN_FLANK_EXCESS, 1000.0),
        missing_reason=machines.flank_refusal,
        ends=lambda setup: ((machines.flank_excess(setup), machines.MIN_FLANK_EXCESS),),
        text=_flank_excess_text,
    ),
    Axis(
        "nose-radius", "Nose radius towards zero", "nose radius [mm]", Scale.LOG,
        lambda setup, value: setup.case_of_variant(machines.with_nose_radius(setup, value)),
        safe_end=29.0, failing_end=0.01, allowed=(0.001, 1e6),
        missing_reason=machines.cam_radii_refusal,
        ends=lambda setup: ((setup.scene.parameters["nose_radius"] / machines.MILLIMETRE, 0.01),),
        text=lambda setup, value: f"{value:.3g} mm",
    ),
)  # fmt: skip
AXES: dict[str, Axis] = {axis.name: axis for axis in AXIS_TABLE}
