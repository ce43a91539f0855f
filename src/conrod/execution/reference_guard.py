"""Guard of a study's figures: says which scenes' exact motion cannot be trusted, and why.

Every study that compares runs with the exact motion has its runs checked here. `validate` and `forces` judge the same
differences, by the same bound, in their results (`JudgedResult.distrust`).
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from conrod.engines import engine_style
from conrod.execution.case import Case, Results, Study, contradictions
from conrod.execution.prediction import Misfit, merged_misfit, reference_misfit
from conrod.execution.result import misfit_words
from conrod.execution.run import RunCase

Found = TypeVar("Found")


class ReferenceGuard:
    """Collector of scenes and engines whose measured errors contradict the joints' equations.

    A run is checked while it is made: its result holds a misfit where predicted and measured errors differ by more
    than second order and rounding explain. Points without a prediction are not judged. The exact motion of each scene
    is also compared with its own joint equations, whether its runs are new or from a ledger.
    """

    def __init__(self) -> None:
        self._references: dict[str, dict[str, Misfit]] = {}  # of exact motions, by scene name
        self._misfit: dict[str, dict[str, Misfit]] = {}  # of exact motions and runs, by scene name
        self._engines: dict[str, dict[str, None]] = {}  # titles and versions by scene name, in order of occurrence

    def check(self, cases: Iterable[Case], results: Results) -> None:
        """Check the results of completed runs; other cases have no errors."""
        for case in cases:
            result = results[case.key]
            if not isinstance(case, RunCase) or result.errors is None:
                continue
            found = merged_misfit(self._reference_contradictions(case), result.misfit or {})
            if found:
                self._misfit[case.name] = merged_misfit(self._misfit.get(case.name, {}), found)
                engine = f"{engine_style(case.settings.engine).title} {case.engine_version}"
                self._engines.setdefault(case.name, {})[engine] = None

    def watch(self, study: Study[Found]) -> Study[Found]:
        """Run a study, and check the results of all cases that it asks for."""
        results: Results | None = None
        while True:
            try:
                cases = next(study) if results is None else study.send(results)
            except StopIteration as end:
                found: Found = end.value
                return found
            results = yield cases
            self.check(cases, results)

    @property
    def distrust(self) -> str:
        """Scenes and engines whose figures cannot be trusted, and why, in words; empty if all can."""
        return "; ".join(
            f"{name} in {' and '.join(self._engines[name])}: {misfit_words(found)}"
            for name, found in self._misfit.items()
        )

    def _reference_contradictions(self, case: RunCase) -> dict[str, Misfit]:
        """Contradictions of a scene's exact motion with its joint equations, by quantity.

        Computed once for each scene name, from the first variant: solving hundreds takes minutes, and each new run is
        checked by itself.
        """
        if case.name not in self._references:
            self._references[case.name] = contradictions(reference_misfit(case.scene))
        return self._references[case.name]
