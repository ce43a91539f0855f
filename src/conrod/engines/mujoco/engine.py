"""The MuJoCo engine: its table of capabilities, kinematic mode, and steppers for timings."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from conrod.engines.engine import (
    STOCK,
    DeferredFunctions,
    DeferredLibrary,
    DescribedMachine,
    Engine,
    Machine,
    Preset,
    run_extent,
    with_fields,
)
from conrod.engines.mujoco import MUJOCO_PRESETS, STOCK_TOLERANCE, MuJoCoSettings, compat
from conrod.engines.numerics import place_at_angles, secant_root
from conrod.exact.motion import Array
from conrod.mechanism.mechanism import CamContact

if TYPE_CHECKING:
    import mujoco

    from conrod.engines import cam_polygon, capabilities, releases, spanning_tree, tracks
    from conrod.engines.mujoco import (
        dynamics,
        error_bound,
        forces,
        free_run,
        model,
        model_edits,
        space,
        standalone,
        variants,
    )
else:
    mujoco = DeferredLibrary("mujoco")
    capabilities = DeferredLibrary("conrod.engines.capabilities")
    cam_polygon = DeferredFunctions("conrod.engines.cam_polygon")
    releases = DeferredFunctions("conrod.engines.releases")
    spanning_tree = DeferredFunctions("conrod.engines.spanning_tree")
    tracks = DeferredFunctions("conrod.engines.tracks")
    dynamics = DeferredFunctions("conrod.engines.mujoco.dynamics")
    error_bound = DeferredFunctions("conrod.engines.mujoco.error_bound")
    forces = DeferredFunctions("conrod.engines.mujoco.forces")
    free_run = DeferredFunctions("conrod.engines.mujoco.free_run")
    model = DeferredFunctions("conrod.engines.mujoco.model")
    model_edits = DeferredFunctions("conrod.engines.mujoco.model_edits")
    space = DeferredFunctions("conrod.engines.mujoco.space")
    standalone = DeferredFunctions("conrod.engines.mujoco.standalone")
    variants = DeferredFunctions("conrod.engines.mujoco.variants")

# -- kinematic mode: its own constraints as a solver at prescribed crank angles ----------------------------------------


MAX_KINEMATIC_STEPS = 20
FREE_REASON = "pins of free bodies are held by three connects each, whose forces no joint reports"


def solve_kinematics(machine: Machine, angle: Array) -> capabilities.KinematicResult:
    """Hold the crank at each angle (T,) [rad] while MuJoCo's own constraints place the bodies."""
    settings = MuJoCoSettings.tuned(machine, 1000)
    made = model.build(machine, settings)
    data = mujoco.MjData(made.model)
    contacts = made.tree.mechanism.cam_contacts
    rows = []

    def place(theta: float, ahead: Array | None) -> Array:
        """Place the machine by the engine's joints at a crank angle [rad], from a guess if one is given."""
        data.qpos[:] = data.qpos if ahead is None else ahead
        data.qpos[made.crank_dof] = theta
        if contacts:
            _place_follower(made, data, contacts[0])
        else:
            _close_loops(made, data)
        return np.asarray(data.qpos)

    for _ in place_at_angles(machine.kinematics, angle, place):
        mujoco.mj_forward(made.model, data)
        rows.append((data.qpos.copy(), data.qvel.copy(), data.sensordata.copy()))
        data.qvel[made.crank_dof] = machine.speed
        if not contacts:
            free, jacobian = _passive_dofs(made), model.constraint_jacobian(made.model, data)
            turning = -jacobian[:, made.crank_dof] * machine.speed
            data.qvel[free] = np.linalg.lstsq(jacobian[:, free], turning, rcond=None)[0]
            mujoco.mj_forward(made.model, data)
            rows[-1] = (data.qpos.copy(), data.qvel.copy(), data.sensordata.copy())
    coordinates, rates, sensors = (np.array(column) for column in zip(*rows, strict=True))
    poses, _ = made.forward_kinematics(coordinates, rates)
    points = {
        p.name: (
            made.sensor_values(sensors, f"{p.name}.position")[:, :2],
            None if contacts else made.sensor_values(sensors, f"{p.name}.velocity")[:, :2],
        )
        for p in made.tree.mechanism.observed
    }
    error = error_bound.shape_error(machine, settings) if contacts else None
    return capabilities.KinematicResult(angle, poses, points, error)


def _passive_dofs(made: model.MuJoCoModel) -> NDArray[np.int_]:
    """Indices of all degrees of freedom except the crank's."""
    return np.array([i for i in range(made.model.nv) if i != made.crank_dof], dtype=int)


def _close_loops(made: model.MuJoCoModel, data: mujoco.MjData) -> None:
    """Close the loops by Newton iteration on the engine's own constraint violation and Jacobian."""
    free = _passive_dofs(made)
    for _ in range(MAX_KINEMATIC_STEPS):
        mujoco.mj_fwdPosition(made.model, data)
        jacobian = model.constraint_jacobian(made.model, data)[:, free]
        step = np.linalg.lstsq(jacobian, data.efc_pos[: data.nefc], rcond=None)[0]
        data.qpos[free] -= step
        if np.abs(step).max(initial=0.0) < 1e-15:  # nothing to close where the crank is all there is
            break


def _place_follower(made: model.MuJoCoModel, data: mujoco.MjData, contact: CamContact) -> None:
    """Place the follower where the engine's own distance of cam and roller is zero, by secant iteration."""
    (cam, roller), slide = made.cam_and_roller_geoms(contact), int(_passive_dofs(made)[0])

    def gap(position: float) -> float:
        data.qpos[slide] = position
        mujoco.mj_kinematics(made.model, data)
        return float(mujoco.mj_geomDistance(made.model, data, cam, roller, 1.0, None))

    # Single-precision vertices make the distance rough below this.
    secant_root(gap, float(data.qpos[slide]), 1e-4 * contact.roller_radius, 1e-13)


# -- steps with nothing recorded, which is what MuJoCo itself costs ----------------------------------------------------


class MuJoCoStepper:
    """A machine without sensors in the exact state of its start; a call advances it by a number of steps."""

    def __init__(self, machine: Machine, settings: MuJoCoSettings) -> None:
        self._made = model.build(machine, settings, sensors=False)
        self.model, self.data = self._made.model, mujoco.MjData(self._made.model)
        self.data.qpos[:], self.data.qvel[:] = self._made.start_state(machine, run_extent(machine, 1, 1.0)[0])

    def __call__(self, steps: int) -> None:
        with dynamics.silence_warnings(), model.apply_load_laws(self.model, self._made.tree):
            mujoco.mj_step(self.model, self.data, nstep=steps)


def reference_loop() -> MuJoCoStepper:
    """Stepper of the fixed slider-crank, the unit of timings, with a flywheel of 10 kg m^2 and stock tolerance."""
    return MuJoCoStepper(
        capabilities.TIMED_REFERENCE, MuJoCoSettings(STOCK, 1000, 0.001, tolerance=STOCK_TOLERANCE, armature=10.0)
    )


# -- the engine --------------------------------------------------------------------------------------------------------


def without_loop_judgement(preset: Preset[MuJoCoSettings]) -> Preset[MuJoCoSettings]:
    """Return the preset without force tolerances for loops, for releases whose loops have no error bound."""
    return replace(preset, judged_free=False, forces={q: bar for q, bar in preset.forces.items() if q == "contact"})


class MuJoCo(Engine[MuJoCoSettings]):
    """MuJoCo through MJCF, with all capabilities."""

    name = "mujoco"
    version = compat.MUJOCO_VERSION
    presets = (
        MUJOCO_PRESETS
        if compat.CLOSURES_ARE_BOUNDED
        else {name: without_loop_judgement(one) for name, one in MUJOCO_PRESETS.items()}
    )
    run = staticmethod(dynamics.run)
    solve_kinematics = staticmethod(solve_kinematics)
    expected_error = staticmethod(error_bound.expected_error)
    expected_forces = staticmethod(forces.expected_forces)
    stepper = MuJoCoStepper
    reference_loop = staticmethod(reference_loop)
    grid = staticmethod(variants.rules)
    free_run = staticmethod(free_run.free_run)
    refusal_in_space = staticmethod(space.refusal_in_space)
    run_in_space = staticmethod(space.run_in_space)
    stepper_in_space = staticmethod(space.MuJoCoSpatialStepper)
    paste = staticmethod(standalone.paste)
    with_time_constant = staticmethod(variants.with_time_constant)
    with_regularisation = staticmethod(variants.with_regularisation)
    minimal_settings = staticmethod(variants.minimal_settings)
    ingredients = staticmethod(variants.ingredients)

    @property
    def releases(self) -> releases.Releases:
        return releases.read_releases("conrod.engines.mujoco")

    def model(self, name: str, machine: DescribedMachine, settings: MuJoCoSettings) -> str:
        return standalone.standalone_mjcf(name, machine, settings=settings)

    def probes(self, machine: Machine, steps_per_revolution: int) -> dict[str, MuJoCoSettings]:
        """Settings that show differences between releases: the presets, and solver parts that they do not use."""
        found = {name: preset(machine, steps_per_revolution) for name, preset in MUJOCO_PRESETS.items()}
        if machine.kinematics.mechanism.cam_contacts:
            del found["hardened"]
        others: dict[str, dict[str, Any]] = {
            "CG": {"solver": "CG"},
            "PGS": {"solver": "PGS"},
            "sparse": {"dressing": ("sparse-jacobian",)},
            "implicitfast": {"integrator": "implicitfast"},
        }
        return found | {f"tuned, {name}": with_fields(found["tuned"], **values) for name, values in others.items()}

    def refusal(self, machine: Machine, settings: MuJoCoSettings) -> str | None:
        mechanism = machine.kinematics.mechanism
        if reason := cam_polygon.contact_refusal(mechanism):
            return reason
        if settings.hardening is not None and mechanism.cam_contacts:
            return "hardening does not apply to contact"
        reason = compat.missing_feature(settings) or model_edits.edit_refusal(mechanism, settings)
        return reason or spanning_tree.tree_refusal(spanning_tree.machine_tree(machine))

    def forces(
        self, machine: Machine, settings: MuJoCoSettings, revolutions: float, start_angle: float = 0.0
    ) -> tracks.ForceTracks:
        free = FREE_REASON if "free-bodies" in settings.dressing else None
        if reason := self.refusal(machine, settings) or free:
            return tracks.unreported_forces(machine.kinematics.mechanism, reason)
        return forces.forces(machine, settings, revolutions, start_angle)


MUJOCO_ENGINE = MuJoCo()
