"""Likeness of the errors of reported forces to the effect of a wrong mass.

The errors e of all quantities and instants, over their peaks and minus the errors that the engine's law expects, are
projected on the effect s of a detectable change of a mass property, by the exact sensitivities:
likeness = e . s / s . s. That detects a smaller wrong mass than a tolerance can, which has to allow the engine's own
errors.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from conrod.exact.dynamics.inverse import MIN_RELATIVE_CHANGE, sensitivities
from conrod.exact.kinematics import ExactReference
from conrod.studies.forces.force_errors import ExpectedForceErrors, ForceComparison, Peaks, constant_speed_states
from conrod.studies.forces.results import MIN_LIKENESS

MAX_PROJECTED_SAMPLES = 131072  # many, because with contact single values scatter
SCATTER_PARTS = 64  # parts of a run, whose projections give the standard error of the whole
# A likeness counts if this many of its standard errors are less than the likeness, or than `MIN_LIKENESS`.
STANDARD_ERRORS = 3.0
# A wrong mass leaves at most this share of the errors that it is claimed for: planted ones leave 0.02; other masses,
# and all masses of healthy runs whose engine has no law of its errors, leave 0.64 and more.
MAX_UNEXPLAINED_SHARE = 0.2
# A claim is dropped if it leaves this many times what the best claim leaves, and more than this share.
FAR_BETTER_FACTOR, EXPLAINED_SHARE = 10.0, 0.02


def visible_properties(scene: ExactReference, names: Sequence[str], peaks: Peaks) -> set[tuple[str, str]]:
    """Return (body, property) pairs that some quantities depend on at constant speed.

    Args:
        names: quantities that count.
    """
    found = sensitivities(scene.kinematics, constant_speed_states(scene))
    effects = {
        (one.body, one.quality): max(float(np.abs(one.derivatives[n]).max()) * one.change / peaks[n][0] for n in names)
        for one in found
    }
    return {pair for pair, effect in effects.items() if effect >= MIN_RELATIVE_CHANGE}


def mass_likenesses(
    scene: ExactReference, measured: ForceComparison, names: Sequence[str], law: ExpectedForceErrors | None = None
) -> dict[str, float]:
    """Return by "body.property" how many detectable changes of it the errors look like.

    A detectable change is 1 % of a mass, 1 % of a length, 5 % of an inertia. Left out are properties that no quantity
    depends on, and those for which the errors scatter too much: with contact, in a run of few steps. A wrong mass is
    claimed only if it explains the errors, by the share of them that it leaves (`_drop_unexplained`): errors of an
    engine that has no law of them have a projection on every mass.

    Args:
        names: quantities that count; those that the engine does not report are left out.
        law: the engine's expected errors, which no wrong mass causes and which are subtracted first.
    """
    reported = [name for name in names if name in measured.reported]
    rows = measured.clear_rows()
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, MAX_PROJECTED_SAMPLES).astype(int))]
    at = measured.state
    peaks = {name: measured.peaks[name][0] for name in reported}
    expected = {name: 0.0 if law is None else law.errors_at(at, name) for name in reported}
    errors = np.concatenate([(measured.signed_errors(n) - expected[n])[rows] / peaks[n] for n in reported])
    # At constant speed, as the machine is meant to run: effects through ripple of the drive do not count.
    visible = visible_properties(scene, reported, measured.peaks)
    found, left = {}, {}
    for one in sensitivities(scene.kinematics, at[rows]):
        effect = np.concatenate([one.derivatives[n] * one.change / peaks[n] for n in reported])
        if (one.body, one.quality) in visible and effect.any():
            times = float(errors @ effect / (effect @ effect))
            remaining = errors - times * effect
            # Consecutive values scatter together, and so do the quantities: parts of the run are independent.
            along = (remaining * effect).reshape(len(reported), -1).sum(axis=0)
            parts = [part.sum() for part in np.array_split(along, SCATTER_PARTS)]
            standard_error = float(np.linalg.norm(parts) / (effect @ effect))
            if STANDARD_ERRORS * standard_error < max(MIN_LIKENESS, abs(times)):
                found[name := f"{one.body}.{one.quality}"] = times
                left[name] = float(np.linalg.norm(remaining) / np.linalg.norm(errors)) if errors.any() else 0.0
    # Single values of a contact scatter by more than any mass changes them: there the projection alone decides.
    return found if scene.kinematics.mechanism.cam_contacts else _drop_unexplained(found, left)


def _drop_unexplained(times: Mapping[str, float], left: Mapping[str, float]) -> dict[str, float]:
    """Drop wrong masses that do not explain the errors, or far worse than another one does.

    Args:
        times: likenesses; those of up to `MIN_LIKENESS` are no claim.
        left: norm of the errors without the effect of each, over the norm of the errors.
    """
    claims = [name for name, size in times.items() if not abs(size) <= MIN_LIKENESS]
    best = min((left[name] for name in claims), default=1.0)
    bound = min(MAX_UNEXPLAINED_SHARE, max(FAR_BETTER_FACTOR * best, EXPLAINED_SHARE))
    return {name: size for name, size in times.items() if name not in claims or left[name] <= bound}
