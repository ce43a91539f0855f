"""The table of axes along which engines are driven to their limits. A new axis is a new row."""

from __future__ import annotations

import math
from collections.abc import Callable

from conrod.mechanism.units import check_number
from conrod.studies.limits.axis import Axis, Scale, Spans
from conrod.studies.limits.case import LimitCase, Setup
from conrod.studies.limits.changed_machines import (
    LEAST_EXCESS,
    MM,
    ONE_CIRCLE,
    at_float_speed,
    dead_angles,
    declared,
    flank_excess,
    near_change_point,
    no_change_point,
    no_flank,
    no_float,
    no_mass_ratio,
    no_such_cam,
    orders,
    rescaled,
    with_flank,
    with_mass_ratio,
    with_nose,
)

STEP = 0.6e-3  # [s]; divides the revolutions of 1 rpm and of 50000 rpm, into a hundred thousand and into two
STEPS_AT_ONE_RPM = 60.0 / STEP
# Near a change point all happens within a small part of a turn: with the usual steps nothing holds as far as it could.
NEARNESS_STEPS = 5000
# So few that very many revolutions are affordable, and so many that the tuned presets are still within a hundredth: of
# the linkages' travel 7e-6 to 5e-3 over a thousand revolutions, of the cam's 4e-3 and 5e-3 over ten.
LONG_LINKAGE_STEPS, LONG_CONTACT_STEPS = 50, 1000
# Of a contact's impedance, its distance from one; MuJoCo admits no less than the second (mjMAXIMP).
CONTACT_SAFE, CONTACT_LEAST = 0.5, 1e-4
SPACING = 5  # of start poses [deg]
SAME = 1e-6  # [deg], as close as a dead centre may lie to one of the others and not be run beside it
MOST_ORDERS = 24
UNITS = {-3: "km", 0: "m", 2: "cm", 3: "mm"}


def counted(value: float, noun: str) -> str:
    """Return a whole number and its noun: 1 step, 2 steps."""
    return f"{round(value)} {noun}{'' if value == 1.0 else 's'}"


# -- speed and length of a run ---------------------------------------------------------------------------------------


def _steps_at(rpm: float) -> int:
    return max(2, round(STEPS_AT_ONE_RPM / rpm))


def _existing_speed(rpm: float) -> float:
    """Return the nearest speed at which a revolution has a whole number of steps: 100000 rpm over 2, 3, 4 .."""
    return STEPS_AT_ONE_RPM / _steps_at(rpm)


def _at_speed(setup: Setup, rpm: float) -> LimitCase:
    """Return the run at a speed, in the scene's own sense. A cam's preload stays the multiple that it is."""
    steps = _steps_at(rpm)
    speed = 2.0 * math.pi / (steps * STEP)
    return setup.run_of(setup.variant(speed=math.copysign(speed, setup.scene.speed)), steps)


def _of_length(setup: Setup, revolutions: float) -> LimitCase:
    steps = LONG_CONTACT_STEPS if setup.contact else LONG_LINKAGE_STEPS
    return setup.run(setup.settings(steps=steps), revolutions=float(round(revolutions)))


# -- solver ----------------------------------------------------------------------------------------------------------


def _stabilised(setup: Setup, steps: float) -> LimitCase:
    return setup.run(setup.variations.stabilised(setup.scene, setup.settings(), steps))


def _stabilisation_ends(setup: Setup) -> Spans:
    """Return two ways from the preset's own: as slow as a revolution, and shorter than a step.

    Either end may be the failing one: what is hard by itself may be closed slowly, what is soft has to be closed fast.
    """
    slow, fast = float(setup.steps), AXES["stabilisation"].failing_end
    settings = setup.settings()
    own = min(max(settings.time_constant(setup.contact) / settings.timestep, fast), slow)
    return tuple((own, end) for end in (slow, fast) if end != own)


def _time_constant(setup: Setup, steps: float) -> str:
    # An engine that cannot express so short a time corrects all at once.
    at_once = _stabilised(setup, steps).settings.time_constant(setup.contact) == 0.0
    return f"{steps:.4g} steps" + (" (all at once)" if at_once else "")


def _regularised(setup: Setup, share: float) -> LimitCase:
    if setup.contact:
        check_number("regularisation of a contact", share, CONTACT_LEAST, 1.0)
    settings = setup.variations.regularised(setup.scene, setup.settings(), share)
    assert settings is not None
    return setup.run(settings)


def _unregularised(setup: Setup) -> str | None:
    if setup.not_varied:
        return setup.not_varied
    regularised = setup.variations.regularised(setup.scene, setup.settings(), 1.0)
    return f"{setup.engine} does not regularise its constraints" if regularised is None else None


# -- machine ---------------------------------------------------------------------------------------------------------


def _near_change_point(setup: Setup, nearness: float) -> LimitCase:
    return setup.run_of(near_change_point(setup, nearness), setup.steps_per_revolution or NEARNESS_STEPS)


def _unit(setup: Setup, factor: float) -> str:
    decades = math.log10(factor)
    unit = UNITS.get(round(decades)) if abs(decades - round(decades)) < 1e-9 else None
    return f"x {factor:.4g}" + (f" (in {unit})" if unit else "")


def _starts(setup: Setup) -> tuple[float, ...]:
    """Return every five degrees, and the dead centres, where the output turns back."""
    even = [float(angle) for angle in range(0, 360, SPACING)]
    dead = [a for a in dead_angles(setup.scene) if min(abs(a - other) for other in even) > SAME]
    return tuple(sorted([*even, *dead]))


def _start(setup: Setup, degrees: float) -> str:
    dead = min((abs(degrees - angle) for angle in dead_angles(setup.scene)), default=math.inf) <= SAME
    return f"{degrees:.5g} deg" + (" (dead centre)" if dead else "")


def _order(setup: Setup, number: float) -> str:
    order = declared(setup, number)
    return f"{', '.join(order.bodies)}; {', '.join(order.joints)}"


def _one_pass(rest: str) -> Callable[[Setup], str | None]:
    return lambda setup: f"the input of {setup.scene.kind} makes one pass {rest}" if setup.one_pass else None


# -- the table -------------------------------------------------------------------------------------------------------

# A rule of a preset that follows the step, the masses or the lengths follows them on an axis too. The exact motion
# depends on no mass, on no unit and on no order; what an engine keeps in absolute numbers shows.
ROWS = (
    Axis(
        name="steps",
        title="Steps per revolution",
        label="steps per revolution",
        scale=Scale.COUNT,
        safe_end=20000.0,
        failing_end=2.0,
        allowed=(2.0, 1e6),
        ends=lambda setup: ((20000.0, float(setup.fewest_steps)),),
        case=lambda setup, value: setup.run(setup.settings(steps=round(value))),
        text=lambda setup, value: f"{round(value)} steps",
    ),
    Axis(
        name="speed",
        title="Crank speed at a fixed step of 0.6 ms",
        label="crank speed (rpm)",
        scale=Scale.LOG,
        safe_end=1.0,
        failing_end=50000.0,
        allowed=(1.0, 50000.0),
        ends=lambda setup: ((1.0, min(50000.0, STEPS_AT_ONE_RPM / setup.fewest_steps)),),
        case=_at_speed,
        nearest=_existing_speed,
        text=lambda setup, value: f"{_existing_speed(value):.4g} rpm ({_steps_at(value)} steps)",
    ),
    Axis(
        name="mass-ratio",
        title="Mass of the slider over that of the rod",
        label="mass of slider : rod",
        scale=Scale.LOG,
        safe_end=1.0,
        failing_end=1e6,
        allowed=(1e-6, 1e6),
        lacks=no_mass_ratio,
        ends=lambda setup: ((1.0, 1e6), (1.0, 1e-6)),
        case=lambda setup, value: setup.run_of(with_mass_ratio(setup, value)),
    ),
    Axis(
        name="nearness",
        title="Nearness to the change point",
        label="length over its limit (crank : rod, or offset : rod - crank)",
        scale=Scale.NEARNESS,
        safe_end=0.1,
        failing_end=1.0 - 1e-9,
        allowed=(0.01, 1.0 - 1e-9),
        lacks=no_change_point,
        case=_near_change_point,
        text=lambda setup, value: f"{value:.3g}" if value < 0.99 else f"1 - {1.0 - value:.3g}",
        near_singular=True,
    ),
    Axis(
        name="stabilisation",
        title="Time constant of stabilisation",
        label="time constant (steps)",
        scale=Scale.LOG,
        safe_end=1000.0,
        failing_end=0.1,
        allowed=(0.01, 1e6),
        ends=_stabilisation_ends,
        lacks=lambda setup: setup.not_varied,
        case=_stabilised,
        text=_time_constant,
    ),
    Axis(
        name="regularisation",
        title="Regularisation left",
        label="share of the engine's own regularisation (contact: 1 - impedance)",
        scale=Scale.LOG,
        safe_end=1.0,
        failing_end=1e-15,
        allowed=(1e-15, 1.0),
        lacks=_unregularised,
        ends=lambda setup: ((CONTACT_SAFE, CONTACT_LEAST) if setup.contact else (1.0, 1e-15),),
        case=_regularised,
        text=lambda setup, value: f"{value:.3g}",
    ),
    Axis(
        name="iterations",
        title="Solver iterations",
        label="iterations allowed in a step",
        scale=Scale.COUNT,
        safe_end=1000.0,
        failing_end=1.0,
        allowed=(1.0, 1e5),
        lacks=lambda setup: setup.not_varied,
        case=lambda setup, value: setup.run(setup.variations.iterated(setup.settings(), round(value))),
        text=lambda setup, value: counted(value, "iteration"),
    ),
    Axis(
        name="run-length",
        title="Length of the run",
        label="revolutions",
        scale=Scale.COUNT,
        safe_end=1.0,
        failing_end=1000.0,
        allowed=(1.0, 1e6),
        lacks=_one_pass("and no more"),
        case=_of_length,
        text=lambda setup, value: counted(value, "revolution"),
    ),
    Axis(
        name="length-unit",
        title="Unit of length",
        label="numbers of all lengths over those in metres",
        scale=Scale.LOG,
        safe_end=1.0,
        failing_end=1e3,
        allowed=(1e-3, 1e3),
        ends=lambda setup: ((1.0, 1e3), (1.0, 1e-3)),
        case=lambda setup, value: setup.run_of(setup.variant(**rescaled(setup.scene, value))),
        text=_unit,
    ),
    Axis(
        name="rounding",
        title="State rounded to single precision",
        label="rounded after each step (0: no, 1: yes)",
        scale=Scale.LISTED,
        values=lambda setup: (0.0, 1.0),
        lacks=lambda setup: setup.not_varied,
        case=lambda setup, value: setup.run(setup.variations.rounded(setup.settings(), bool(value))),
        text=lambda setup, value: "single precision" if value else "double precision",
    ),
    Axis(
        name="start-pose",
        title="Start pose",
        label="crank angle at the start (deg)",
        scale=Scale.LISTED,
        lacks=_one_pass("from its start"),
        values=_starts,
        case=lambda setup, value: setup.run(start_angle=math.radians(value)),
        text=_start,
    ),
    Axis(
        name="declaration",
        title="Order of declaration",
        label="number of the permutation",
        scale=Scale.LISTED,
        values=lambda setup: orders(setup, MOST_ORDERS),
        case=lambda setup, value: setup.run(declaration=declared(setup, value)),
        text=_order,
    ),
    Axis(
        name="float",
        title="Speed against preload",
        label="crank speed over the float speed",
        scale=Scale.LOG,
        safe_end=0.2,
        failing_end=5.0,
        allowed=(0.01, 100.0),
        lacks=no_float,
        case=lambda setup, value: setup.run_of(at_float_speed(setup, value)),
        text=lambda setup, value: f"{value:.4g} x the float speed",
    ),
    Axis(
        name="flank-radius",
        title="Flank radius towards its minimum",
        label="flank radius over the least one (mm)",
        scale=Scale.LOG,
        safe_end=45.5,
        failing_end=LEAST_EXCESS,
        allowed=(LEAST_EXCESS, 1000.0),
        lacks=no_flank,
        ends=lambda setup: ((flank_excess(setup), LEAST_EXCESS),),
        case=lambda setup, value: setup.run_of(with_flank(setup, value)),
        text=lambda setup, value: f"{value:.3g} mm over the least" if value > ONE_CIRCLE else "the least: one circle",
    ),
    Axis(
        name="nose-radius",
        title="Nose radius towards zero",
        label="nose radius (mm)",
        scale=Scale.LOG,
        safe_end=29.0,
        failing_end=0.01,
        allowed=(0.001, 1e6),
        lacks=no_such_cam,
        ends=lambda setup: ((setup.scene.parameters["nose_radius"] / MM, 0.01),),
        case=lambda setup, value: setup.run_of(with_nose(setup, value)),
        text=lambda setup, value: f"{value:.3g} mm",
    ),
)
AXES: dict[str, Axis] = {axis.name: axis for axis in ROWS}
# One run of it shows all shorter ones, so it is not walked as the others are.
LENGTH_AXIS = "run-length"
