"""What acts in a run besides weight, inertia and the loops, as it was seen to act, as plain values and in words."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace

# Kinds of forces, and of what else makes a run another one than the exact motion; see `OtherForce`.
LIMIT, CONTACT, FRICTION, SPRING, DAMPER = "limit", "contact", "dry friction", "spring", "damper"
ACTUATOR, FLUID, COMPENSATION, ADHESION, HANDLE = "actuator", "fluid", "gravity compensation", "adhesion", "handle"
ACROSS, LACKING = "gravity across the plane", "lacking acceleration"
NAMED = 3  # of one kind, in a sentence
WHOLE = 0.9999  # share of gravity that is all of it


@dataclass(frozen=True)
class OtherForce:
    """One thing that acts in a run besides weight, inertia and the loops.

    Attributes:
        kind: of it, a constant of this module.
        name: of the joint, tendon, pair of geoms, actuator or closure, with what it is: "joint slide".
        largest: size that was seen; of gravity its share.
        unit: of the size; empty where there is none to give.
        exact: whether the exact forces of a machine have it too, so that forces can be compared all the same.
    """

    kind: str
    name: str
    largest: float
    unit: str
    exact: bool = False

    @property
    def title(self) -> str:
        """'the limit of tendon t'."""
        return f"{WORDS.get(self.kind, self.kind)}{' of ' if self.name else ''}{self.name}"

    @property
    def words(self) -> str:
        """'the limit of tendon t (up to 1.6e+03 N)'."""
        size = f" (up to {self.largest:.2g} {self.unit})" if self.unit else ""
        return f"{self.title}{size}"


WORDS = {
    LIMIT: "the limit", SPRING: "the spring", DAMPER: "the damper", ACTUATOR: "the force", FLUID: "a fluid",
    HANDLE: "the pull",
}  # fmt: skip


def merged(found: Iterable[OtherForce]) -> tuple[OtherForce, ...]:
    """Things of several runs, each once with its largest size."""
    seen = dict[tuple[str, str, str], OtherForce]()
    for one in found:
        key = one.kind, one.name, one.unit
        seen[key] = replace(one, largest=max(one.largest, seen.get(key, one).largest))
    return tuple(seen.values())


def with_obstacles(reason: str, found: Iterable[OtherForce]) -> str:
    """The reason of a run's end, with limits and contacts that stood in its way; empty where there is none."""
    obstacles = [one for one in found if one.kind in (LIMIT, CONTACT)]
    return f"{reason}; in its way: {_listed(obstacles)}" if reason and obstacles else reason


def acting_sentences(
    found: Iterable[OtherForce], engine: str = "MuJoCo", run: str = "", *, judged: bool = True
) -> tuple[str, ...]:
    """All that acts in a run, in sentences, to stand in its verdict.

    Args:
        engine: with its release, which lacks a part of an acceleration.
        run: in which it acts, where a reader cannot know: "run as the file has it".
        judged: whether the run is compared with an exact motion.
    """
    every = tuple(found)
    acting = [one for one in every if one.kind not in (ACROSS, LACKING)]
    said = list[str]()
    if acting:
        begin = f"{run[0].upper()}{run[1:]}, what acts besides its loops" if run else "What acts besides its loops"
        obstructed = judged and any(one.kind in (LIMIT, CONTACT) for one in acting)
        end = "; the exact motion has no limits or contacts, so errors are not the engine's alone" if obstructed else ""
        said.append(f"{begin}: {_listed(acting)}{end}.")
    said += [
        f"{engine} lacks the part of the velocity in the acceleration of {one.name}: up to "
        f"{one.largest:.2g} {one.unit}, which no setting mends."
        for one in every
        if one.kind == LACKING
    ]
    for one in every:
        if one.kind == ACROSS:
            share = "Gravity" if one.largest > WHOLE else f"A share of {one.largest:.2g} of gravity"
            said.append(f"{share} acts across the plane of motion.")
    return tuple(said)


def _listed(found: list[OtherForce]) -> str:
    """All in a list, of each kind the largest and how many more."""
    parts = list[str]()
    for kind in dict.fromkeys(one.kind for one in found):
        same = sorted((one for one in found if one.kind == kind), key=lambda one: -one.largest)
        more = f" and {len(same) - NAMED} more" if len(same) > NAMED else ""
        parts.append(", ".join(one.words for one in same[:NAMED]) + more)
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])}, and {parts[-1]}"
