"""What a user is told whose name is not in a list: the nearest, and a list that a line of a terminal bears."""

from __future__ import annotations

import pickle
import traceback
from pathlib import Path

from conrod.errors import MAX_CHOICES, no_such_file, portable, unknown_choice

MANY = [f"joint_{number:02}" for number in range(40)]


def test_long_list_is_cut_to_the_nearest_where_one_is_near() -> None:
    said = str(unknown_choice("joint", "joint_07x", MANY))
    assert said.startswith("unknown joint 'joint_07x': did you mean 'joint_07'? choose from joint_")
    assert said.endswith(f" and {len(MANY) - MAX_CHOICES} more")
    assert said.count("joint_") == 2 + MAX_CHOICES


def test_long_list_is_left_to_the_command_that_prints_it() -> None:
    said = str(unknown_choice("joint", "joint_07x", MANY, "conrod joints"))
    assert said == "unknown joint 'joint_07x': did you mean 'joint_07'? all: conrod joints"


def test_a_name_of_any_length_is_echoed_shortened() -> None:
    said = str(unknown_choice("joint", "x" * 100_000, MANY[:3]))
    assert len(said) < 200
    assert said.endswith("..': choose from joint_00, joint_01, joint_02")


def test_traceback_of_an_error_that_cannot_be_sent_is_kept() -> None:
    class LocalError(Exception):
        """An error that cannot be pickled, as its class has no place in a module."""

    try:
        raise LocalError("far away")
    except LocalError as error:
        sent = pickle.loads(pickle.dumps(portable(error)))
    assert str(sent) == "LocalError: far away"
    assert "test_errors.py" in "".join(traceback.format_exception(sent))


def test_all_names_are_listed_if_none_is_near_or_they_are_few() -> None:
    for given, names in (("zzz", MANY), ("joint_07x", MANY[:MAX_CHOICES])):
        said = str(unknown_choice("joint", given, names, "conrod joints"))
        assert said.endswith(f"choose from {', '.join(names)}")


def test_list_that_no_line_bears_is_cut_at_whole_names() -> None:
    many = [f"machine_{number:03}" for number in range(100)]
    said = str(unknown_choice("scene", "zzz", many, "conrod show"))
    assert said.endswith(f"machine_011 and {100 - MAX_CHOICES} more; all: conrod show")
    # Without a command that lists them all are named.
    assert str(unknown_choice("scene", "zzz", many)).endswith(f"choose from {', '.join(many)}")


def test_nothing_typed_is_near_to_nothing() -> None:
    assert str(unknown_choice("pin", "", ["a", "b"])) == "unknown pin '': choose from a, b"


def test_missing_file_names_the_nearest_of_its_kind(tmp_path: Path) -> None:
    for name in ("saw.xml", "saw.csv", "press.xml"):
        (tmp_path / name).touch()
    assert str(no_such_file(tmp_path / "sow.xml")).endswith(f"no such file: did you mean '{tmp_path / 'saw.xml'}'?")
    # Negative control: none is near, or only a file of another kind.
    for name in ("gripper.xml", "sow.toml"):
        assert str(no_such_file(tmp_path / name)) == f"{tmp_path / name}: there is no such file"
    assert "there is no folder" in str(no_such_file(tmp_path / "none" / "saw.xml"))
