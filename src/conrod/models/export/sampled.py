"""What an engine did, at the instants of its own samples, beside the exact motion at the same instants."""

from __future__ import annotations

import io
import json
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np

from conrod.comparison.trajectory import BodyStates, Outcome, Trajectory
from conrod.engines import engine_named
from conrod.engines.engine import default_steps, run_extent
from conrod.engines.run import run_in_one_piece
from conrod.errors import InvalidInput, unknown_choice
from conrod.exact.link_rotations import ROTATION_COLUMNS, ROTATION_UNITS, link_rotations, rotating_links
from conrod.exact.motion import Array, Instants, Motion
from conrod.execution.resolve_arguments import check_sample_count
from conrod.models.export.pack import TABLE_QUANTITIES, exact_columns
from conrod.scenes import Scene

Columns = dict[str, tuple[str, Array]]  # name -> (unit, values (T,))
CRANK_COLUMNS = (("crank_angle", "angle", "rad"), ("crank_speed", "rate", "rad/s"))


@dataclass(frozen=True)
class SampledTrajectory:
    """Columns of a sampled run, and what made it.

    Attributes:
        columns: name -> (unit, values), of up to T samples; those with fewer lack the first ones.
        about: scene, engine, preset, step and versions, as text by name.
        outcome: how the run ended, and why.
    """

    columns: Columns
    about: Mapping[str, str]
    outcome: str = ""


def sampled_trajectory(
    name: str, scene: Scene, engine: str, preset: str | None, steps: int | None, revolutions: int | None
) -> SampledTrajectory:
    """Run a scene in an engine at constant crank speed; sample the run and the exact motion.

    Args:
        preset: None for the preset that is judged.
        steps: steps in a revolution, each of which is a sample; None for the default.

    Raises:
        InvalidInput: there is no such engine or preset, or the engine refuses the machine.
    """
    loaded = engine_named(engine)
    judged = next((one for one, rule in loaded.presets.items() if rule.judged), next(iter(loaded.presets)))
    chosen = judged if preset is None else preset
    if chosen not in loaded.presets:
        raise unknown_choice(f"preset of {loaded.name}", chosen, loaded.presets)
    per_revolution, turns = default_steps(scene) if steps is None else steps, 1 if revolutions is None else revolutions
    check_sample_count(name, per_revolution, turns)
    settings = loaded.presets[chosen](scene, per_revolution)
    if refusal := loaded.refusal(scene, settings):
        raise InvalidInput(f"{name} in {loaded.name}: {refusal}")
    start, length = run_extent(scene, per_revolution, float(turns))
    run = run_in_one_piece(loaded, scene, settings, length, start)
    about = {
        "conrod": version("conrod"),
        "scene": name,
        "parameters (SI)": ", ".join(f"{key} = {value!r}" for key, value in scene.parameters.items()),
        "engine": f"{run.engine} {run.engine_version}",
        "preset": chosen,
        "settings": json.dumps(run.settings.as_dict(), ensure_ascii=False),
        "step [s]": repr(run.settings.timestep),
        "revolutions": repr(length),
        "outcome": run.outcome.slug + (f": {run.reason}" if run.reason else ""),
    }
    return SampledTrajectory(
        _columns_of(scene, run), about, "" if run.outcome is Outcome.COMPLETED else about["outcome"]
    )


def exact_trajectory(name: str, scene: Scene, samples: int, revolutions: int) -> SampledTrajectory:
    """The exact motion alone, as `conrod export --format csv` has it."""
    return SampledTrajectory(exact_columns(scene, samples, revolutions), {"conrod": version("conrod"), "scene": name})


def _columns_of(scene: Scene, run: Trajectory) -> Columns:
    """Columns of a run: times, the crank, and each quantity of each point and link with the exact one.

    Quantities that belong to other instants than the positions have columns of time and crank of their own, and say
    so in their names: no reader takes them for values at the positions' times.
    """
    columns: Columns = {}
    for (prefix, quantity, unit), turning in zip(TABLE_QUANTITIES[:3], ROTATION_UNITS, strict=True):
        for name, tracks in run.points.items():
            track = getattr(tracks, quantity)
            stamp = _add_instants(columns, quantity, track.instants)
            exact = getattr(_exact_motion(scene, track.instants).point(name), quantity)
            for k, axis in enumerate("xy"):
                columns[f"{name}.{prefix}{axis}{stamp}"] = (unit, track.values[:, k])
                columns[f"exact.{name}.{prefix}{axis}{stamp}"] = (unit, exact[:, k])
        if run.bodies is not None:
            _add_links(columns, scene, getattr(run.bodies, quantity), quantity, turning)
    return columns


def _add_links(columns: Columns, scene: Scene, states: BodyStates, quantity: str, turning: str) -> None:
    """Add a quantity of the links that rotate, at the instants that it belongs to."""
    kinematics, letter, unit = scene.kinematics, ROTATION_COLUMNS[turning], ROTATION_UNITS[turning]
    stamp, order = _add_instants(columns, quantity, states.instants), list(ROTATION_UNITS).index(turning)
    values = (states.poses, states.rates, states.accelerations)[order]
    exact = link_rotations(kinematics, _exact_angle(scene, states.instants), scene.speed, order=order)[order]
    for name in rotating_links(kinematics):
        k = kinematics.mechanism.body_index[name]
        columns[f"{letter}_{name}{stamp}"] = (unit, values[:, 3 * k + 2])
        columns[f"exact.{letter}_{name}{stamp}"] = (unit, exact[:, k])


def _add_instants(columns: Columns, quantity: str, instants: Instants) -> str:
    """Add the columns of some instants where they are new; return how names say that they belong to them."""
    stamp = _known_stamp(columns, instants)
    if stamp is None:
        stamp = "time" if not columns else f"{quantity}_time"
        columns |= _instant_columns(stamp, instants)
    return "" if stamp == "time" else f" at {stamp}"


def _known_stamp(columns: Columns, instants: Instants) -> str | None:
    """Name of an existing time column with equal instants; None if no column matches."""
    for name, (_, values) in columns.items():
        if name.endswith("time") and np.array_equal(values, instants.times):
            return name
    return None


def _instant_columns(stamp: str, instants: Instants) -> Columns:
    """Columns of the time, and of the crank as the engine has it then."""
    suffix = "" if stamp == "time" else f" at {stamp}"
    crank = {f"{name}{suffix}": (unit, getattr(instants, field)) for name, field, unit in CRANK_COLUMNS}
    return {stamp: ("s", instants.times), **crank}


def _exact_angle(scene: Scene, instants: Instants) -> Array:
    """Nominal crank angle (T,) [rad] at some instants."""
    span, angle = scene.kinematics.mechanism.driver.span, scene.speed * instants.times
    return angle if span is None else np.clip(angle, *span)


def _exact_motion(scene: Scene, instants: Instants) -> Motion:
    """Exact motion at the nominal crank angle of some instants."""
    return scene.motion(_exact_angle(scene, instants), scene.speed)


# -- files -------------------------------------------------------------------------------------------------------------


def sampled_csv(sampled: SampledTrajectory) -> str:
    """Return a run as CSV: origin in comments, units in headings, empty cells for missing samples."""
    rows = max(len(values) for _, values in sampled.columns.values())
    cells = [
        [""] * (rows - len(values)) + [repr(value) for value in values.tolist()]
        for _, values in sampled.columns.values()
    ]
    lines = [f"# {name}: {' '.join(text.split())}" for name, text in sampled.about.items()]
    lines.append(",".join(f"{name} [{unit}]" for name, (unit, _) in sampled.columns.items()))
    lines += [",".join(row) for row in zip(*cells, strict=True)]
    return "\n".join(lines) + "\n"


def sampled_npz(sampled: SampledTrajectory) -> bytes:
    """Return a run as a numpy archive: an array by the name of each column; `units` and `about` are JSON."""
    stream = io.BytesIO()
    texts = {
        "units": json.dumps({name: unit for name, (unit, _) in sampled.columns.items()}, ensure_ascii=False),
        "about": json.dumps(dict(sampled.about), ensure_ascii=False),
    }
    arrays = {name: values for name, (_, values) in sampled.columns.items()}
    np.savez(stream, allow_pickle=False, **arrays, **{name: np.array(text) for name, text in texts.items()})
    return stream.getvalue()
