"""The jobs of a validation handed to an executor: what one does to its process costs that job alone."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from concurrent.futures import Executor, Future, as_completed
from typing import Any, Protocol, TypeVar

from conrod.runs.trajectory import Outcome
from conrod.studies.execution.worker_process import WorkerDied

Found = TypeVar("Found")
Told_co = TypeVar("Told_co", covariant=True)


class Job(Protocol[Told_co]):
    """What can be done in any process, and has a result also where that process dies of it."""

    @property
    def label(self) -> str:
        """What is under way, for people."""
        ...

    @property
    def steps(self) -> int:
        """Steps per revolution, which say about how long it takes."""
        ...

    def run(self) -> Told_co:
        """The result."""
        ...

    def ended(self, outcome: Outcome, reason: str) -> Told_co:
        """The result where the process that ran it did not live to give one."""
        ...


def run_jobs(jobs: Sequence[Job[Found]], executor: Executor, finished: Callable[[Job[Any]], None]) -> list[Found]:
    """Results of all jobs, in their order; nothing in them depends on how many run at a time.

    A job that kills its process, or takes all memory, has that as its outcome. An error or Ctrl-C goes on to the
    caller; what waits then is for the executor to cancel, as conrod's own do where they are left.

    Args:
        finished: told of each as it is done, in the thread that called.

    Raises:
        InvalidInput: as the studies, and where a process cannot be started.
    """
    # The longest first: what is left for the end is then short, and no core waits long for another.
    order = sorted(range(len(jobs)), key=lambda place: -jobs[place].steps)
    running = {executor.submit(run, jobs[place]): place for place in order}
    results = {}
    for future in as_completed(running):
        place = running[future]
        results[place] = _result(future, jobs[place])
        finished(jobs[place])
    return [results[place] for place in range(len(jobs))]


def run(job: Job[Found]) -> Found:
    """The result of a job, for a worker process to be called with."""
    return job.run()


def _result(future: Future[Found], job: Job[Found]) -> Found:
    try:
        return future.result()
    except WorkerDied as error:
        return job.ended(Outcome.CRASHED, str(error))
    except MemoryError as error:
        return job.ended(Outcome.OUT_OF_MEMORY, str(error) or "there was no more")
