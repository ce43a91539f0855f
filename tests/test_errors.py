"""What a user is told whose name is not in a list: the nearest, and a list that a line of a terminal bears."""

from __future__ import annotations

from conrod.errors import MAX_CHOICES, unknown_choice

MANY = [f"joint_{number:02}" for number in range(40)]


def test_long_list_is_cut_to_the_nearest_where_one_is_near() -> None:
    said = str(unknown_choice("joint", "joint_07x", MANY))
    assert said.startswith("unknown joint 'joint_07x': did you mean 'joint_07'? choose from joint_")
    assert said.endswith(f" and {len(MANY) - MAX_CHOICES} more")
    assert said.count("joint_") == 2 + MAX_CHOICES


def test_long_list_is_left_to_the_command_that_prints_it() -> None:
    said = str(unknown_choice("joint", "joint_07x", MANY, "conrod joints"))
    assert said == "unknown joint 'joint_07x': did you mean 'joint_07'? all: conrod joints"


def test_all_names_are_listed_if_none_is_near_or_they_are_few() -> None:
    for given, names in (("zzz", MANY), ("joint_07x", MANY[:MAX_CHOICES])):
        said = str(unknown_choice("joint", given, names, "conrod joints"))
        assert said.endswith(f"choose from {', '.join(names)}")
