"""`python -m docs.studies.batch_gpu [--counts N ...] [--engines NAME ...] [--out FILE]`: fleets on a GPU and on cores.

Saws and grippers whose lengths are drawn within a drawing's tolerances are stepped all in one call of MuJoCo (on
threads), of MJX and of MuJoCo Warp (on the GPU, or on the CPU where there is none), at the same settings. Of each call:
wall time after compiling, and each member's error against its own exact motion. FILE is what
`python -m docs.studies.batch_gpu_page` makes the page of.
"""

from __future__ import annotations

import argparse
import json
import os
import platform
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from copy import copy
from dataclasses import fields
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import mujoco
import numpy as np

from conrod.crash import run_guarded
from conrod.exact.motion import Array
from docs.studies.fleets import LAYOUTS, STEPS, Fleet, fleet

COUNTS = (1, 10, 100, 1_000, 10_000, 100_000)
REPEATS, ENOUGH = 3, 1.0  # further runs, until so many seconds
REFERENCE_COUNT = 1_000  # members whose motion in single precision is compared with that in double
CONTROL_COUNT = 100  # members of the fleets that defects are planted in
PLANTED, OTHER = 5, 17  # a member whose model is made another's
MOST_WORK, FEW_STEPS = 2e6, 25  # steps of one thread above which cores are timed over few steps, and how many
SEEN = 1.05  # a member is seen to be wrong where its error is above this share of the largest of right ones


class Variant(NamedTuple):
    """What steps a fleet: engine, integrator, precision, and threads of a CPU."""

    engine: str
    integrator: str = "Euler"
    precision: str = "double"
    threads: int = 0


def variants(engine: str, threads: Sequence[int]) -> list[Variant]:
    """What is measured of an engine."""
    if engine == "mujoco":
        return [*(Variant("mujoco", threads=count) for count in threads), Variant("mujoco", "RK4", threads=threads[-1])]
    if engine == "mjx":
        return [Variant("mjx", precision="single"), Variant("mjx")]
    return [Variant("warp", precision="single"), Variant("warp", "RK4", "single")]


class Runner(ABC):
    """An engine that steps a fleet of one size, compiled for it."""

    where: str

    @abstractmethod
    def load(self, members: Fleet) -> None:
        """Take models and states at the start of a fleet of the runner's size."""

    @abstractmethod
    def run(self, steps: int) -> None:
        """Step all members from the start, each step's coordinates recorded, until it is done."""

    @abstractmethod
    def recorded(self) -> Array:
        """Coordinates after each step (n, T, nq), on this side."""


# -- MuJoCo ------------------------------------------------------------------------------------------------------------


class MuJoCoRunner(Runner):
    """MuJoCo's own batch of worlds on a pool of threads."""

    def __init__(self, members: Fleet, threads: int) -> None:
        from mujoco import batch as mujoco_batch  # since 4.0

        self.where = f"{threads} core{'s' if threads > 1 else ''}"
        self._batch = mujoco_batch.Batch(members.model, nsim=len(members), nthread=threads)
        self._out: dict[str, Array] = {}

    def load(self, members: Fleet) -> None:
        for name, values in members.fields.items():
            self._batch.expand(name)[:] = values
        self._start = members.coordinates, members.rates

    def run(self, steps: int) -> None:
        self._batch.reset()
        self._batch.bind("qpos")[:], self._batch.bind("qvel")[:] = self._start
        kept = self._out.get("qpos")
        out = {"qpos": kept} if kept is not None and kept.shape[1] == steps else None
        self._out = self._batch.rollout(steps, record=("qpos",), out=out)

    def recorded(self) -> Array:
        return self._out["qpos"]


# -- MJX ---------------------------------------------------------------------------------------------------------------


class MJXRunner(Runner):
    """MJX, a step mapped over the members."""

    def __init__(self, members: Fleet, precision: str) -> None:
        import jax

        self._jax, self._double = jax, precision == "double"
        self._type = np.float64 if self._double else np.float32
        self.where = jax.devices()[0].device_kind
        with jax.enable_x64(self._double):
            self._compiled = jax.jit(jax.vmap(self._record(members))).lower(*self._host(members)).compile()

    def _record(self, members: Fleet) -> Callable[..., Any]:
        """Return the function of a member's fields and state that steps it and returns its coordinates (T, nq)."""
        import jax
        from mujoco import mjx

        from conrod.engines.mjx.engine import take_step

        model = mjx.put_model(members.model, impl="jax")
        data = mjx.put_data(members.model, mujoco.MjData(members.model), impl="jax")

        def record(fields: Any, coordinates: Any, rates: Any) -> Any:
            of_member = model.tree_replace(fields)

            def step(now: Any, _: Any) -> tuple[Any, Any]:
                after = take_step(of_member, now)
                return after, after.qpos

            return jax.lax.scan(step, data.replace(qpos=coordinates, qvel=rates), None, length=STEPS)[1]

        return record

    def _host(self, members: Fleet) -> tuple[dict[str, Any], Any, Any]:
        fields = {name: values.astype(self._type) for name, values in members.fields.items()}
        return fields, members.coordinates.astype(self._type), members.rates.astype(self._type)

    def load(self, members: Fleet) -> None:
        with self._jax.enable_x64(self._double):
            self._given = self._jax.block_until_ready(self._jax.device_put(self._host(members)))

    def run(self, steps: int) -> None:
        with self._jax.enable_x64(self._double):
            self._out = self._jax.block_until_ready(self._compiled(*self._given))

    def recorded(self) -> Array:
        return np.asarray(self._out)


# -- MuJoCo Warp -------------------------------------------------------------------------------------------------------


class WarpRunner(Runner):
    """MuJoCo Warp; on a GPU a step is a captured graph."""

    def __init__(self, members: Fleet) -> None:
        import mujoco_warp
        import warp

        self._wp, self._mjw, count = warp, mujoco_warp, len(members)
        warp.config.log_level = warp.LOG_WARNING
        self.where = warp.get_device().name
        sizes = dict.fromkeys(self._fields(members), count)
        model = copy(members.model)
        model.opt.disableflags &= ~int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)  # which it refuses
        self._model = mujoco_warp.put_model(model, batch_sizes=sizes)
        self._data = mujoco_warp.make_data(model, nworld=count, nconmax=1, njmax=8)
        self._records = warp.zeros((STEPS, count, members.model.nq), dtype=float)
        self.load(members)
        self._restart()
        self._step()  # compiles what is not in the cache
        self._graph = None
        if warp.get_device().is_cuda:
            with warp.ScopedCapture() as capture:
                self._step()
            self._graph = capture.graph
        warp.synchronize()

    def _fields(self, members: Fleet) -> dict[str, Array]:
        known = {field.name for field in fields(self._mjw.Model)}
        return {name: values for name, values in members.fields.items() if name in known}

    def _step(self) -> None:
        self._mjw.step(self._model, self._data)

    def load(self, members: Fleet) -> None:
        for name, values in self._fields(members).items():
            getattr(self._model, name).assign(values.astype(np.float32))
        self._start = [
            self._wp.array(values.astype(np.float32), dtype=float) for values in (members.coordinates, members.rates)
        ]
        self._wp.synchronize()

    def _restart(self) -> None:
        """Put all members at the start, with what a step takes from the one before it."""
        self._wp.copy(self._data.qpos, self._start[0])
        self._wp.copy(self._data.qvel, self._start[1])
        self._data.qacc_warmstart.zero_()
        self._data.time.zero_()
        self._mjw.forward(self._model, self._data)

    def run(self, steps: int) -> None:
        self._restart()
        size = self._data.qpos.size
        for k in range(steps):
            if self._graph is None:
                self._step()
            else:
                self._wp.capture_launch(self._graph)
            self._wp.copy(self._records, self._data.qpos, dest_offset=k * size, count=size)
        self._wp.synchronize()

    def recorded(self) -> Array:
        return np.asarray(np.moveaxis(self._records.numpy(), 0, 1))


# -- measuring ---------------------------------------------------------------------------------------------------------


class Job(NamedTuple):
    """A fleet to step by a variant."""

    variant: Variant
    members: Fleet


def runner(job: Job) -> tuple[Runner, float]:
    """What steps a fleet, and the wall time [s] that it took to make, compiling included."""
    begun = time.perf_counter()
    made: Runner
    match job.variant.engine:
        case "mujoco":
            made = MuJoCoRunner(job.members, job.variant.threads)
        case "mjx":
            made = MJXRunner(job.members, job.variant.precision)
        case _:
            made = WarpRunner(job.members)
    return made, time.perf_counter() - begun


def runners(jobs: Sequence[Job]) -> Iterator[tuple[Runner, float]]:
    """Runners of jobs: JAX's compiled all at once, before any is timed; others one after the other."""
    if jobs and jobs[0].variant.engine == "mjx":
        with ThreadPoolExecutor(len(jobs)) as pool:
            yield from list(pool.map(runner, jobs))
    else:
        yield from map(runner, jobs)


def seconds(call: Callable[[], object]) -> float:
    """Wall time of a call [s]."""
    begun = time.perf_counter()
    call()
    return time.perf_counter() - begun


def measure(job: Job, made: Runner, compiling: float) -> tuple[dict[str, Any], Array]:
    """Costs of a fleet's run and errors of its members, with the recorded coordinates (n, T, nq)."""
    variant, members = job
    loading = seconds(lambda: made.load(members))
    work = len(members) * STEPS * (4 if variant.integrator == "RK4" else 1) / max(1, variant.threads)
    steps = FEW_STEPS if variant.engine == "mujoco" and work > MOST_WORK else STEPS
    walls = [seconds(lambda: made.run(steps))]
    while len(walls) <= REPEATS and sum(walls) < ENOUGH:
        walls.append(seconds(lambda: made.run(steps)))
    begun = time.perf_counter()
    recorded = made.recorded()
    reading = time.perf_counter() - begun
    errors = members.errors(recorded)
    row = {
        **variant._asdict(), "machine": members.layout.name, "count": len(members), "where": made.where, "steps": steps,
        "compiling": compiling, "loading": loading, "reading": reading, "walls": walls,
        "microseconds": 1e6 * min(walls) / steps / len(members),
        "error": {"median": float(np.median(errors)), "largest": float(errors.max())} if steps == STEPS else None,
        "finite": int(np.isfinite(errors).sum()),
    }  # fmt: skip
    return row, recorded


def control(job: Job, made: Runner) -> dict[str, Any]:
    """Whether a planted defect is seen: a member of another's lengths, and exact motions of other members.

    A member is seen whose error is above `SEEN` times the largest of right ones.
    """
    variant, members = job
    made.load(members)
    made.run(STEPS)
    recorded = np.array(made.recorded())
    right, others = members.errors(recorded), members.errors(recorded, np.roll(members.sizes, 1, axis=0))
    planted = PLANTED % len(members)
    made.load(members.with_planted(planted, OTHER % len(members)))
    made.run(STEPS)
    found = members.errors(made.recorded())
    return {
        **variant._asdict(), "machine": members.layout.name, "count": len(members), "right": float(right.max()),
        "planted": planted, "error": float(found[planted]), "seen": np.flatnonzero(found > SEEN * right.max()).tolist(),
        "others_seen": int((others > SEEN * right.max()).sum()),
    }  # fmt: skip


def precision_told(members: Fleet, single: Array, double: Array) -> dict[str, Any]:
    """How far single precision moves what is recorded: deviations over L, and the drive's angle [rad] at the end.

    `rounded` is the error of the exact motion itself, with its coordinates rounded to single precision.
    """
    exact = members.layout.exact(members.sizes)
    off = [members.layout.deviations(members.sizes, one.astype(float)) for one in (single, double)]
    drive = np.abs(exact[:, -1] - single[:, -1].astype(float))[:, members.layout.drives].max()
    return {
        "machine": members.layout.name, "count": len(members), "moved": float(np.abs(off[0] - off[1]).max()),
        "rounded": float(members.errors(exact.astype(np.float32)).max()), "angle": float(drive),
    }  # fmt: skip


def described(wheres: Iterable[str]) -> dict[str, Any]:
    """The machine and the versions that figures belong to."""
    names = ("mujoco", "mujoco-mjx", "jax", "mujoco-warp", "warp-lang", "numpy")
    return {
        "date": time.strftime("%Y-%m-%d"), "python": platform.python_version(), "cores": os.cpu_count(),
        "processor": _processor(), "devices": sorted(set(wheres)),
        "versions": {name: found for name in names if (found := _installed(name))},
    }  # fmt: skip


def _installed(name: str) -> str:
    try:
        return version(name)
    except ImportError:
        return ""


def _processor() -> str:
    facts = Path("/proc/cpuinfo").read_text(encoding="utf-8")
    return next((line.partition(":")[2].strip() for line in facts.splitlines() if line.startswith("model name")), "")


SHOWN = (
    "machine", "engine", "integrator", "precision", "where", "count", "compiling", "loading", "reading", "microseconds",
)  # fmt: skip


def study(engine: str, fleets: Sequence[Fleet], asked: argparse.Namespace, found: dict[str, Any]) -> None:
    """Measure an engine on all fleets; `found` is added to and written after each."""
    jobs = [
        Job(variant, members.with_integrator(variant.integrator).first(count))
        for variant in variants(engine, asked.threads)
        for members in fleets
        for count in asked.counts
        if variant != Variant("mjx") or count in (REFERENCE_COUNT, max(asked.counts))
    ]
    recorded: dict[tuple[str, str], tuple[Fleet, Array]] = {}
    reference = max([count for count in asked.counts if count <= REFERENCE_COUNT], default=0)
    made = runners(jobs)
    for job in jobs:
        if time.perf_counter() - asked.begun > asked.budget:
            print(f"budget spent before {job.variant} of {len(job.members)} {job.members.layout.name}s")
            return
        ready, compiling = next(made)
        row, states = measure(job, ready, compiling)
        found["rows"].append(row)
        print(*(f"{key}={row[key]:.4g}" if isinstance(row[key], float) else row[key] for key in SHOWN), row["error"])
        if len(job.members) == reference and job.variant.integrator == "Euler":
            recorded[job.members.layout.name, job.variant.precision] = job.members, np.array(states)
        if len(job.members) == min(CONTROL_COUNT, max(asked.counts)):
            found["controls"].append(control(job, ready))
            print("  control", found["controls"][-1])
        write(found, asked.out)
    for members in fleets:
        if (one := recorded.get((members.layout.name, "single"))) is None:
            continue
        against = recorded.get((members.layout.name, "double"))
        if against is None:
            double = MuJoCoRunner(one[0], max(asked.threads))
            double.load(one[0])
            double.run(STEPS)
            against = one[0], double.recorded()
        found["precision"].append({"engine": engine, **precision_told(*one, against[1])})
        print("  precision", found["precision"][-1])
    write(found, asked.out)


def write(found: dict[str, Any], file: Path | None) -> None:
    """Write what is found so far."""
    found["machine"] = described(row["where"] for row in found["rows"])
    if file:
        file.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")


def main() -> None:
    """Run the fleets, print what comes out, and write it to a file."""
    parser = argparse.ArgumentParser(prog="python -m docs.studies.batch_gpu", description=main.__doc__)
    parser.add_argument("--counts", type=int, nargs="+", default=COUNTS, metavar="N", help="members of the fleets")
    parser.add_argument("--machines", nargs="+", default=list(LAYOUTS), choices=list(LAYOUTS))
    parser.add_argument("--engines", nargs="+", default=["mujoco", "mjx", "warp"], choices=["mujoco", "mjx", "warp"])
    parser.add_argument("--threads", type=int, nargs="+", default=[2, 16], metavar="N", help="of MuJoCo [2 16]")
    parser.add_argument("--budget", type=float, default=1e9, metavar="S", help="begin nothing after so many seconds")
    parser.add_argument("--out", type=Path, metavar="FILE", help="write what is found as JSON")
    asked = parser.parse_args()
    asked.begun = time.perf_counter()
    found: dict[str, Any] = {"rows": [], "controls": [], "precision": []}
    fleets = [fleet(LAYOUTS[name], max(asked.counts)) for name in asked.machines]
    found["making"] = time.perf_counter() - asked.begun
    print(f"fleets made in {found['making']:.1f} s")
    for engine in asked.engines:
        study(engine, fleets, asked, found)


if __name__ == "__main__":
    run_guarded(main)
