"""Threads of linear algebra that an exact motion and the limits of an input take."""

from __future__ import annotations

import pytest
from free_machines import chain
from linkages import example_5_6
from threadpoolctl import threadpool_info, threadpool_limits

from conrod.exact.dynamics import configurations
from conrod.exact.dynamics.configurations import Configurations
from conrod.exact.dynamics.pieces import Samples
from conrod.exact.joint_curve import JointCurve
from conrod.exact.kinematics import Kinematics
from conrod.exact.linkage.course import course_of
from conrod.exact.motion import Array


def blas_threads() -> set[int]:
    return {library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"}


def test_the_curve_of_a_motion_is_worked_out_by_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    """With two, a chain of twenty four-bars took 46 s of CPU time in place of 3 s."""
    seen, sampled = [], configurations.sampled

    def watched(*arguments: object) -> Samples | None:
        seen.append(blas_threads())
        return sampled(*arguments)  # type: ignore[arg-type]  # as they are

    monkeypatch.setattr(configurations, "sampled", watched)
    with threadpool_limits(2, user_api="blas"):
        Configurations(chain(1)).reach(0.1)
        assert blas_threads() == {2}
    assert seen
    assert all(threads == {1} for threads in seen)


@pytest.mark.slow
def test_the_limits_of_an_input_are_found_by_one_thread(monkeypatch: pytest.MonkeyPatch) -> None:
    seen, corrected = [], JointCurve.corrected

    def watched(curve: JointCurve, *arguments: Array) -> Array | None:
        seen.append(blas_threads())
        return corrected(curve, *arguments)  # type: ignore[arg-type]  # as they are

    monkeypatch.setattr(JointCurve, "corrected", watched)
    with threadpool_limits(2, user_api="blas"):
        course = course_of(Kinematics(example_5_6()))
        course.poses(course.parameter[:1])
        assert blas_threads() == {2}
    assert len(seen) > 10
    assert all(threads == {1} for threads in seen)
