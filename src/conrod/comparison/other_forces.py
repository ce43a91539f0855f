"""Forces that act in a run besides weight, inertia and the loops, as plain values and in sentences."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

from conrod.errors import list_names

# Kinds of forces, and of other deviations from the exact motion; see `OtherForce`.
LIMIT, CONTACT, FRICTION, SPRING, DAMPER = "limit", "contact", "dry friction", "spring", "damper"
ACTUATOR, FLUID, COMPENSATION, ADHESION, HANDLE = "actuator", "fluid", "gravity compensation", "adhesion", "handle"
ACROSS, LACKING = "gravity across the plane", "lacking acceleration"
LENGTH_POWERS = {"N": 1, "N m": 2, "m/s²": 1}  # powers of length in units of sizes; others have none
MAX_NAMED_FORCES = 3  # forces of one kind named in a sentence
FULL_GRAVITY = 0.9999  # share of gravity above which it counts as all of it


@dataclass(frozen=True)
class OtherForce:
    """A force, or another deviation from the exact motion, that acted in a run.

    Attributes:
        kind: a constant of this module.
        name: type and name of the joint, tendon, pair of geoms, actuator or closure: "joint slide".
        largest: largest size; of gravity its share.
        unit: unit of the size; empty if the size is not given.
        exact: whether the exact forces of a machine include it, so that forces can be compared all the same.
    """

    kind: str
    name: str
    largest: float
    unit: str
    exact: bool = False

    @property
    def title(self) -> str:
        """Phrase without the size: 'the limit of tendon t'."""
        return f"{KIND_WORDS.get(self.kind, self.kind)}{' of ' if self.name else ''}{self.name}"

    def in_metres(self, unit: float) -> OtherForce:
        """Return the same of a model whose unit of length is not the metre, in SI.

        Args:
            unit: the model's unit of length [m]; kilograms and seconds are its others.
        """
        return replace(self, largest=self.largest * unit ** LENGTH_POWERS.get(self.unit, 0))

    @property
    def words(self) -> str:
        """Phrase with the size: 'the limit of tendon t (up to 1.6e+03 N)'."""
        size = f" (up to {self.largest:.2g} {self.unit})" if self.unit else ""
        return f"{self.title}{size}"


KIND_WORDS = {
    LIMIT: "the limit", SPRING: "the spring", DAMPER: "the damper", ACTUATOR: "the force", FLUID: "a fluid",
    HANDLE: "the pull",
}  # fmt: skip


def merge_forces(found: Iterable[OtherForce]) -> tuple[OtherForce, ...]:
    """Merge the forces of several runs, each with its largest size."""
    seen = dict[tuple[str, str, str], OtherForce]()
    for one in found:
        key = one.kind, one.name, one.unit
        seen[key] = replace(one, largest=max(one.largest, seen.get(key, one).largest))
    return tuple(seen.values())


def add_obstacles(reason: str, found: Iterable[OtherForce]) -> str:
    """Append to the reason of a run's end the limits and contacts that obstructed it; empty reasons stay empty."""
    obstacles = [one for one in found if one.kind in (LIMIT, CONTACT)]
    return f"{reason}; in its way: {_enumerate_forces(obstacles)}" if reason and obstacles else reason


def acting_sentences(
    found: Iterable[OtherForce], engine: str = "MuJoCo", run: str = "", *, judged: bool = True
) -> tuple[str, ...]:
    """Sentences for a verdict on all forces that acted in a run.

    Args:
        engine: with its release, which lacks a part of an acceleration.
        run: name of the run, if a reader cannot know it: "run as the file has it".
        judged: whether the run is compared with an exact motion.
    """
    every = tuple(found)
    acting = [one for one in every if one.kind not in (ACROSS, LACKING)]
    said = list[str]()
    if acting:
        begin = f"{run[0].upper()}{run[1:]}, what acts besides its loops" if run else "What acts besides its loops"
        obstructed = judged and any(one.kind in (LIMIT, CONTACT) for one in acting)
        end = "; the exact motion has no limits or contacts, so errors are not the engine's alone" if obstructed else ""
        said.append(f"{begin}: {_enumerate_forces(acting)}{end}.")
    said += [
        f"{engine} lacks the part of the velocity in the acceleration of {one.name}: up to "
        f"{one.largest:.2g} {one.unit}, which no setting mends."
        for one in every
        if one.kind == LACKING
    ]
    for one in every:
        if one.kind == ACROSS:
            share = "Gravity" if one.largest > FULL_GRAVITY else f"A share of {one.largest:.2g} of gravity"
            said.append(f"{share} acts across the plane of motion.")
    return tuple(said)


def _enumerate_forces(found: list[OtherForce]) -> str:
    """Enumerate forces, of each kind the largest ones and the number of others."""
    parts = list[str]()
    for kind in dict.fromkeys(one.kind for one in found):
        same = sorted((one for one in found if one.kind == kind), key=lambda one: -one.largest)
        parts.append(list_names((one.words for one in same), MAX_NAMED_FORCES))
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])}, and {parts[-1]}"
