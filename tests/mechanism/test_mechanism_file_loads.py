"""Springs, dampers, forces, torques and a start in motion as a file tells them."""

from __future__ import annotations

import copy
import math
from typing import Any

import numpy as np
import pytest
from described import SLIDER_CRANK, tables

from conrod.errors import InvalidInput
from conrod.exact.dynamics.forward import ForwardDynamics
from conrod.mechanism.loads import (
    Displacement,
    Distance,
    Elastic,
    Friction,
    SpeedLine,
    Steady,
    StrokePulse,
    TimePulse,
    Turn,
    Viscous,
)
from conrod.mechanism.mechanism import ConstantForce
from conrod.scenes.described_scene import scene_from_tables

LOADS: dict[str, Any] = {
    "springs": {
        "return": {"connects": ["ground.O12", "slider"], "stiffness": "2 N/mm", "rest": "400 mm"},
        "wind": {"turns": ["crank", "rod"], "stiffness": "3 N*m/rad", "rest": "90 deg"},
    },
    "dampers": {"oil": {"turns": ["ground", "crank"], "damping": 0.5}},
    "forces": {
        "weight": {"body": "slider", "force": [0, "-10 N"]},
        "gas": {"point": "slider", "direction": "180 deg", "law": "constant", "force": "1 kN"},
        "cut": {
            "point": "slider", "direction": 0, "law": "stroke-pulse", "peak": "5 kN", "begin": 0.5, "end": "750 mm",
            "against": "forward",
        },
        "knock": {"point": "rod.G", "direction": "90 deg", "law": "time-pulse", "peak": 20, "end": "10 ms"},
        "slide": {"point": "slider", "direction": 0, "law": "friction", "force": "30 N", "creep": "10 mm/s"},
    },
    "torques": {
        "brake": {"turns": ["ground", "crank"], "law": "constant", "torque": -4},
        "motor": {"turns": ["ground", "crank"], "law": "speed-line", "stall": "50 N*m", "idle": "300 rpm"},
        "kick": {"turns": ["ground", "crank"], "law": "time-pulse", "peak": "9 N*m", "begin": 0.1, "end": 0.2},
        "bearing": {"turns": ["crank", "rod"], "law": "friction", "torque": 0.2, "creep": "1 rad/s"},
    },
}  # fmt: skip


def loaded_document(**changes: Any) -> dict[str, Any]:
    whole = tables(SLIDER_CRANK) | copy.deepcopy(LOADS)
    return whole | changes


def test_file_reads_every_load_law_with_its_coordinate() -> None:
    mechanism = scene_from_tables(loaded_document()).mechanism()
    assert mechanism.forces == (ConstantForce("slider", (0.0, -10.0)),)
    slider, crank = Displacement("slider", (0.0, 0.0), 0.0), Turn("ground", "crank")
    assert {load.name: (load.along, load.law) for load in mechanism.loads} == {
        "springs.return": (Distance("ground", "slider", (0.0, 0.0), (0.0, 0.0)), Elastic(2000.0, 0.4)),
        "springs.wind": (Turn("crank", "rod"), Elastic(3.0, math.pi / 2.0)),
        "dampers.oil": (crank, Viscous(0.5)),
        "forces.gas": (Displacement("slider", (0.0, 0.0), math.pi), Steady(1000.0)),
        "forces.cut": (slider, StrokePulse(5000.0, 0.5, 0.75, 1)),
        "forces.knock": (Displacement("rod", (0.28, 0.0), math.pi / 2.0), TimePulse(20.0, 0.0, 0.01)),
        "forces.slide": (slider, Friction(30.0, 0.01)),
        "torques.brake": (crank, Steady(-4.0)),
        "torques.motor": (crank, SpeedLine(50.0, 10.0 * math.pi)),
        "torques.kick": (crank, TimePulse(9.0, 0.1, 0.2)),
        "torques.bearing": (Turn("crank", "rod"), Friction(0.2, 1.0)),
    }


def test_scene_key_contains_loads_only_if_there_are_any() -> None:
    bare, whole = scene_from_tables(tables(SLIDER_CRANK)), scene_from_tables(loaded_document())
    assert "loads" not in bare.identity()["mechanism"]
    assert "start_rates" not in bare.identity()
    assert [load["law"]["kind"] for load in whole.identity()["mechanism"]["loads"]].count("TimePulse") == 2
    softer = whole.with_parameters(**{"springs.return.stiffness": 1000.0})
    assert softer.parameters_text != whole.parameters_text
    assert isinstance(softer.mechanism().loads, tuple)


def test_free_motion_starts_at_given_rates_or_crank_speed() -> None:
    bare = scene_from_tables(tables(SLIDER_CRANK))
    assert bare.start_rates == {"crank": 30.0}
    given = loaded_document(start={"rod": {"turn": 0}, "crank": {"rate": "-60 rpm"}})
    scene = scene_from_tables(given)
    assert scene.start_rates == {"crank": pytest.approx(-2.0 * math.pi)}
    assert scene.identity() != scene_from_tables(loaded_document()).identity()
    motion = ForwardDynamics(scene.mechanism()).motion(np.array([0.0, 1e-3]), rates=scene.start_rates)
    assert motion.rates[0, 2] == pytest.approx(-2.0 * math.pi)


REFUSED = [
    ("springs.x", {"connects": ["ground", "rod"], "turns": ["ground", "rod"], "stiffness": 1}, "give connects"),
    ("springs.x", {"connects": ["rod.A", "rod.B"], "stiffness": 1}, "joins 'rod' with itself"),
    ("springs.x", {"connects": ["ground", "rod"], "stiffness": 0}, "springs.x.stiffness"),
    ("dampers.x", {"turns": ["crank", "crank"], "damping": 1}, "does not turn against itself"),
    ("forces.x", {"point": "ground.O12", "direction": 0, "law": "constant", "force": 1}, "moves nothing"),
    ("forces.x", {"body": "rod", "force": [0, 1], "law": "constant"}, "unknown field in forces.x 'law'"),
    (
        "forces.x",
        {"point": "rod.G", "direction": 0, "law": "time-pulse", "peak": 1, "begin": 2, "end": 1},
        "less than end",
    ),
    ("forces.x", {"point": "rod.G", "direction": 0, "law": "friction", "force": 1, "creep": 0}, "forces.x.creep"),
    (
        "forces.x",
        {"point": "rod.G", "direction": 0, "law": "stroke-pulse", "peak": 1, "begin": 0, "end": 1, "against": "both"},
        "unknown forces.x.against 'both'",
    ),
    ("torques.x", {"turns": ["ground", "crank"], "law": "speed-line", "stall": 1, "idle": 0}, "torques.x.idle"),
    ("start.crank", {"turn": 1, "rate": 3}, "leave it out but for its rate"),
    ("start.ground", {"rate": 3}, "it does not move"),
]


@pytest.mark.parametrize(("place", "value", "expected"), REFUSED)
def test_file_error_names_the_place(place: str, value: Any, expected: str) -> None:
    whole = loaded_document()
    table, name = place.split(".")
    whole[table] = whole.get(table, {}) | {name: value}
    with pytest.raises(InvalidInput) as caught:
        scene_from_tables(whole)
    assert expected in str(caught.value)
    assert "\n" not in str(caught.value)
