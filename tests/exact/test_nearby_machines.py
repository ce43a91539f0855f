"""A machine whose poses are found from those of another with about its lengths moves as one that is tracked anew."""

from __future__ import annotations

import numpy as np
import pytest

from conrod.errors import InvalidInput
from conrod.exact.assembly_branch import AssemblyBranch
from conrod.scenes import catalogue_scene

ANGLES = np.linspace(0.0, 2.0 * np.pi, 181)


def length_of(name: str) -> str:
    """The first length of a machine that is not zero."""
    scene = catalogue_scene(name)
    return next(one for one, facts in scene.parameter_facts().items() if facts.unit == "m" and scene.parameters[one])


@pytest.mark.parametrize("share", [1e-5, 0.01])
@pytest.mark.parametrize("name", ["six-bar", "crank-shaper", "jansen-leg", "web-cutter"])
def test_nearby_machine_moves_as_one_tracked_anew(name: str, share: float) -> None:
    scene, length = catalogue_scene(name), length_of(name)
    values = {length: (1.0 + share) * scene.parameters[length]}
    near, anew = scene.with_nearby_parameters(**values), scene.with_parameters(**values)
    found, exact = (one.kinematics.derivatives(ANGLES) for one in (near, anew))
    for order, (one, other) in enumerate(zip(found, exact, strict=True)):
        np.testing.assert_allclose(one, other, rtol=0.0, atol=1e-12 * np.abs(other).max(), err_msg=f"order {order}")
    assert near == anew
    # Negative control: half of that change is seen.
    half = scene.with_nearby_parameters(**{length: (1.0 + 0.5 * share) * scene.parameters[length]})
    assert np.abs(half.kinematics.poses(ANGLES) - exact[0]).max() > 1e-3 * share


def test_nearby_machine_is_not_tracked(monkeypatch: pytest.MonkeyPatch) -> None:
    scene, length = catalogue_scene("six-bar"), length_of("six-bar")
    _ = scene.kinematics.lengths

    def track(*_: object) -> list[object]:
        raise AssertionError("the branch was tracked")

    monkeypatch.setattr(AssemblyBranch, "_track_to", track)
    near = scene.with_nearby_parameters(**{length: 1.000123 * scene.parameters[length]})
    assert near.kinematics.turns_fully
    with pytest.raises(AssertionError, match="tracked"):
        scene.with_parameters(**{length: 1.000123 * scene.parameters[length]})


def test_machine_far_away_is_refused_as_when_tracked() -> None:
    scene = catalogue_scene("web-cutter")
    length = length_of("web-cutter")
    for make in (scene.with_nearby_parameters, scene.with_parameters):
        with pytest.raises(InvalidInput):
            make(**{length: 10.0 * scene.parameters[length]})
