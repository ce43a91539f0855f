"""conrod's exact free motion held against what others published of the same machines."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from linkages import slider_crank

from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.exact.motion import Array
from conrod.execution.resolve_arguments import scene
from conrod.mechanism.loads import Load, Steady, Turn
from conrod.mechanism.mechanism import GROUND, Body

# The N-four-bar of the IFToMM library of computational benchmark problems with two four-bars, as solved by Exudyn:
# step [s] -> place [m] and velocity [m/s] of the first tip after 10 s (its TestModels/fourBarMechanismIftomm.py).
FOUR_BARS = {
    1e-3: (0.3284112372, 0.9445348375, 1.422958522, -0.4947565894),
    5e-4: (0.3284465114, 0.9445225721, 1.423028497, -0.494841072),
    2.5e-4: (0.3284552113, 0.9445195467, 1.423045728, -0.4948619021),
    1.25e-4: (0.3284573768, 0.9445187937, 1.423050003, -0.4948670827),
}
# A slider-crank of 0.1 m and 0.3 m driven from rest by 0.1 N m, by MATLAB's ode45 with tolerances of 1e-6: time [s],
# crank angle [rad] and rate [rad/s] (Exudyn's TestModels/slidercrankRefSolM0.1_tol1e-6.txt).
SLIDER_CRANK = (
    (0.24799245, 1.1399223, 5.6969749),
    (0.49931379, 4.0627317, 15.196761),
    (0.99890747, 14.105539, 20.408051),
    (1.5001275, 31.247025, 62.667853),
    (1.9994585, 55.051301, 39.949817),
)
MOTOR = Load("motor", Turn(GROUND, "crank"), Steady(0.1))
MACHINE = replace(
    slider_crank(0.1, 0.3, turn=0.0),
    bodies=(
        Body("crank", 0.2, 0.2 * 0.1**2 / 12.0, (0.05, 0.0)),
        Body("rod", 0.2, 0.2 * 0.3**2 / 12.0, (0.15, 0.0)),
        Body("slider", 0.4, 4e-4),
    ),
    loads=(MOTOR,),
)


def tip_of_four_bars() -> Array:
    """Place and velocity of the first tip after 10 s."""
    machine: Any = scene("four-bar-chain-2")
    motion = ForwardDynamics(machine.kinematics.mechanism).motion(np.linspace(0.0, 10.0, 101), machine.start_rates)
    place, rate = machine.kinematics.point_derivatives([motion.poses, motion.rates])["tip"]
    return np.concatenate([place[-1], rate[-1]])


def test_published_four_bar_runs_converge_at_order_2() -> None:
    published, exact = np.array(list(FOUR_BARS.values())), tip_of_four_bars()
    errors = np.abs(published - exact)
    orders = np.log2(errors[:-1] / errors[1:])
    assert orders == pytest.approx(2.0, abs=0.04)
    limit = published[-1] + (published[-1] - published[-2]) / 3.0
    assert limit == pytest.approx(exact, abs=1e-7)
    # Negative control: a millionth of a second later it is elsewhere.
    assert np.abs(limit[:2] - exact[:2] - 1e-6 * exact[2:]).max() > 1e-6


@pytest.mark.slow
def test_published_slider_crank_error_matches_its_energy_error() -> None:
    times, angles, rates = np.array([(0.0, 0.0, 0.0), *SLIDER_CRANK]).T
    found = ForwardDynamics(MACHINE).motion(times, {"crank": 0.0})
    assert found.poses[:, 2] == pytest.approx(angles, rel=2e-5)
    assert found.rates[:, 2] == pytest.approx(rates, rel=3e-4)
    # Negative control: a torque larger by a thousandth.
    wrong = replace(MACHINE, loads=(replace(MOTOR, law=Steady(0.1001)),))
    assert ForwardDynamics(wrong).motion(times, {"crank": 0.0}).poses[:, 2] != pytest.approx(angles, rel=2e-5)
