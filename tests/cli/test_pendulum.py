"""A machine without closures goes through the verbs that take a scene."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.support.command_line import conrod


def test_a_pendulum_is_validated_in_kinematic_and_dynamic_mode(tmp_path: Path) -> None:
    done = conrod("validate", "pendulum", "--steps-per-rev", "100", "--ledger", "ledger", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.count("kinematic mode") == 2
    assert "Traceback" not in done.stderr


@pytest.mark.slow
def test_a_pendulum_is_swept(tmp_path: Path) -> None:
    done = conrod("sweep", "pendulum", "--grid", "coarse", "--ledger", "ledger", cwd=tmp_path)
    assert done.returncode == 0, done.stderr
