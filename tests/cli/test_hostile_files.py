"""Whatever a file says: one line and exit status 2, and no file is waited for that has no end."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest
from command_line import refusal

SLOW = pytest.mark.slow
BODY = '<body name="b"><joint name="j" type="hinge" axis="0 1 0"/><geom name="g" size="0.1" pos="0 0 -0.5"/></body>'
FIELD = '<asset><hfield name="h" nrow="30000" ncol="30000" size="1 1 1 1"/></asset>'
VERBS = {
    "lint": ("lint", "m.xml"),
    "harden": ("harden", "m.xml"),
    "validate": ("validate", "m.xml", "--scene", "saw-40rpm", "--crank", "j", "--point", "C=body:b"),
}


def model(folder: Path, beside: str = "", worldbody: str = "") -> None:
    text = f"<mujoco>{beside}<worldbody>{worldbody}{BODY}</worldbody></mujoco>"
    (folder / "m.xml").write_text(text, encoding="utf-8")


@pytest.mark.slow
@pytest.mark.parametrize("verb", VERBS)
def test_a_height_field_of_gigabytes_is_out_of_memory(verb: str, tmp_path: Path) -> None:
    model(tmp_path, FIELD, '<geom type="hfield" hfield="h"/>')
    assert "needed more memory than its limit" in refusal(*VERBS[verb], cwd=tmp_path)


@pytest.mark.parametrize("verb", ["lint", pytest.param("harden", marks=SLOW), pytest.param("validate", marks=SLOW)])
def test_what_takes_long_says_so_and_ctrl_c_ends_it(verb: str, tmp_path: Path) -> None:
    # Compiling it takes hours.
    model(tmp_path, worldbody=f'<replicate count="149999">{BODY}</replicate>')
    # What a shell starts in the background ignores Ctrl-C, and so would this.
    code = (
        "import signal\nsignal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from conrod import cli\ncli.SAID_AFTER = 2.0\ncli.main()\n"
    )
    with subprocess.Popen(
        [sys.executable, "-P", "-c", code, *VERBS[verb]], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    ) as running:  # fmt: skip
        try:
            assert running.stderr is not None
            assert "m.xml: under way, ended after 600 s, by Ctrl-C at once" in running.stderr.readline()
            os.killpg(running.pid, signal.SIGINT)
            # Standard error ends where the last process has it no more: none is left that compiles.
            assert running.stderr.read().strip() == "conrod: interrupted"
            assert running.wait() == 130
        finally:
            running.kill()
