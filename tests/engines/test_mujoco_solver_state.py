"""What MuJoCo's solver leaves: rounding where it is left alone, accelerations of the machine's size where it stops."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from typing import Any

import mujoco
import numpy as np
import pytest
from catalogue import PRESS, SAW, SCENES

from conrod import MuJoCoSettings
from conrod.engines import engine_named
from conrod.engines.mujoco.model import build
from conrod.engines.mujoco.recorder import constraint_forces, solver_state, warnings_kept_quiet
from conrod.exact.motion import Array
from conrod.runs.trajectory import Piece

MUJOCO: Any = engine_named("mujoco")
PRESETS = ("stock", "tuned", "hardened")
CASES = [(name, preset) for name, preset in product(SCENES, PRESETS) if (name, preset) != ("cam-follower", "hardened")]


def settings_of(name: str, preset: str, **changes: Any) -> MuJoCoSettings:
    scene, steps = SCENES[name], 2000 if name == "cam-follower" else 400
    made: MuJoCoSettings = MUJOCO.presets[preset](scene, steps)
    return replace(made, cam_vertices=400, **changes)


def pieces(name: str, settings: MuJoCoSettings, steps: int = 50, revolutions: float = 0.5) -> list[Piece]:
    return list(MUJOCO.run(SCENES[name], settings, revolutions, 0.0, steps))


def worst(name: str, found: list[Piece]) -> float:
    """Largest residual over omega^2 L."""
    scene = SCENES[name]
    size = scene.speed**2 * max(scene.lengths.values())
    return max(piece.solver.residual for piece in found if piece.solver) / size


# -- in a run --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "preset"), CASES)
def test_a_solver_that_is_left_alone_leaves_rounding(name: str, preset: str) -> None:
    found = pieces(name, settings_of(name, preset))
    assert all(piece.solver and piece.solver.iterations for piece in found)
    assert worst(name, found) < 1e-12


@pytest.mark.parametrize(("name", "least"), [("shear-press", 10.0), ("saw-40rpm", 10.0), ("saw-500rpm", 0.05)])
def test_the_tolerance_trap_is_seen(name: str, least: float) -> None:
    # The tolerance is scaled by the mean inertia, the drive's flywheel included: few steps begin an iteration at all.
    settings = MuJoCoSettings.stock(SCENES[name], 400)
    found = pieces(name, replace(settings, tolerance=1e-8), 20, 2.0)
    stopped = [piece for piece in found if piece.solver and not piece.solver.iterations]
    begun = [piece for piece in found if piece.solver and piece.solver.iterations]
    assert len(stopped) > 0.75 * len(found)
    assert worst(name, stopped) > least
    assert all(not piece.warnings for piece in found)
    # One iteration is all that it takes where it is begun.
    assert worst(name, begun) < 1e-12
    assert worst(name, pieces(name, settings, 20, 2.0)) < 1e-12


@pytest.mark.parametrize(("solver", "few"), [("PGS", 1), ("PGS", 4), ("CG", 1)])
def test_too_few_iterations_are_seen(solver: str, few: int) -> None:
    # In the press CG needs two.
    for iterations, low, high in ((few, 1e-3, 10.0), (100, 0.0, 1e-12)):
        settings = settings_of("shear-press", "tuned", solver=solver, iterations=iterations)
        found = pieces("shear-press", settings)
        assert low < worst("shear-press", found) < high
        assert all(piece.solver and piece.solver.iterations <= iterations for piece in found)


# -- against the engine's own answer ---------------------------------------------------------------------------------


def solved_and_left(scene: Any, settings: MuJoCoSettings) -> tuple[mujoco.MjModel, mujoco.MjData, Array]:
    """A state of a run, its solution by the settings, and what of the closures' acceleration that leaves unsolved.

    By the engine's own Newton iteration, left alone, from the same state.
    """
    made = build(scene, settings)
    data = mujoco.MjData(made.model)
    data.qpos[:], data.qvel[:] = made.start_state(scene, 0.7)
    with warnings_kept_quiet():
        mujoco.mj_step(made.model, data, nstep=20)
    mujoco.mj_forward(made.model, data)
    solved_model = build(scene, replace(settings, solver="Newton", iterations=1000, tolerance=0.0)).model
    solved = mujoco.MjData(solved_model)
    solved.qpos[:], solved.qvel[:] = data.qpos, data.qvel
    mujoco.mj_forward(solved_model, solved)
    left = np.empty(data.nefc)
    mujoco.mj_mulJacVec(made.model, data, left, data.qacc - solved.qacc)
    return made.model, data, left


@pytest.mark.parametrize(
    "changes",
    [
        {"tolerance": 1e-8, "armature": 1e13},
        {"solver": "CG", "iterations": 1},
        {"solver": "PGS", "iterations": 2},
        {"iterations": 0},
    ],
    ids=["the trap", "one of CG", "two of PGS", "no iteration"],
)
@pytest.mark.parametrize("scene", [PRESS, SAW], ids=["press", "saw"])
def test_the_residual_is_how_far_the_accelerations_are_from_the_solved_ones(
    scene: Any, changes: dict[str, Any]
) -> None:
    settings = replace(MuJoCoSettings.stock(scene, 400), **changes)
    model, data, left = solved_and_left(scene, settings)
    found = solver_state(model, data)
    assert found is not None
    assert np.abs(left).max() > 1e-6 * scene.speed**2 * max(scene.lengths.values())
    assert found.residual == pytest.approx(np.abs(left).max(), rel=1e-6)


def test_regularisation_is_no_error_of_the_solver() -> None:
    # Stock closures give way by a tenth of their reference acceleration; that is what the solver is to find.
    model, data, _ = solved_and_left(SAW, MuJoCoSettings.stock(SAW, 400))
    given_way = np.abs(data.efc_R * data.efc_force).max()
    found = solver_state(model, data)
    assert found is not None
    assert given_way > 1e-3 * SAW.speed**2 * max(SAW.lengths.values())
    assert found.residual < 1e-12 * given_way


# -- forces ----------------------------------------------------------------------------------------------------------


def test_contacts_push_or_let_go_and_never_pull() -> None:
    random = np.random.default_rng(7)
    pulled = 0
    for _ in range(200):
        rows = random.normal(size=(4, 6)) * 10.0 ** random.uniform(-4.0, 4.0, size=(4, 1))
        system, missing = rows @ rows.T, random.normal(size=4)
        one_way = np.array([False, False, True, True])
        force = constraint_forces(system, missing, one_way)
        gap, size = system @ force - missing, np.abs(system) @ np.abs(force) + np.abs(missing)
        acting = ~one_way | (force > 0.0)
        assert np.all(force[one_way] >= 0.0)
        assert np.all(np.abs(gap[acting]) < 1e-9 * size[acting])
        assert np.all(gap[~acting] > -1e-9 * size[~acting])
        pulled += bool(np.any(np.linalg.solve(system, missing)[one_way] < 0.0))
    assert pulled > 100
