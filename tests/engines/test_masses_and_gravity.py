"""The exact motion of a driven linkage depends on no mass and no gravity; a soft engine's error does."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest
from catalogue import PRESS, SAW

from conrod import MuJoCoSettings, compare, run


def changes(scene: Any, settings: MuJoCoSettings) -> list[float]:
    """Factors by which a light slider, and gravity switched, change the position error; the settings stay."""
    others = (scene.with_parameters(slider_mass=0.1 * scene.slider_mass), settings), (scene, without(settings))
    before = compare(run(scene, settings), scene).worst("position")
    return [compare(run(machine, used), machine).worst("position") / before for machine, used in others]


def without(settings: MuJoCoSettings) -> MuJoCoSettings:
    return replace(settings, gravity=not settings.gravity)


@pytest.mark.parametrize("scene", [SAW, PRESS], ids=["saw", "press"])
def test_hardened_mujoco_depends_on_neither(scene: Any) -> None:
    assert changes(scene, MuJoCoSettings.hardened(scene, 200)) == pytest.approx([1.0, 1.0], rel=0.01)


def test_stock_mujoco_depends_on_both() -> None:
    # Negative control: the softness is there, and it is seen.
    lighter, weightless = changes(PRESS, MuJoCoSettings.stock(PRESS, 400))
    assert lighter < 0.7
    assert weightless < 0.1
