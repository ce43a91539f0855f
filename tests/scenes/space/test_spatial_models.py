"""MuJoCo models of spatial machines stand where the closed form says, and not if they are built a little wrong."""

from __future__ import annotations

import math
from collections.abc import Callable

import mujoco
import numpy as np
import pytest
from spatial_poses import Model, driven

from conrod.errors import InvalidInput
from conrod.exact.motion import Array
from conrod.scenes.space import MACHINES

TIMES = np.linspace(0.0, 1.0, 12, endpoint=False) + 0.01
DEGREE = math.pi / 180.0


@pytest.mark.parametrize("name", MACHINES)
def test_the_reference_pose_is_assembled_and_has_the_freedoms_it_says(name: str) -> None:
    machine = MACHINES[name]()
    model = Model(machine)
    mujoco.mj_fwdPosition(model.model, model.data)
    assert model.opening < 1e-16
    assert not model.data.contact.dist.size
    assert model.model.nv - model.rank == machine.degrees_of_freedom


@pytest.mark.parametrize("name", MACHINES)
def test_the_model_stands_and_moves_as_the_closed_form_says(name: str) -> None:
    machine = MACHINES[name]()
    model, drives = Model(machine), driven(machine, TIMES, 1)
    points = machine.points(drives)
    for sample in range(len(TIMES)):
        model.put(drives, sample)
        assert model.opening < 1e-14
        assert model.model.nv - model.rank == machine.degrees_of_freedom
        for point, values in points.items():
            assert model.data.site(point).xpos == pytest.approx(values[0, sample], abs=1e-14), point
        if name != "rssr-idle-spin":  # whose rod's turn rate is not in closed form
            assert np.abs(model.data.efc_vel[model.rows]).max() < 1e-13
    # Negative control: the driven joint alone a thousandth of a radian or a millimetre further.
    joint = next(iter(machine.drives))
    model.data.joint(joint).qpos += 1e-3
    mujoco.mj_fwdPosition(model.model, model.data)
    assert model.opening > 1e-6


def longer_link(model: Model) -> None:
    """0.1 % more between a link and the next; where all links meet in a point, to the closure's pin."""
    offsets = [model.model.body_pos[body] for body, parent in enumerate(model.model.body_parentid) if parent]
    far = [offset for offset in offsets if offset.any()]
    (far[0] if far else model.model.site_pos[model.model.eq_obj1id[0]])[:] *= 1.001


def turned_axis(model: Model) -> None:
    """The first joint's axis 0.1 degrees off."""
    axis = model.model.jnt_axis[0]
    axis += math.tan(0.1 * DEGREE) * np.cross(axis, [0.36, 0.48, 0.8])


def shifted_closure(model: Model) -> None:
    """The first closure is anchored 0.1 mm off."""
    if model.model.eq_type[0] == mujoco.mjtEq.mjEQ_WELD:
        model.model.eq_data[0, 3:6] += [6e-5, 0.0, 8e-5]
    else:
        model.model.site_pos[model.model.eq_obj1id[0]] += [6e-5, 0.0, 8e-5]


@pytest.mark.parametrize("defect", [longer_link, turned_axis, shifted_closure])
@pytest.mark.parametrize("name", MACHINES)
def test_a_model_built_a_little_wrong_is_open(name: str, defect: Callable[[Model], None]) -> None:
    machine = MACHINES[name]()
    model, drives = Model(machine), driven(machine, TIMES)
    defect(model)
    openings = []
    for sample in range(len(TIMES)):
        model.put(drives, sample)
        openings.append(model.opening)
    assert max(openings) > 1e-5


@pytest.mark.parametrize(("name", "change"), [
    ("cardan", {"bend": 30.1 * DEGREE}), ("double-cardan", {"phasing": 0.1 * DEGREE}),
    ("spherical-four-bar", {"coupler": 60.1 * DEGREE}), ("rssr", {"rod": 0.42 * 1.001}),
    ("rssr", {"crank": 0.08 * 1.001}), ("rssr", {"branch": -1.0}),
    ("bennett", {"side": 0.2, "other_twist": 75.1 * DEGREE}), ("sarrus", {"upper": 0.2 * 1.001}),
    ("delta", {"rod": 1.244 * 1.001}), ("stewart", {"base": 0.5 * 1.001}), ("tilted-slider-crank", {"offset": 0.0201}),
])  # fmt: skip
def test_another_machines_closed_form_does_not_fit_the_model(name: str, change: dict[str, float]) -> None:
    machine, other = MACHINES[name](), MACHINES[name](**change)
    model, drives = Model(machine), driven(machine, TIMES)
    openings = []
    for sample in range(len(TIMES)):
        model.put(drives, sample, other)
        openings.append(model.opening)
    assert max(openings) > 1e-6
    # And it is a machine of its own.
    model = Model(other)
    model.put(drives, 3)
    assert model.opening < 1e-14


@pytest.mark.parametrize(
    ("name", "size"), [("rssr", {"rod": 1.0}), ("sarrus", {"other_lower": 0.5}), ("delta", {"rod": 0.3})]
)
def test_a_machine_whose_links_do_not_reach_is_refused(name: str, size: dict[str, float]) -> None:
    with pytest.raises(InvalidInput, match="cannot be assembled in the reference pose"):
        MACHINES[name](**size)


# -- derivatives -------------------------------------------------------------------------------------------------------

SAMPLES = 128
RATES = 2j * math.pi * np.fft.fftfreq(SAMPLES, 1.0 / SAMPLES)


def of_fourier_series(values: Array, order: int, later: float = 0.0) -> Array:
    """A derivative by time, some time later, of what repeats after 1 s: (T, ...)."""
    factors = RATES**order * np.exp(RATES * later)
    return np.fft.ifft(np.fft.fft(values, axis=0) * factors.reshape(-1, *[1] * (values.ndim - 1)), axis=0).real


@pytest.mark.parametrize("name", MACHINES)
def test_derivatives_to_jerk_are_those_of_the_fourier_series(name: str) -> None:
    # Every law repeats after 1 s, and so do points and rates of joints: their Fourier series converges to rounding.
    machine = MACHINES[name]()
    drives = driven(machine, np.arange(SAMPLES) / SAMPLES, 3)
    rates = [values[1:] for values in machine.joints(drives).values()]
    for values in (*machine.points(drives).values(), *rates):
        for order in range(1, len(values)):
            size = (2.0 * math.pi) ** order * max(np.abs(values[0]).max(), 1e-3)
            assert np.abs(values[order] - of_fourier_series(values[0], order)).max() < 1e-9 * size
            # Negative control: 1e-5 of a period later it is another derivative, where there is one.
            elsewhere = np.abs(values[order] - of_fourier_series(values[0], order, 1e-5)).max()
            assert elsewhere > 1e-6 * size or np.ptp(values[order]) < 1e-9
