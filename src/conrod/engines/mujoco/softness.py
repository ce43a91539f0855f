"""Give of MuJoCo's soft closures: its documented constraint model, solved along the motion.

A soft constraint of violation y and force f is given the acceleration J q'' = -B y' - K d(y) y - R(y) f, with
R = (1 - d) / d A and A the compiled inverse weight (MuJoCo documentation, Computation, 'Constraint model' and 'Solver
parameters'). The true one is y'' = J q'' + J' q'; `connect` has the second term in it, a contact and a tendon have not,
so that their violation follows the curvature of the path. The force is the one that the motion with its violation
takes, f = f0 + W y'', with f0 at no acceleration of the gaps and W the mass that the links show to them:

    (1 + R W) y'' + B y' + K d y = -R f0 (+ J' q')

f0, W and J' q' are taken along the motion found before, until it is found again. No step is in it: this is what is left
of the error when the step vanishes.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, assert_never

import numpy as np

from conrod.engines.capabilities import Softness
from conrod.engines.engine import Machine
from conrod.engines.massless_rod import DistanceJoint
from conrod.engines.mujoco.model import Build, build
from conrod.engines.mujoco.settings import MuJoCoSettings, Spring
from conrod.engines.open_joints import OpenJoints
from conrod.exact.dynamics.coordinates import load_forces
from conrod.exact.dynamics.inverse import inertia_forces
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import INERTIAS, MASSES, CamContact, Mechanism, Mesh, Rack, Revolute, Rolling

LAW = "constraint model: violation of spring, impedance and regularisation under the forces that the motion takes"
SAMPLES = 360  # in a turn
LARGEST_GAP = 0.5  # of the machine's travel; beyond it there is no machine that a violation is small against

Soft = CamContact | Revolute | DistanceJoint | Mesh


@dataclass(frozen=True)
class _Motion:
    """Masses and forces that the violations y of a motion meet, at T samples.

    Attributes:
        mass: W (T, k, k) [kg], that the links show to accelerations of the violations.
        force: f0 (T, k) [N], without such accelerations.
        curvature: J' q' (T, k) [m/s^2], where the engine leaves it out.
    """

    mass: Array
    force: Array
    curvature: Array

    def at(self, time: float) -> _Motion:
        """Between two samples, or at one: of one instant, without the first axis."""
        i = min(int(time), len(self.mass) - 2)
        part = time - i
        mass, force, curvature = (
            (1.0 - part) * values[i] + part * values[i + 1] for values in (self.mass, self.force, self.curvature)
        )
        return _Motion(mass, force, curvature)


@dataclass(frozen=True)
class _Closure:
    """A soft constraint: what it closes, and the compiled inverse weight A [1/kg]."""

    joint: Soft
    weight: float
    spring: Spring

    @property
    def size(self) -> int:
        """Number of violations."""
        return 2 if isinstance(self.joint, Revolute) else 1


def predicted_softness(machine: Machine, settings: MuJoCoSettings) -> Softness | None:
    """Position error of no step.

    Returns:
        None where no loop is closed and nothing touches, where the violations have no end, or no size that a machine
        can have; of a dressed model, which may be closed otherwise; and of one pass, which is over before it settles.
    """
    if settings.dressing or machine.kinematics.mechanism.driver.span is not None:
        return None
    joints = _SoftJoints(machine, settings)
    return joints.settled(joints.yielding, 2 * joints.size, LAW)


class _SoftJoints(OpenJoints):
    """Joints that give way.

    A state holds the violations and their rates over the crank speed, (T, 2 k) [m].
    """

    def __init__(self, machine: Machine, settings: MuJoCoSettings) -> None:
        made = build(machine, settings)
        super().__init__(machine, made.form, SAMPLES)
        self._closures = _closures(made, settings)
        for closure in self._closures:
            if not isinstance(closure.joint, DistanceJoint):
                first = self.rows[closure.joint.name]
                self.open_rows += range(first, first + closure.size)
        self._given = _given(made, settings)
        self._identity = np.eye(self.size)

    def yielding(self, state: Array) -> Array:
        """The state from a start that is closed, under the forces that the motion of a given state takes."""
        gaps, rates = state[:, : self.size], abs(self.speed) * state[:, self.size :]
        if np.abs(gaps).max() > LARGEST_GAP * self.kinematics.travel:
            return np.full_like(state, np.nan)
        motion = self._motion(self.opened(gaps), rates)

        def balance(time: float, near: Array) -> Balance:
            return self._balance(motion.at(time), near)

        following, its_rates = integrated(balance, len(gaps), self.size, self.step)
        return np.hstack([following, its_rates / abs(self.speed)])

    def _balance(self, motion: _Motion, gaps: Array) -> Balance:
        """Equation of the violations at an instant of a motion, with the impedances of gaps (k,)."""
        stiffness, damping, yielding = np.empty((3, self.size))
        first = 0
        for closure in self._closures:
            mine, spring = slice(first, first + closure.size), closure.spring
            impedance = spring.impedance(math.hypot(*gaps[mine]))
            stiffness[mine], damping[mine] = spring.stiffness * impedance, spring.damping
            yielding[mine] = (1.0 - impedance) / impedance * closure.weight
            first += closure.size
        inertia = self._identity + yielding[:, None] * motion.mass
        return Balance(inertia, damping, stiffness, motion.curvature - yielding * motion.force)

    def _motion(self, poses: Array, rates: Array) -> _Motion:
        """Masses and forces at poses (T, 3 n), where the violations change at rates (T, k)."""
        along, given = self.along(poses), self._given
        speeds = self.rates(poses, (along @ rates[:, :, None])[:, :, 0])
        inverse = np.linalg.inv(self.kinematics.jacobian(poses))
        bare = self.kinematics.residual([poses, speeds, np.zeros_like(poses)], np.zeros(len(poses)))
        steady = -(inverse @ bare[:, :, None])[:, :, 0]
        # Work of the violations: what a force on the links is along them.
        open_way = inverse @ along
        work = np.swapaxes(open_way, 1, 2)
        inertia = inertia_forces(given, poses, speeds, steady)
        forces = inertia - load_forces(given, poses, speeds, self.angle / self.speed)
        columns = []
        for k in range(self.size):
            more = inertia_forces(given, poses, speeds, steady + open_way[:, :, k]) - inertia
            columns.append((work @ more[:, :, None])[:, :, 0])
        curvature = [self._left_out(closure, poses, speeds, bare) for closure in self._closures]
        return _Motion(
            np.stack(columns, axis=2), (work @ forces[:, :, None])[:, :, 0], np.concatenate(curvature, axis=1)
        )

    def _left_out(self, closure: _Closure, poses: Array, rates: Array, bare: Array) -> Array:
        """The term J' q' (T, size) [m/s^2] that MuJoCo leaves out; `bare` is that of all joint equations."""
        joint = closure.joint
        match joint:
            case DistanceJoint():
                length = self.distance(joint, [poses, rates, np.zeros_like(poses)])
                return 2.0 * np.asarray(length.coefficients[2])[:, None]
            case Revolute():
                return np.zeros((len(poses), 2))
            case Rolling() | Rack():  # linear in the engine's coordinates
                return np.zeros((len(poses), 1))
            case CamContact():
                row = self.rows[joint.name]
                return bare[:, row : row + 1]
            case _:
                assert_never(joint)


def _given(made: Build, settings: MuJoCoSettings) -> Mechanism:
    """The masses and the gravity that the engine has; a link that is left out has next to no mass."""
    gone = {joint.link for joint in made.form.distances}
    bodies = tuple(
        replace(body, mass=MASSES[0], inertia=INERTIAS[0]) if body.name in gone else body
        for body in made.form.whole.bodies
    )
    gravity = made.form.whole.gravity if settings.gravity else (0.0, 0.0)
    return replace(made.form.whole, bodies=bodies, gravity=gravity)


def _closures(made: Build, settings: MuJoCoSettings) -> list[_Closure]:
    model, found = made.model, []
    spring = Spring.of(settings.solref, settings.solimp, settings.timestep, settings.refsafe)
    contact_spring = Spring.of(settings.contact_solref, settings.contact_solimp, settings.timestep, settings.refsafe)
    for contact in made.form.mechanism.cam_contacts:
        bodies = [model.body(name).id for name in (contact.a, contact.b)]
        found.append(_Closure(contact, float(model.body_invweight0[bodies, 0].sum()), contact_spring))
    for joint in (*made.tree.cuts, *made.form.mechanism.meshes):
        found.append(_Closure(joint, made.inverse_weight(joint.name), spring))
    for distance in made.form.distances:
        found.append(_Closure(distance, made.inverse_weight(distance.link), spring))
    return found


# -- the equation of the violations, however stiff --------------------------------------------------------------------


class Balance(NamedTuple):
    """inertia x'' + damping x' + stiffness x = pull, of k coordinates."""

    inertia: Array  # (k, k)
    damping: Array  # (k,)
    stiffness: Array  # (k,)
    pull: Array  # (k,)


def integrated(balance: Callable[[float, Array], Balance], samples: int, size: int, step: float) -> tuple[Array, Array]:
    """Coordinates and rates at samples a step [s] apart, (T, k) each, from rest at zero.

    The singly diagonally implicit Runge-Kutta method of two stages and order 2 that is L-stable (Alexander, 1977). A
    balance may change with the coordinates: it is taken at those that the step's start predicts, which keeps the order.

    Args:
        balance: at a time counted in samples, near given coordinates.
    """
    share = 1.0 - math.sqrt(0.5)
    reach = share * step
    places, rates = np.zeros((samples, size)), np.zeros((samples, size))
    identity = np.eye(size)
    for i in range(samples - 1):
        place, rate = places[i], rates[i]
        base_place, base_rate = place, rate
        for part in (share, 1.0):
            at = balance(i + part, place + part * step * rate)
            stiff = at.damping + reach * at.stiffness
            left = at.pull - stiff * base_rate - at.stiffness * base_place
            gain = np.linalg.solve(at.inertia + reach * (identity * stiff), left)
            its_rate = base_rate + reach * gain
            its_place = base_place + reach * its_rate
            if part < 1.0:
                base_rate = rate + (1.0 - share) * step * gain
                base_place = place + (1.0 - share) * step * its_rate
        places[i + 1], rates[i + 1] = its_place, its_rate
    return places, rates
