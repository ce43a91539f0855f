"""Findings on a follower that flies off its cam: the onset, and flights beside the exact ones; plain values."""

from __future__ import annotations

from dataclasses import dataclass

from conrod.studies.limits.exact_flight import ExactFlight
from conrod.studies.limits.records import Flight, Gaps

# A flight whose length falls with the step by this order or more shrinks with it. The order is 1 or more of a held
# follower's rebounds, 0 of a flight which the speed makes, and one half just at the onset, with rebounds that shrink as
# h does; see `conrod.studies.limits.exact_flight`.
SHRINKING_ORDER = 0.5
WITHIN = 0.02  # how near to the theory's an onset is to be


@dataclass(frozen=True)
class OnsetProbe:
    """Two runs at a speed, with steps h and h/2.

    Attributes:
        speed: over the float speed.
        lengths: of the longest flights, the coarser step's first [rad]; 0 where there is none. Without one with the
            coarser step there is none to shrink: nothing was run with the finer one, which is None.
        exact: length of the exact flight [rad]; 0 where the exact follower is held.
    """

    speed: float
    lengths: tuple[float, float | None]
    exact: float

    @property
    def flies(self) -> bool:
        """True where there is a flight that does not shrink with h."""
        coarse, fine = self.lengths
        return fine is not None and fine > coarse * 0.5**SHRINKING_ORDER


@dataclass(frozen=True)
class ComparedFlight:
    """The longest flight of a run at a speed over the float speed, beside the exact one.

    Attributes:
        exact: from the separation on; None where the exact follower is held.
        measured: from and to a gap of ten times the static penetration; None where there is no such gap.
    """

    speed: float
    steps_per_revolution: int
    outcome: str
    exact: ExactFlight | None
    measured: Flight | None

    @property
    def gap_error(self) -> float | None:
        """Largest gap, over the exact one, minus one."""
        return self.measured.gap / self.exact.gap - 1.0 if self.measured and self.exact else None

    @property
    def landing_error(self) -> float | None:
        """Crank angle of the landing minus the exact one [rad]."""
        return self.measured.landing - self.exact.landing if self.measured and self.exact else None


@dataclass(frozen=True)
class GapCurve:
    """The gap over a run, thinned for a figure.

    Attributes:
        speed: over the float speed.
        gaps: crank angle [rad], gap there, least and largest gap in a span around it [m]; negative where the roller is
            sunk in.
        exact: crank angle [rad] and gap [m] over the exact flight.
        penetration: static [m].
        threshold: gap above which the follower flies [m].
    """

    speed: float
    steps_per_revolution: int
    gaps: Gaps
    exact: tuple[tuple[float, float], ...]
    penetration: float
    threshold: float


@dataclass(frozen=True)
class FollowerFloat:
    """Follower float in one engine with one preset; speeds are over the float speed unless said otherwise.

    Attributes:
        refusal: why it was not studied; empty where it was.
        theory: the float speed [rad/s]; None where it was not studied.
        steps_per_revolution, cam_vertices: of the two runs of each probe.
        penetration: static, with the coarser steps, at the speed nearest below the onset [m].
        held, flown: the fastest speed without a flight that does not shrink with h, and the slowest with one; None
            where there is no such speed.
        visible: from which speed on the exact flight's gap is above ten times that penetration.
        from_length: the onset predicted from the length of one flight well above it: speed of that run, over the one at
            which the exact flight is as long.
        curve: of one of the flights; None where the run gave none.
        exact_lengths: speed and length of the exact flight [rad], around the onset.
    """

    scene: str
    engine: str
    preset: str
    refusal: str
    theory: float | None
    steps_per_revolution: tuple[int, int]
    cam_vertices: tuple[int, int]
    penetration: float | None = None
    held: float | None = None
    flown: float | None = None
    visible: float | None = None
    from_length: float | None = None
    probes: tuple[OnsetProbe, ...] = ()
    flights: tuple[ComparedFlight, ...] = ()
    curve: GapCurve | None = None
    exact_lengths: tuple[tuple[float, float], ...] = ()

    @property
    def onset(self) -> float | None:
        """Measured onset over the theory's; None where it was not found."""
        return None if self.held is None or self.flown is None else (self.held * self.flown) ** 0.5

    @property
    def fit(self) -> bool:
        """True where the contact is hard enough to show the onset as near as `WITHIN`."""
        return self.visible is not None and self.visible <= 1.0 + WITHIN
