"""A model is loaded without the files and plugins that are not there, and what goes with them is said."""

from __future__ import annotations

from pathlib import Path

import mujoco

from conrod.mjcf.missing_files import load_with_notes

LINK = '<body name="{}"><joint/><geom size="0.1"/></body>'
PLUGINS = """<mujoco><extension><plugin plugin="my.spring"><instance name="soft"/></plugin><plugin plugin="my.cable"/>
</extension><worldbody><geom size="1"/><include file="frame.xml"/>
<body name="d"><joint name="j"/><geom size="0.1"/></body></worldbody>
<actuator><plugin plugin="my.spring" instance="soft" joint="j"/></actuator></mujoco>"""
SKY = " ".join(f'file{side}="{side}.png"' for side in ("right", "left", "up", "down", "front", "back"))


def test_unknown_plugins_are_left_out_of_included_files_too(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    frame = f'<mujoco>{LINK.format("a")}<include file="parts/rest.xml"/>{LINK.format("c")}</mujoco>'
    (tmp_path / "frame.xml").write_text(frame, encoding="utf-8")
    rest = '<mujoco><body><plugin plugin="my.cable"/><joint/><geom size="0.1"/></body></mujoco>'
    (tmp_path / "parts" / "rest.xml").write_text(rest, encoding="utf-8")
    (tmp_path / "model.xml").write_text(PLUGINS, encoding="utf-8")
    model, notes = load_with_notes(tmp_path / "model.xml")
    lacks = "is not known to MuJoCo {} and left out, with its {}: what it does is missing"
    assert notes == (
        f"plugin my.spring {lacks.format(mujoco.__version__, 'actuator')}",
        f"plugin my.cable {lacks.format(mujoco.__version__, 'force on body')}",  # of no name
    )
    # All bodies are there, in the order of the files.
    assert [model.body(k).name for k in range(model.nbody)] == ["world", "a", "", "c", "d"]
    assert model.nu == 0


def test_all_files_of_a_missing_sky_are_left_out(tmp_path: Path) -> None:
    (tmp_path / "right.png").write_bytes(b"")
    (tmp_path / "model.xml").write_text(
        f'<mujoco><asset><texture name="sky" type="skybox" {SKY}/></asset><worldbody>{LINK.format("a")}</worldbody>'
        "</mujoco>",
        encoding="utf-8",
    )
    model, (note,) = load_with_notes(tmp_path / "model.xml")
    assert model.ntex == 0
    assert "(left.png, up.png, down.png" in note
    assert "right.png" not in note


def test_missing_mesh_without_a_name_is_called_as_its_file(tmp_path: Path) -> None:
    body = LINK.format("a").replace("</body>", '<geom type="mesh" mesh="arm"/></body>')
    (tmp_path / "model.xml").write_text(
        f'<mujoco><asset><mesh file="arm.stl"/></asset><worldbody>{body}</worldbody></mujoco>',
        encoding="utf-8",
    )
    model, notes = load_with_notes(tmp_path / "model.xml")
    assert (model.nmesh, model.ngeom) == (0, 1)
    assert notes == (
        "1 mesh (arm.stl) is not there and left out: no motion needs it, but contacts of 1 geom are not seen",
        "a lacks the mass of arm.stl: its motion under forces is another",
    )
