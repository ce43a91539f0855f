"""What users give is found, or refused with what there is instead; nobody's engine is left out without a word."""

from __future__ import annotations

import math
from typing import Any

import pytest
from catalogue import CAM, SAW

from conrod import InvalidInput
from conrod.engines import engine_named
from conrod.errors import ConrodWarning
from conrod.execution import resolve_arguments
from conrod.execution.files import folder_to_write
from conrod.execution.resolve_arguments import (
    arguments_of_files,
    check_sample_count,
    choose_engines,
    engine_names_given,
    is_mechanism_file,
    is_single_scene,
    make_plan,
    mechanism_file_bytes,
    scene,
    scene_by_name,
    scene_label,
    scenes_by_name,
    select_engines,
    select_presets,
    select_scene,
    select_scenes,
)
from conrod.execution.result import Plan
from conrod.execution.tolerances import check_tolerance
from conrod.scenes import CATALOGUE, SCENES, catalogue_text
from conrod.scenes.space import MACHINES

MUJOCO, PYMUNK = engine_named("mujoco"), engine_named("pymunk")


def refusal(call: Any, *given: Any) -> str:
    with pytest.raises(InvalidInput) as raised:
        call(*given)
    return str(raised.value)


# -- scenes ------------------------------------------------------------------------------------------------------------


def test_scenes_are_found_by_name_object_pair_or_mapping() -> None:
    assert scenes_by_name([]) == SCENES
    assert scenes_by_name({"mine": SAW}) == {"mine": SAW}
    assert scenes_by_name("saw-40rpm") == {"saw-40rpm": SAW}
    assert scenes_by_name(SAW) == {SAW.kind: SAW}
    assert scenes_by_name(("mine", SAW)) == {"mine": SAW}
    assert list(scenes_by_name(["six-bar", ("mine", SAW), CAM])) == ["six-bar", "mine", CAM.kind]
    assert refusal(scenes_by_name, [("mine", SAW), ("mine", CAM)]) == (
        "two scenes are called 'mine': give them as a mapping, by names of your own"
    )
    assert [is_single_scene(one) for one in ("saw", SAW, ("mine", SAW), ["saw"], ("saw", "cam"), (SAW, CAM, SAW))] == [
        *(True, True, True, False, False, False)
    ]


def test_one_scene_is_found_with_its_name_and_its_parameters() -> None:
    assert scene_by_name(("mine", SAW)) == ("mine", SAW)
    assert scene_by_name(SAW) == (SAW.kind, SAW)
    assert scene_by_name("saw-40rpm") == ("saw-40rpm", SAW)
    assert select_scene(SAW, ["crank=80 mm"])[1].parameters["crank"] == 0.08
    assert select_scene("saw-40rpm", ["crank=0.08"]) == ("saw-40rpm", SAW.with_parameters(crank=0.08))
    assert scene("saw-40rpm", crank="80 mm", rod=0.31).parameters["rod"] == 0.31
    assert refusal(select_scene, "catalogue", []) == (
        "'catalogue' stands for many machines: name one of them; `conrod show` lists them"
    )
    assert (scene_label("typed"), scene_label(SAW)) == ("typed", SAW.kind)


def test_a_parameter_is_given_to_each_scene_that_has_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found = select_scenes(["saw-40rpm", "cam-follower"], ["crank=0.08"])
    assert (found["saw-40rpm"].parameters["crank"], found["cam-follower"]) == (0.08, SCENES["cam-follower"])
    monkeypatch.setattr(resolve_arguments, "catalogue_names", lambda: ("six-bar", "geneva"))
    assert list(select_scenes(["saw-40rpm", CATALOGUE], [])) == ["saw-40rpm", "six-bar", "geneva"]
    assert list(select_scenes([], [])) == list(SCENES)
    assert "crankk" in refusal(select_scenes, ["saw-40rpm"], ["crankk=0.08"])


def test_machine_in_space_is_refused_with_commands_that_take_it() -> None:
    name = next(iter(MACHINES))
    assert refusal(select_scenes, ["saw-40rpm", name], []) == (
        f"{name} is a machine in space: `conrod validate {name}` and `conrod export {name} --format mjcf` take it"
    )


def test_a_file_is_a_scene_by_the_name_written_in_it(tmp_path: Any) -> None:
    file, other = tmp_path / "copy.TOML", tmp_path / "other.toml"
    text = catalogue_text("six-bar")
    for one in (file, other):
        one.write_text(text, encoding="utf-8")
    assert list(select_scenes([str(file)], [])) == ["six-bar"]
    assert arguments_of_files([str(file), "saw-40rpm"]) == {"six-bar": str(file)}
    taken = "name = 'six-bar' is taken by another scene; give the one in the file another"
    assert refusal(select_scenes, [str(file), str(other)], []) == f"{other}: {taken}"
    assert refusal(select_scenes, ["six-bar", str(file)], []) == f"{file}: {taken}"
    assert refusal(select_scenes, [str(file), "six-bar"], []) == f"{file}: {taken}"
    assert refusal(select_scenes, ["machine.yaml"], []) == (
        "machine.yaml: a machine goes by its name, or is a file that ends in .toml"
    )
    assert [is_mechanism_file(one) for one in ("a.toml", "a.TOML", "toml", "a.json")] == [True, True, False, False]
    assert mechanism_file_bytes("saw-40rpm") is None
    assert mechanism_file_bytes("six-bar") == mechanism_file_bytes(str(file)) == text.encode()


# -- engines and presets -----------------------------------------------------------------------------------------------


def test_engines_are_found_by_name_and_object() -> None:
    assert choose_engines("pymunk") == [PYMUNK]
    assert choose_engines([PYMUNK]) == [PYMUNK]
    assert choose_engines(["mujoco", PYMUNK]) == [PYMUNK, MUJOCO]
    assert choose_engines(None) == select_engines([]) == [MUJOCO, PYMUNK]
    assert select_engines(["pymunk", "mujoco", "pymunk"]) == [PYMUNK, MUJOCO]
    assert [engine_names_given(one) for one in ("all", None, ["all", PYMUNK])] == [("all",), (), ("all", "pymunk")]


def test_engine_is_left_out_with_a_warning_when_it_cannot_load(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Any] = []

    def load(extras: Any) -> Any:
        asked.append(tuple(extras))
        return [PYMUNK], ["mujoco: no module"]

    monkeypatch.setattr(resolve_arguments, "loadable_engines", load)
    monkeypatch.setattr(resolve_arguments, "installed_extras", lambda: ("mjx",))
    with pytest.warns(ConrodWarning, match=r"^left out: mujoco: no module$"):
        assert choose_engines("all") == [PYMUNK]
    with pytest.warns(ConrodWarning):
        assert choose_engines(None) == [PYMUNK]
    # Extras take part where all are asked for.
    assert asked == [("mjx",), ()]
    assert select_engines(["mujoco", "all"]) == [PYMUNK]


def test_presets_are_those_that_the_engines_have() -> None:
    both = [MUJOCO, PYMUNK]
    assert select_presets(both, None) == {"mujoco": tuple(MUJOCO.presets), "pymunk": tuple(PYMUNK.presets)}
    assert select_presets(both, "hardened") == {"mujoco": ("hardened",), "pymunk": ()}
    assert refusal(select_presets, [PYMUNK], "hardened").startswith("pymunk has no preset 'hardened', mujoco")
    assert refusal(select_presets, [PYMUNK], "hardened").endswith(
        f" has: choose from {', '.join(sorted(PYMUNK.presets))}"
    )
    assert refusal(select_presets, both, "hardend") == (
        "unknown preset 'hardend': did you mean 'hardened'? choose from hardened, stock, tuned"
    )


# -- plans -------------------------------------------------------------------------------------------------------------


def test_a_plan_has_what_was_asked_for() -> None:
    made = make_plan({"saw": SAW}, 250, 3, {"position": 1e-4})
    assert made == Plan(250, 3.0, {"position": 1e-4})
    assert make_plan({"saw": SAW}, None, 2, None) == Plan(None, 2.0, None)


def test_more_samples_than_can_be_kept_are_refused() -> None:
    assert make_plan({"saw": SAW}, 1000, 500, None).revolutions == 500.0
    too_many = "1001 steps x 500 revolutions = 500500 samples are too many: there may be 500000"
    assert refusal(make_plan, {"saw": SAW}, 1001, 500, None) == f"saw: {too_many}"
    # Without a number of steps it is the scene's own; other studies have other limits.
    assert refusal(make_plan, {"saw": SAW, "b": SAW}, None, 501, None).startswith("saw: 1000 steps x 501 rev")
    assert refusal(make_plan, {"saw": SAW}, 100, 5, None, 499).endswith("there may be 499")
    check_sample_count("saw", 1000, 500)
    assert refusal(check_sample_count, "saw", 1001, 500) == f"saw: {too_many}"
    for call in (lambda n, k: check_sample_count("saw", n, k), lambda n, k: make_plan({"saw": SAW}, n, k, None)):
        assert refusal(call, 1, 1).startswith("--steps-per-rev")
        assert refusal(call, 10_000_001, 1).startswith("--steps-per-rev")
        assert refusal(call, 2, 0).startswith("--revolutions")
        assert refusal(call, 2, 1_000_001).startswith("--revolutions")


@pytest.mark.parametrize("bad", [0.0, -1.0, math.nan, math.inf, 1e-301, 1.1e6])
def test_a_tolerance_is_a_positive_number(bad: float) -> None:
    assert refusal(check_tolerance, {"velocity": bad}).startswith("--tolerance velocity")
    assert refusal(make_plan, {"saw": SAW}, 100, 1, {"velocity": bad}).startswith("--tolerance velocity")


def test_a_tolerance_is_of_a_known_quantity_in_its_unit() -> None:
    given = {"position": 1e-300, "phase": 1e6}
    assert check_tolerance(given) == given
    assert check_tolerance(given) is not given
    assert refusal(check_tolerance, {"positon": 1.0}).startswith("unknown quantity 'positon': did you mean 'position'?")
    assert refusal(check_tolerance, 1e-4) == (
        "--tolerance 0.0001: give numbers by quantity, such as {'position': 1e-4}"
    )
    assert "m/s" in refusal(check_tolerance, {"velocity": -1.0}, {"velocity": "m/s"})
    assert refusal(check_tolerance, {"position": 1.0}, {"velocity": "m/s"}).startswith("unknown quantity 'position'")


@pytest.mark.parametrize("text", ["", " ", "-"])
def test_folder_without_a_name_is_refused_by_its_option(text: str) -> None:
    with pytest.raises(InvalidInput) as told:
        folder_to_write(text, "--out")
    assert str(told.value) == f"--out {text!r}: give the name of a folder"
