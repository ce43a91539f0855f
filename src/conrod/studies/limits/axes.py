"""Axes along which engines are driven to their limits: from a value at which all is well to one at which nothing is.

A new axis is a new row of `ROWS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

from conrod.engines.engine import with_fields
from conrod.mechanism.units import check_number
from conrod.runs.trajectory import Settings
from conrod.studies.limits import changed_machines as machines
from conrod.studies.limits.axis import Axis, Scale, Spans
from conrod.studies.limits.case import LimitCase, Setup

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


# -- what the rows need ----------------------------------------------------------------------------------------------


def _counted(noun: str) -> Callable[[Setup, float], str]:
    """Return the text of a whole number and its noun: 1 iteration, 2 iterations."""
    return lambda setup, value: f"{round(value)} {noun}{'' if value == 1.0 else 's'}"


def _at_own_iterations(setup: Setup, ratio: float) -> LimitCase:
    """Return the run with a mass ratio, and the iterations that the preset's rule gives the machine as it is."""
    case = setup.run_of(machines.with_mass_ratio(setup, ratio))
    return replace(case, settings=with_fields(case.settings, iterations=_iterations(setup.settings())))


def _iterations(settings: Settings) -> int:
    return int(settings.as_dict()["iterations"])


def _same_at_own_iterations(setup: Setup) -> str | None:
    if reason := machines.no_mass_ratio(setup) or setup.not_varied():
        return reason
    counts = {_iterations(setup.settings(machines.with_mass_ratio(setup, ratio))) for ratio in (1.0, 1e3)}
    same = f"with iterations of {setup.engine} that follow no masses it is the same as mass-ratio"
    return same if len(counts) == 1 else None


def _short(setup: Setup, value: float) -> str:
    return f"{value:.3g}"


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


def _stabilised(setup: Setup, steps: float) -> LimitCase:
    return setup.run(setup.varied.with_time_constant(setup.scene, setup.settings(), steps))


def _stabilisation_ends(setup: Setup) -> Spans:
    """Return two ways from the preset's own: as slow as a revolution, and shorter than a step.

    Either end may be the failing one: what is hard by itself may be closed slowly, what is soft has to be closed fast.
    """
    slow, fast = float(setup.steps), AXES["stabilisation"].failing_end
    settings = setup.settings()
    own = min(max(settings.time_constant(setup.contact) / settings.timestep, fast), slow)
    return tuple((own, end) for end in (slow, fast) if end != own)


def _regularised(setup: Setup, share: float) -> LimitCase:
    if setup.contact:
        check_number("regularisation of a contact", share, CONTACT_LEAST, 1.0)
    settings = setup.varied.with_regularisation(setup.scene, setup.settings(), share)
    assert settings is not None
    return setup.run(settings)


def _unregularised(setup: Setup) -> str | None:
    if setup.not_varied():
        return setup.not_varied()
    regularised = setup.varied.with_regularisation(setup.scene, setup.settings(), 1.0)
    return f"{setup.engine} does not regularise its constraints" if regularised is None else None


def _starts(setup: Setup) -> tuple[float, ...]:
    """Return every five degrees, and the dead centres, where the output turns back."""
    even = [float(angle) for angle in range(0, 360, SPACING)]
    dead = [a for a in machines.dead_angles(setup.scene) if min(abs(a - other) for other in even) > SAME]
    return tuple(sorted([*even, *dead]))


def _excess(setup: Setup, value: float) -> str:
    return f"{value:.3g} mm over the least" if value > machines.ONE_CIRCLE else "the least: one circle"


def _order(setup: Setup, number: float) -> str:
    order = machines.declared(setup, number)
    return "; ".join(", ".join(one.name for one in kind) for kind in (order.bodies, order.joints))


def _one_pass(rest: str) -> Callable[[Setup], str | None]:
    return lambda setup: (
        f"the input of {setup.scene.kind} makes one pass {rest}" if setup.mechanism.driver.span else None
    )


# -- the table -------------------------------------------------------------------------------------------------------

# A rule of a preset that follows the step, the masses or the lengths follows them on an axis too. The exact motion
# depends on no mass, on no unit and on no order; what an engine keeps in absolute numbers shows.
ROWS = (
    Axis(
        "steps", "Steps per revolution", "steps per revolution", Scale.COUNT,
        lambda setup, value: setup.run(setup.settings(steps=round(value))),
        20000.0, 2.0, (2.0, 1e6), ends=lambda setup: ((20000.0, float(setup.fewest_steps)),),
        text=lambda setup, value: f"{round(value)} steps",
    ),
    Axis(
        "speed", "Crank speed at a fixed step of 0.6 ms", "crank speed [rpm]", Scale.LOG, _at_speed,
        1.0, 50000.0, (1.0, 50000.0), ends=lambda setup: ((1.0, min(50000.0, STEPS_AT_ONE_RPM / setup.fewest_steps)),),
        text=lambda setup, value: f"{_existing_speed(value):.4g} rpm ({_steps_at(value)} steps)",
        nearest=_existing_speed,
    ),
    Axis(
        "mass-ratio", "Mass of the slider over that of the rod", "mass of slider : rod", Scale.LOG,
        lambda setup, value: setup.run_of(machines.with_mass_ratio(setup, value)),
        1.0, 1e6, (1e-6, 1e6), machines.no_mass_ratio, ends=lambda setup: ((1.0, 1e6), (1.0, 1e-6)),
    ),
    Axis(
        "mass-ratio-at-iterations", "Mass ratio at the iterations of the machine as it is", "mass of slider : rod",
        Scale.LOG, _at_own_iterations, 1.0, 1e6, (1e-6, 1e6),
        _same_at_own_iterations, ends=lambda setup: ((1.0, 1e6), (1.0, 1e-6)),
    ),
    Axis(
        "nearness", "Nearness to the change point", "length over its limit (crank : rod, or offset : rod - crank)",
        Scale.NEARNESS,
        lambda s, value: s.run_of(machines.near_change_point(s, value), s.steps_per_revolution or NEARNESS_STEPS),
        0.1, 1.0 - 1e-9, (0.01, 1.0 - 1e-9), machines.no_change_point,
        text=lambda setup, value: f"{value:.3g}" if value < 0.99 else f"1 - {1.0 - value:.3g}",
    ),
    Axis(
        "stabilisation", "Time constant of stabilisation", "time constant (steps)", Scale.LOG, _stabilised,
        1000.0, 0.1, (0.01, 1e6), Setup.not_varied, ends=_stabilisation_ends,
        text=lambda setup, value: f"{value:.4g} steps",
    ),
    Axis(
        "regularisation", "Regularisation left", "share of the engine's own regularisation (contact: 1 - impedance)",
        Scale.LOG, _regularised, 1.0, 1e-15, (1e-15, 1.0), _unregularised,
        ends=lambda setup: ((CONTACT_SAFE, CONTACT_LEAST) if setup.contact else (1.0, 1e-15),), text=_short,
    ),
    Axis(
        "iterations", "Solver iterations", "iterations allowed in a step", Scale.COUNT,
        lambda setup, value: setup.run(with_fields(setup.settings(), iterations=round(value))),
        1000.0, 1.0, (1.0, 1e5), Setup.not_varied, text=_counted("iteration"),
    ),
    Axis(
        "run-length", "Length of the run", "revolutions", Scale.COUNT, _of_length,
        1.0, 1000.0, (1.0, 1e6), _one_pass("and no more"), text=_counted("revolution"),
    ),
    Axis(
        "length-unit", "Unit of length", "numbers of all lengths over those in metres", Scale.LOG,
        lambda setup, value: setup.run_of(setup.variant(**machines.rescaled(setup.scene, value))),
        1.0, 1e3, (1e-3, 1e3), ends=lambda setup: ((1.0, 1e3), (1.0, 1e-3)),
        text=lambda setup, value: f"x {value:.4g}",
    ),
    Axis(
        "rounding", "State rounded to single precision", "rounded after each step (0: no, 1: yes)", Scale.LISTED,
        lambda setup, value: setup.run(with_fields(setup.settings(), rounded_state=bool(value))),
        lacks=Setup.not_varied, values=lambda setup: (0.0, 1.0),
        text=lambda setup, value: "single precision" if value else "double precision",
    ),
    Axis(
        "start-pose", "Start pose", "crank angle at the start [deg]", Scale.LISTED,
        lambda setup, value: setup.run(start_angle=math.radians(value)),
        lacks=_one_pass("from its start"), values=_starts, text=lambda setup, value: f"{value:.5g} deg",
    ),
    Axis(
        "declaration", "Order of declaration", "number of the permutation", Scale.LISTED,
        lambda setup, value: setup.run(declared=machines.declared(setup, value)),
        values=lambda setup: machines.orders(setup, MOST_ORDERS), text=_order,
    ),
    Axis(
        "float", "Speed against preload", "crank speed over the float speed", Scale.LOG,
        lambda setup, value: setup.run_of(machines.at_float_speed(setup, value)),
        0.2, 5.0, (0.01, 100.0), machines.no_float, text=lambda setup, value: f"{value:.4g} x the float speed",
    ),
    Axis(
        "flank-radius", "Flank radius towards its minimum", "flank radius over the least one [mm]", Scale.LOG,
        lambda setup, value: setup.run_of(machines.with_flank(setup, value)),
        45.5, machines.LEAST_EXCESS, (machines.LEAST_EXCESS, 1000.0), machines.no_flank,
        ends=lambda setup: ((machines.flank_excess(setup), machines.LEAST_EXCESS),),
        text=_excess,
    ),
    Axis(
        "nose-radius", "Nose radius towards zero", "nose radius [mm]", Scale.LOG,
        lambda setup, value: setup.run_of(machines.with_nose(setup, value)),
        29.0, 0.01, (0.001, 1e6), machines.no_such_cam,
        ends=lambda setup: ((setup.scene.parameters["nose_radius"] / machines.MM, 0.01),),
        text=lambda setup, value: f"{value:.3g} mm",
    ),
)  # fmt: skip
AXES: dict[str, Axis] = {axis.name: axis for axis in ROWS}
