"""A tolerance that an engine's numbers cannot tell is refused with the least that they can."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from command_line import conrod
from planted_engine import PlantedEngine

from conrod.engines.engine import DOUBLE, SINGLE
from conrod.engines.registry import engine_named
from conrod.errors import InvalidInput
from conrod.scenes import SCENES, Scene
from conrod.studies.frame.precision import check_precision, error_floor

SAW: Any = SCENES["saw-500rpm"]
PRESETS = PlantedEngine.presets


class SingleEngine(PlantedEngine):
    """The planted engine, where only the preset `stock` rounds to single precision."""

    def spacing(self, settings: Any) -> float:
        return SINGLE if settings.preset == "stock" else DOUBLE


def check(asked: dict[str, float], *presets: str, engine: PlantedEngine | None = None) -> None:
    check_precision("saw", SAW, engine or SingleEngine(), [PRESETS[name](SAW, 1000) for name in presets], asked)


@pytest.mark.parametrize("scene", SCENES.values(), ids=list(SCENES))
def test_rounding_to_single_precision_leaves_no_less_than_a_fifth_of_the_floor_and_no_more(scene: Scene) -> None:
    floor, motion = error_floor(scene, SINGLE), scene.motion(scene.kinematics.angles(1000), scene.speed)
    for k, quantity in enumerate(("position", "velocity", "acceleration")):
        exact = {name: getattr(motion.point(name), quantity) for name in scene.lengths}
        left = max(
            np.linalg.norm(values.astype(np.float32) - values, axis=1).max() / (length * abs(scene.speed) ** k)
            for (name, length) in scene.lengths.items()
            for values in [exact[name]]
        )
        assert 0.2 * floor[quantity] < left <= floor[quantity]


@pytest.mark.parametrize("quantity", ["position", "velocity", "acceleration", "total"])
def test_what_single_precision_cannot_tell_is_refused_with_the_least_that_it_can(quantity: str) -> None:
    least = error_floor(SAW, SINGLE)[quantity]
    with pytest.raises(InvalidInput, match=rf"^{quantity} = 1e-09 cannot be told by planted on saw, ") as refused:
        check({quantity: 1e-9}, "stock")
    told = float(re.search(r"ask for (\S+) or more", str(refused.value))[1])  # type: ignore[index]
    assert least <= told < 1.1 * least
    check({quantity: told}, "stock")


def test_one_preset_in_double_precision_is_enough() -> None:
    check({"position": 1e-9}, "stock", "sharp")
    check({"position": 1e-300}, "stock", engine=PlantedEngine())


@pytest.mark.parametrize("asked", [None, {}, {"phase": 1e-12}])
def test_nothing_is_refused_where_no_error_is_judged(asked: Any) -> None:
    check(asked, "stock")


@pytest.mark.parametrize(
    "words",
    [("validate", "saw-500rpm", "--tolerance", "position=1e-9"), ("recommend", "saw-500rpm", "--position", "1e-9")],
)
def test_a_command_is_refused_in_one_line(words: tuple[str, ...], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(engine_named("pymunk"), "spacing", lambda _: SINGLE, raising=False)
    done = conrod(*words, "--engine", "pymunk")
    assert (done.returncode, done.stdout) == (2, "")
    assert "position = 1e-09 cannot be told by pymunk on saw-500rpm" in done.stderr.splitlines()[-1]
