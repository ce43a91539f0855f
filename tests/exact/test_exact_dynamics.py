"""Exact dynamics: two derivations of a torque agree, energy is kept, known free motions are met, defects are seen."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from catalogue import SCENES
from free_machines import chain
from linkages import four_bar
from linkages import slider_crank as slider_crank_from
from scipy.special import ellipj, ellipk
from threadpoolctl import threadpool_info, threadpool_limits

from conrod.errors import InvalidInput
from conrod.exact.dynamics import configuration_series, coordinate_jet
from conrod.exact.dynamics.configuration_series import ConfigurationSeries
from conrod.exact.dynamics.curve_piece import CurvePiece
from conrod.exact.dynamics.forward import ForwardDynamics, FreeMotion
from conrod.exact.dynamics.inverse import TORQUE, joint_forces, sensitivities
from conrod.exact.joint_equations import pose_jets
from conrod.exact.kinematics import Kinematics
from conrod.exact.motion import Array, Instants
from conrod.mechanism.loads import (
    Displacement,
    Distance,
    Elastic,
    Friction,
    Load,
    LoadLaw,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import GROUND, Body, ConstantForce, Driver, Mechanism, ObservedPoint, Revolute, Rolling
from conrod.scenes import catalogue_scene

GRAVITY = (0.0, -9.81)
MACHINES = ("six-bar", "two-slider-linkage", "inverted-slider-crank", "planetary-gear", "rack-and-wheel", "cam-3-4-5")


@cache
def kinematics_of(name: str) -> tuple[Kinematics, float]:
    scene = SCENES[name] if name in SCENES else catalogue_scene(name)
    return scene.kinematics, scene.speed


def random_loads(mechanism: Mechanism, seed: int) -> Mechanism:
    """The mechanism with one load of each law between bodies by chance."""
    chance = np.random.default_rng(seed)
    names = [GROUND, *(body.name for body in mechanism.bodies)]
    laws: list[LoadLaw] = [
        Elastic(300.0, 0.1), Viscous(3.0), Steady(5.0), Friction(2.0, 0.1), TimePulse(4.0, 0.0, 0.5),
        SpeedLine(2.0, 30.0), StrokePulse(20.0, -0.1, 0.3, 1),
    ]  # fmt: skip
    loads = []
    for k, law in enumerate(laws):
        a, b = chance.choice(names, 2, replace=False)
        far = tuple(chance.uniform(-0.1, 0.1, 2))
        along = [
            Turn(a, b),
            Distance(a, b, far, (0.7, -0.4)),
            Displacement(str(names[1 + k % (len(names) - 1)]), far, 0.4),
        ]
        loads.append(Load(f"load {k}", along[k % 3], law))
    return replace(mechanism, loads=tuple(loads))


def some_states(kinematics: Kinematics, speed: float) -> Instants:
    angle = np.linspace(*kinematics.span, 7)[1:-1] + 0.01
    angle = angle[~kinematics.near_change(angle, 0.05)]
    return Instants(angle * 0.1, angle, np.full(len(angle), speed), np.linspace(-1.0, 2.0, len(angle)) * speed**2)


def torque_from_energy(kinematics: Kinematics, state: Instants) -> Array:
    """The drive's torque (T,) [N m] in the sense of the crank angle, by the balance of power over the crank's rate.

    T theta' = d(kinetic energy)/dt - power of weight, constant forces and loads. At rest the limit is taken:
    virtual work at rate 1 with the accelerations as they are.
    """
    poses, first, second = kinematics.derivatives(state.angle, 2)
    mechanism = kinematics.mechanism
    rate, acceleration = state.rate, state.acceleration
    along = pose_jets(mechanism, [poses, first, 0.5 * second])
    constant = {force.body: force.force for force in mechanism.forces}
    torque = np.zeros(len(poses))
    for body in mechanism.bodies:
        pose, push = along[body.name], constant.get(body.name, (0.0, 0.0))
        x, y = (jet.coefficients for jet in pose.point(body.centre_of_gravity))
        turn = pose.phi.coefficients
        fx, fy = body.mass * mechanism.gravity[0] + push[0], body.mass * mechanism.gravity[1] + push[1]
        # Kinetic energy inertia(theta) theta'^2 / 2 has the rate (inertia theta'' + inertia' theta'^2 / 2) theta'.
        inertia = body.mass * (x[1] ** 2 + y[1] ** 2) + body.inertia * turn[1] ** 2
        half_slope = 2.0 * (body.mass * (x[1] * x[2] + y[1] * y[2]) + body.inertia * turn[1] * turn[2])
        torque += inertia * acceleration + half_slope * rate**2 - fx * x[1] - fy * y[1]
    for load in mechanism.loads:
        value, slope = coordinate_jet(load.along, along).coefficients[:2]
        torque -= load.law.force(np.asarray(value), np.asarray(slope * rate), state.times) * slope
    return torque


@pytest.mark.parametrize("name", [*SCENES, *MACHINES])
def test_drive_torque_equals_power_balance(name: str) -> None:
    kinematics, speed = kinematics_of(name)
    loaded = Kinematics(random_loads(kinematics.mechanism, len(name)))
    state = some_states(loaded, speed)
    forces, energy = joint_forces(loaded, state), torque_from_energy(loaded, state)
    peak = np.abs(energy).max()
    assert np.abs(forces.drive_torque - energy).max() < 1e-10 * peak
    # Without the loads it is another torque: the loads do count.
    bare = torque_from_energy(kinematics, state)
    assert np.abs(bare - energy).max() > 1e-6 * peak


@pytest.mark.parametrize("name", ["shear-press", "six-bar"])
def test_drive_torque_differs_when_mass_is_one_percent_off(name: str) -> None:
    kinematics, speed = kinematics_of(name)
    mechanism, state = kinematics.mechanism, some_states(kinematics, speed)
    exact = joint_forces(kinematics, state).drive_torque
    heavy = max(mechanism.bodies[1:], key=lambda body: body.mass)
    bodies = tuple(replace(b, mass=1.01 * b.mass) if b is heavy else b for b in mechanism.bodies)
    wrong = torque_from_energy(Kinematics(replace(mechanism, bodies=bodies)), state)
    assert np.abs(wrong - exact).max() > 1e-4 * np.abs(exact).max()


@pytest.mark.parametrize("second", [40.0, 41.0])
def test_constant_forces_on_one_body_add_up(second: float) -> None:
    kinematics, speed = kinematics_of("shear-press")
    two = (ConstantForce("slider", (0.0, -60.0)), ConstantForce("slider", (5.0, -second)))
    several, one = (
        replace(kinematics.mechanism, forces=forces) for forces in (two, (ConstantForce("slider", (5.0, -100.0)),))
    )
    state = some_states(kinematics, speed)
    torques = [joint_forces(Kinematics(machine), state).drive_torque for machine in (several, one)]
    assert np.array_equal(*torques) == (second == 40.0)


def test_loads_do_not_change_motion_of_prescribed_crank() -> None:
    kinematics, _ = kinematics_of("shear-press")
    loaded = Kinematics(random_loads(kinematics.mechanism, 1))
    assert loaded._branch is kinematics._branch


def pendulum(released: float) -> tuple[Mechanism, float]:
    """A pendulum that is let go at an angle [rad] from hanging down; with it the square of small swings' frequency."""
    bob, start = Body("bob", 2.0, 0.03, (0.4, 0.0)), released - math.pi / 2.0
    pin, driver = Revolute("pin", GROUND, "bob", (0.0, 0.0), (0.0, 0.0)), Driver("pin", 1, start)
    seen = (ObservedPoint("end", "bob", (0.8, 0.0)),)
    mechanism = Mechanism("pendulum", (bob,), (pin,), driver, {"bob": (0.0, 0.0, start)}, seen, GRAVITY)
    return mechanism, 2.0 * 9.81 * 0.4 / (0.03 + 2.0 * 0.4**2)


def slider_crank(start: float = 0.3) -> Mechanism:
    """A slider-crank of 0.1 m and 0.3 m, whose links have their centres of gravity beside their pins."""
    machine = slider_crank_from(0.1, 0.3, turn=start)
    centres = ((0.02, 0.01), (0.12, -0.01), (0.01, 0.02))
    bodies = tuple(replace(b, centre_of_gravity=c) for b, c in zip(machine.bodies, centres, strict=True))
    return replace(machine, bodies=bodies, gravity=GRAVITY)


def run_free_motion(mechanism: Mechanism, times: Array, crank_rate: float) -> FreeMotion:
    """The free motion from a rate of the crank angle [rad/s]."""
    return ForwardDynamics(mechanism).motion(times, {mechanism.crank: mechanism.driver.sense * crank_rate})


def test_pendulum_motion_matches_elliptic_functions() -> None:
    mechanism, square = pendulum(released=2.0)
    times = np.linspace(0.0, 2.0, 41)
    motion = run_free_motion(mechanism, times, 0.0)
    modulus = math.sin(1.0)
    sine = ellipj(ellipk(modulus**2) - math.sqrt(square) * times, modulus**2)[0]
    exact = 2.0 * np.arcsin(modulus * sine)
    swung = motion.poses[:, 2] + math.pi / 2.0
    assert np.abs(swung - exact).max() < 1e-11
    assert motion.drift < 1e-11
    # A hundredth more of mass at the end alone is seen.
    crank = mechanism.bodies[0]
    wrong = replace(mechanism, bodies=(replace(crank, inertia=1.01 * crank.inertia), *mechanism.bodies[1:]))
    assert np.abs(run_free_motion(wrong, times, 0.0).poses[:, 2] + math.pi / 2.0 - exact).max() > 1e-3


@pytest.mark.parametrize(
    ("count", "rate"),
    [(2, 9.0), *(pytest.param(*other, marks=pytest.mark.slow) for other in [(3, -9.0), (4, 1.0), (5, 9.0)])],
)
def test_parallelogram_chain_passes_change_points_smoothly(count: int, rate: float) -> None:
    """All rockers turn alike and the bars do not turn: one pendulum, whose energy is known in closed form."""
    motion = run_free_motion(chain(count), np.linspace(0.0, 1.0, 51), rate)
    turns, rates = motion.poses[:, 2::3], motion.rates[:, 2::3]
    assert np.abs(turns[:, : count + 1] - turns[:, :1]).max() < 1e-10
    assert np.abs(turns[:, count + 1 :]).max() < 1e-10
    inertia, moment = (count + 1) / 3.0 + count, 0.5 * (count + 1) + count
    energy = 0.5 * inertia * rates[:, 0] ** 2 + 9.81 * moment * np.sin(turns[:, 0])
    assert np.abs(energy - energy[0]).max() < 1e-11 * np.abs(energy).max()
    assert motion.drift < 1e-11
    passed = np.floor(turns[:, 0] / math.pi)
    assert len(motion.crossings) >= np.count_nonzero(np.diff(passed)) > 0
    assert "smooth continuation" in motion.continuation


def sine_of_branch(rocker: float) -> tuple[ConfigurationSeries, Array]:
    """Of a four-bar beyond a change point: the sine between coupler and rocker, whose sign its branches differ in."""
    configurations = ConfigurationSeries(four_bar(0.1, 0.3, rocker, 0.3, 0.6))
    configurations.extend_to(6.0)
    points = np.concatenate([piece.points for piece in configurations.ahead])
    assert points[-1, 2] > math.pi + 0.1
    return configurations, np.sin(points[:, 8] - points[:, 5])


@pytest.mark.parametrize("off", [1e-2, pytest.param(1e-4, marks=pytest.mark.slow), 1e-6])
def test_near_parallelogram_stays_on_its_branch(off: float) -> None:
    """With the rocker longer by a little, the crank goes round and the rocker rocks: it has no change point."""
    configurations, sine = sine_of_branch(0.1 + off)
    assert np.all(sine > 0.0) or np.all(sine < 0.0)
    assert all(piece.crossing is None for piece in configurations.ahead)
    assert np.abs(sine).min() < 2.0 * math.sqrt(off / 0.1)
    # Negative control: a parallelogram, told where it is: the links lie in one line.
    configurations, sine = sine_of_branch(0.1)
    assert sine.min() < -0.1 < 0.1 < sine.max()
    (crossed,) = (piece for piece in configurations.ahead if piece.crossing is not None)
    share = 2.0 * (crossed.crossing - crossed.start) / (crossed.stop - crossed.start) - 1.0
    turn = np.polynomial.chebyshev.chebval(share, crossed.series(crossed.points[:, 2]))
    assert turn == pytest.approx(math.pi, abs=1e-6)


def with_springs(mechanism: Mechanism) -> Mechanism:
    loads = (
        Load("spring", Distance("crank", "slider", (0.05, 0.0), (0.0, 0.1)), Elastic(200.0, 0.2)),
        Load("damper", Turn("crank", "rod"), Viscous(0.01)),
        Load("friction", Displacement("slider", (0.0, 0.0), 0.0), Friction(0.5, 0.5)),
        Load("push", Turn(GROUND, "crank"), TimePulse(1.0, 0.13, 0.31)),
    )
    return replace(mechanism, loads=loads)


@pytest.mark.parametrize("rate", [12.0, pytest.param(-12.0, marks=pytest.mark.slow)])
def test_energy_balance_holds_to_1e_11_under_all_loads(rate: float) -> None:
    motion = run_free_motion(with_springs(slider_crank()), np.linspace(0.0, 0.8, 33), rate)
    assert motion.drift < 1e-11
    assert abs(motion.work[-1]) > 0.01 * motion.scale


def test_torsion_spring_winds_up_beyond_one_turn() -> None:
    wheel, _ = pendulum(0.0)
    spring = Load("spring", Turn(GROUND, "bob"), Elastic(2.0, -math.pi / 2.0))
    times, rate, inertia = np.linspace(0.0, 1.4, 29), 30.0, 0.03 + 2.0 * 0.4**2
    motion = run_free_motion(replace(wheel, gravity=(0.0, 0.0), loads=(spring,)), times, rate)
    frequency = math.sqrt(2.0 / inertia)
    exact = rate / frequency * np.sin(frequency * times)
    assert exact.max() > 3.0 * math.pi
    np.testing.assert_allclose(motion.poses[:, 2] - motion.poses[0, 2], exact, atol=1e-9)
    assert motion.drift < 1e-11


def test_inverse_torque_reproduces_prescribed_motion() -> None:
    """Accelerations of a free motion, given to the inverse problem, take no torque; those of another one do."""
    mechanism = with_springs(slider_crank())
    times = np.linspace(0.0, 0.5, 26)
    motion = run_free_motion(mechanism, times, 12.0)
    kinematics = Kinematics(mechanism)
    angle = motion.poses[:, 2] - mechanism.driver.start
    state = Instants(times, angle, motion.rates[:, 2], motion.accelerations[:, 2])
    forces = joint_forces(kinematics, state)
    held = joint_forces(kinematics, replace(state, acceleration=0.0 * times))
    assert np.abs(forces.drive_torque).max() < 1e-9 * np.abs(held.drive_torque).max()


def refusal(mechanism: Mechanism, rates: dict[str, float]) -> str:
    with pytest.raises(InvalidInput) as caught:
        ForwardDynamics(mechanism).motion(np.linspace(0.0, 1.0, 3), rates)
    assert "\n" not in str(caught.value)
    return str(caught.value)


def test_free_motion_refuses_rest_in_loaded_dead_centre() -> None:
    push = Load("gas", Displacement("slider", (0.0, 0.0), 0.0), Steady(-100.0))
    at_rest = replace(slider_crank(start=0.0), gravity=(0.0, 0.0), loads=(push,))
    assert "at rest in a dead centre" in refusal(at_rest, {})
    # In motion, or beside the dead centre, it goes.
    times = np.linspace(0.0, 0.1, 3)
    assert abs(run_free_motion(at_rest, times, 1.0).rates[-1, 2]) > 0.0
    beside = replace(slider_crank(start=0.1), gravity=(0.0, 0.0), loads=(push,))
    assert abs(run_free_motion(beside, times, 0.0).rates[-1, 2]) > 0.0


@pytest.mark.parametrize("released", [0.0, math.pi])
def test_free_motion_refuses_rest_in_exact_balance(released: float) -> None:
    hanging, _ = pendulum(released)
    assert "its weight and loads are in balance" in refusal(hanging, {})
    beside, _ = pendulum(released + 1e-6)
    assert abs(run_free_motion(beside, np.linspace(0.0, 0.1, 3), 0.0).rates[-1, 2]) > 0.0


NOTHING = tuple(b if b.name == "slider" else Body(b.name, 1e-9, 1e-15) for b in slider_crank().bodies)
MEETING = Load("spring", Distance(GROUND, "crank", (0.0, 0.0), (0.0, 0.0)), Elastic(1.0))


@pytest.mark.parametrize(
    ("changes", "rates", "told"),
    [
        ({}, {"crank": 5.0, "rod": 5.0}, "contradicts the joints: with crank at 5 rad/s it is"),
        ({}, {"slider": 1.0}, "there it does not turn"),
        ({}, {"rodd": 1.0}, "unknown body"),
        ({"bodies": NOTHING}, {"crank": 20.0}, "give the crank an inertia"),
        ({"loads": (MEETING,)}, {"crank": 1.0}, "is not finite"),
    ],
)
def test_free_motion_refuses_impossible_start_or_machine(changes: dict[str, Any], rates: Any, told: str) -> None:
    assert told in refusal(replace(slider_crank(), **changes), rates)


def test_free_motion_accepts_consistent_rates_of_two_bodies() -> None:
    forward = ForwardDynamics(slider_crank())
    rod = forward.motion(np.linspace(0.0, 0.1, 3), {"crank": 5.0}).rates[0, 5]
    assert forward.start_rate({"crank": 5.0, "rod": rod}) == pytest.approx(forward.start_rate({"rod": rod}))


def changed_body(body: Body, quality: str, change: float) -> Body:
    """A body with one property off."""
    if not quality.startswith("centre"):
        return replace(body, **{quality: getattr(body, quality) + change})
    x, y = body.centre_of_gravity
    return replace(body, centre_of_gravity=(x + change, y) if quality.endswith("x") else (x, y + change))


@pytest.mark.parametrize("name", ["shear-press", "cam-follower", "six-bar"])
def test_sensitivities_match_difference_quotients_of_forces(name: str) -> None:
    kinematics, speed = kinematics_of(name)
    mechanism, state = kinematics.mechanism, some_states(kinematics, speed)
    for some in sensitivities(kinematics, state):
        moved = []
        for change in (some.change, -some.change):
            bodies = tuple(
                changed_body(b, some.quality, change) if b.name == some.body else b for b in mechanism.bodies
            )
            moved.append(joint_forces(Kinematics(replace(mechanism, bodies=bodies)), state).drive_torque)
        quotient = (moved[0] - moved[1]) / (2.0 * some.change)
        assert np.abs(quotient - some.derivatives[TORQUE]).max() <= 1e-8 * (np.abs(moved[0]).max() / some.change)


def wheels(ratio: float) -> Mechanism:
    """Two wheels on fixed shafts; the second one turns by so much of a turn for each of the first."""
    radius, other = 0.1, 0.1 / ratio
    away = radius + other
    bodies = (Body("crank", 1.0, 0.005, (0.02, 0.0)), Body("wheel", 1.0, 0.01, (0.0, 0.03)))
    joints = (
        Revolute("shaft", GROUND, "crank", (0.0, 0.0), (0.0, 0.0)),
        Revolute("axle", GROUND, "wheel", (away, 0.0), (0.0, 0.0)),
        Rolling("mesh", "crank", "wheel", (0.0, 0.0), (0.0, 0.0), radius, other, 0.0),
    )
    poses = {"crank": (0.0, 0.0, 0.0), "wheel": (away, 0.0, 0.0)}
    observed = (ObservedPoint("P", "wheel", (0.05, 0.0)),)
    return Mechanism("wheels", bodies, joints, Driver("shaft"), poses, observed, (0.0, -9.81))


@pytest.mark.parametrize(("ratio", "closes"), [(0.5, True), (0.99, False)])
def test_gear_curve_closes_only_after_whole_turns_of_both(ratio: float, closes: bool) -> None:
    """Of 99 to 100 the second wheel passes its start by a hundredth of a turn, turn after turn: that is not closed."""
    configurations = ConfigurationSeries(wheels(ratio))
    per_turn = 2.0 * math.pi * math.hypot(1.0, ratio)
    configurations.extend_to(3.5 * per_turn)
    if closes:
        assert configurations.loop is not None
        assert configurations.loop.length == pytest.approx(2.0 * per_turn)
        assert np.abs(configurations.loop.gain[[2, 5]]) == pytest.approx([4.0 * math.pi, 2.0 * math.pi])
    else:
        assert configurations.loop is None


@pytest.mark.parametrize("rate", [20.0, pytest.param(-20.0, marks=pytest.mark.slow)])
def test_energy_holds_for_gears_without_common_period(rate: float) -> None:
    motion = run_free_motion(wheels(math.sqrt(0.5)), np.linspace(0.0, 0.6, 13), rate)
    assert motion.drift < 1e-11
    assert motion.poses[:, 5] == pytest.approx(-math.sqrt(0.5) * motion.poses[:, 2], abs=1e-11)


def test_free_motion_resolves_gentle_rise_after_dwell() -> None:
    """Steps that had grown in the dwell passed over it, and left 1.4e-11 of the energy."""
    kinematics, speed = kinematics_of("cam-3-4-5")
    assert run_free_motion(kinematics.mechanism, np.linspace(0.0, 10.0, 11), speed).drift < 1e-12


def blas_threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_configuration_series_uses_one_blas_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, sampled = [], configuration_series.fit_piece

    def watched(*arguments: object) -> CurvePiece | None:
        seen.append(blas_threads())
        return sampled(*arguments)  # type: ignore[arg-type]  # as they are

    monkeypatch.setattr(configuration_series, "fit_piece", watched)
    with threadpool_limits(2, user_api="blas"):
        ConfigurationSeries(chain(1)).extend_to(0.1)
        assert blas_threads() == {2}
    assert seen
    assert all(threads == {1} for threads in seen)
