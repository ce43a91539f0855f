"""The closed circle: the exact motion goes out as an FMU, comes back as any tool's FMU does, and nothing is lost."""

from __future__ import annotations

import json
import shutil
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import conrod

pytest.importorskip("fmpy", reason="FMUs are run by the extra fmi")
pytestmark = [
    pytest.mark.skipif(shutil.which("cc") is None, reason="there is no C compiler"),
    pytest.mark.usefixtures("at_once"),
]
EXACT = ",".join(f"{quantity}=1e-12" for quantity in ("position", "velocity", "acceleration"))


def judged(folder: Path, scene: str, *options: str, exported: tuple[str, ...] = ()) -> tuple[int, Any]:
    """Exit status and findings of a scene that was exported with some parameters."""
    done = conrod("export", scene, "--format", "fmu", "-o", "unit.fmu", *exported, cwd=folder)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    done = conrod("validate", "unit.fmu", "--scene", scene, *options, "--json", "o.json", cwd=folder)
    return done.returncode, json.loads((folder / "o.json").read_text())["parts"]["table"]["findings"]


# A closed form, and a pass, which begins before time 0.
@pytest.mark.parametrize("mode", ["co-simulation", "model-exchange"])
@pytest.mark.parametrize("scene", ["saw-500rpm", "geneva"])
def test_an_exported_machine_is_judged_exact_at_any_step(scene: str, mode: str, tmp_path: Path) -> None:
    status, found = judged(tmp_path, scene, "--preset", mode, "--tolerance", EXACT)
    assert status == 0
    assert max(one["size"]["max"] for errors in found["errors"].values() for one in errors.values()) < 1e-12


def test_a_rod_that_is_a_micrometre_longer_is_off_by_its_sensitivity(tmp_path: Path) -> None:
    longer = 1e-6  # [m]
    status, found = judged(
        tmp_path, "saw-500rpm", "--tolerance", "position=1e-9", exported=("--set", f"rod={0.3 + longer!r}")
    )
    assert status == 1
    # Document 002: x of C is sqrt(l^2 - e^2) - r + r cos t - w with w = sqrt(l^2 - u^2) and u = r sin t - e; by l:
    t, rod, crank, offset = np.linspace(0.0, 2.0 * np.pi, 1001), 0.3, 0.1, 0.09
    across = crank * np.sin(t) - offset
    w = np.sqrt(rod**2 - across**2)
    sensitivity = rod / np.sqrt(rod**2 - offset**2) - rod / w
    rate = -rod * across * crank * np.cos(t) / w**3  # of it, by the crank angle
    stroke = 0.211138  # [m]
    sizes = {quantity: found["errors"]["C"][quantity]["size"]["max"] for quantity in ("position", "velocity")}
    expected = {"position": np.abs(sensitivity).max(), "velocity": np.abs(rate).max()}
    assert sizes == pytest.approx({name: longer / stroke * size for name, size in expected.items()}, rel=2e-5)
