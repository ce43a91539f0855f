"""The crank and the observed points of a model, found by their names and places where a user gives none."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np

from conrod.errors import InvalidInput, list_names
from conrod.mechanism.mechanism import GROUND, Mechanism
from conrod.mjcf.loading import joint_kind, name_or_number, names_of
from conrod.mjcf.missing_files import load_with_notes


def find_names(
    path: Path, mechanism: Mechanism, crank: str | None, points: Mapping[str, str]
) -> tuple[str, dict[str, str]]:
    """Find the crank of a model file, and its observed points as `site:NAME`; call it in a separate process.

    The crank is a hinge on the ground: the only one, the only one with an actuator, or the one that has the name of the
    scene's driver, of the driven link, or "crank", or whose body has. A point is at the site, body or geom of its name,
    or at the only site on the body of its link's name.

    Args:
        crank, points: what is given already; None or empty where it is to be found.

    Raises:
        InvalidInput: the file cannot be loaded, or one of both cannot be told; names those that it may be.
    """
    model, _ = load_with_notes(path)
    driver = next(joint for joint in mechanism.joints if joint.name == mechanism.driver.joint)
    known = [driver.name, *(link for link in (driver.a, driver.b) if link != GROUND), "crank"]
    found = crank or _guess_crank(model, known)
    if not points:
        placed = {point.name: _guess_place(model, point.name, point.body) for point in mechanism.observed}
        points = {name: place for name, place in placed.items() if place}
    if not points:
        first, sites = mechanism.observed[0].name, [name for name in names_of(model, "site") if name]
        places = sites or [name for name in names_of(model, "body")[1:] if name]
        kind = "site" if sites else "body"
        raise InvalidInput(
            f"say where an observed point of the scene is: --point {first}={kind}:NAME, for one of {list_names(places)}"
        )
    return found, dict(points)


def _guess_crank(model: mujoco.MjModel, known: Sequence[str]) -> str:
    """Guess which hinge is the crank, and return its name; raises InvalidInput if several fit."""
    hinges = list(_ground_hinges(model))
    names = [name_or_number(model, "joint", joint) for joint in hinges]
    bodies = [name_or_number(model, "body", int(model.jnt_bodyid[joint])) for joint in hinges]
    for name in known:
        called = [k for k in range(len(hinges)) if name.lower() in (names[k].lower(), bodies[k].lower())]
        if len(called) == 1:
            return names[called[0]]
    on_joints = model.actuator_trnid[model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT), 0]
    for several in (hinges, [joint for joint in hinges if joint in on_joints]):
        if len(several) == 1:
            return names[hinges.index(several[0])]
    choices = f", one of {list_names(names)}" if names else "; it has no hinge on the ground"
    raise InvalidInput(f"say which joint of the model is driven: --crank JOINT{choices}")


def _ground_hinges(model: mujoco.MjModel) -> Iterator[int]:
    """Hinges that alone hold a body on the ground."""
    for joint in range(model.njnt):
        body = int(model.jnt_bodyid[joint])
        on_ground = int(model.body_weldid[model.body_parentid[body]]) == 0
        if on_ground and int(model.body_jntnum[body]) == 1 and joint_kind(model, joint) == "hinge":
            yield joint


def _guess_place(model: mujoco.MjModel, point: str, link: str) -> str:
    """Guess the place of an observed point, as `site:NAME`; empty if none fits, or several do."""
    for kind in ("site", "body", "geom"):
        names = names_of(model, kind)
        called = [name for name in names if name == point] or [n for n in names if n.lower() == point.lower()]
        if len(called) == 1:
            return f"{kind}:{called[0]}"
    bodies = names_of(model, "body")
    if link not in bodies:
        return ""
    on_link = np.flatnonzero(model.body_weldid[model.site_bodyid] == model.body_weldid[bodies.index(link)])
    sites = [name for name in (names_of(model, "site")[k] for k in on_link.tolist()) if name]
    return f"site:{sites[0]}" if len(sites) == 1 else ""
