"""`conrod harden`: what it writes, prints and refuses."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import mujoco
import pytest
from command_line import conrod

LEGGED = Path(__file__).parents[1] / "support" / "models" / "legged.xml"
WITH_A_MESH = (
    LEGGED.read_text()
    .replace("<worldbody>", '<asset><mesh name="shell" file="shell.obj"/></asset><worldbody>')
    .replace('<geom name="base"', '<geom type="mesh" mesh="shell" mass="0"/><geom name="base"')
)
ARM = """<mujoco><worldbody><body name="a"><joint/><geom size="0.1" pos="0.3 0 0"/></body></worldbody>
<equality>{}</equality></mujoco>"""


def test_printed_lines_give_the_written_model_bit_for_bit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    # A model with an asset, whose place MuJoCo keeps.
    Path("legged.xml").write_text(WITH_A_MESH)
    Path("shell.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n")
    options = "--keyframe swing --seconds 0.03 -o hard.mjb --json hard.json"
    done = conrod("harden", "legged.xml", *options.split())
    assert done.returncode == 0
    lines = done.stdout.split("in Python:\n", 1)[1].split("note:", 1)[0]
    # A fresh interpreter in another folder. Control: a line left out is seen.
    fewer = "\n".join(line for line in lines.splitlines() if "dof_invweight0" not in line)
    save = "\nmujoco.mj_saveModel(model, {!r}, None)\n"
    code = lines + save.format("pasted.mjb") + fewer + save.format("fewer.mjb")
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    subprocess.run([sys.executable, "-c", code], check=True, cwd=elsewhere)
    assert (elsewhere / "pasted.mjb").read_bytes() == Path("hard.mjb").read_bytes()
    assert (elsewhere / "fewer.mjb").read_bytes() != Path("hard.mjb").read_bytes()

    # The file that was hardened is not touched.
    assert Path("legged.xml").read_text() == WITH_A_MESH
    model = mujoco.MjModel.from_binary_path("hard.mjb")
    stock = mujoco.MjModel.from_xml_path("legged.xml")
    assert model.body("left-rod").invweight0[0] < 1e-7 * stock.body("left-rod").invweight0[0]

    document = json.loads(Path("hard.json").read_text())
    assert "content" not in document
    assert [variant["name"] for variant in document["variants"]] == ["as it is", "hardened"]
    assert document["variants"][0]["openings"][0] > 100 * document["variants"][1]["openings"][0]
    assert document["lines"].strip() == lines.strip()
    assert "mj_setConst" in done.stdout


@pytest.mark.usefixtures("at_once")
@pytest.mark.parametrize(("closure", "status", "why"), [
    ("", 1, "it has no closed loop"),
    ('<connect name="belt" body1="a" anchor="0.3 0 0" solref="0.5 1"/>', 1, "belt: softer than MuJoCo's stock"),
    ('<connect body1="a" anchor="nan 0 0"/>', 2, "eq_data is not finite"),
])  # fmt: skip
def test_model_that_cannot_be_hardened_is_not_written(closure: str, status: int, why: str, tmp_path: Path) -> None:
    (tmp_path / "model.xml").write_text(ARM.format(closure))
    done = conrod("harden", "model.xml", "-o", "hard.mjb", "--seconds", "0.1", cwd=tmp_path)
    assert done.returncode == status
    assert why in done.stdout + done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["model.xml"]
