"""A clip played at another speed: which moment of its source each of its moments shows.

A retimed clip is a clip. It has a key, frames and a rate like any other, so that every edit works on it; only where its
motion is made is its source looked up.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from itertools import pairwise

from kinestitch.errors import ParameterError

Knots = tuple[tuple[float, float], ...]

SLOWEST, FASTEST = 1e-3, 1e3
"""Speeds that may lie between two knots."""

LONGEST = 1e9
"""s; what a knot may say."""


@dataclass(frozen=True, slots=True)
class Retiming:
    """How a clip shows another one: at constant speed, or faster here and slower there.

    clip : key of the source, which is no retimed clip itself
    knots : pairs (time in s of this clip, time in s of the source), both rising, the first at time 0. Between them the
        source's time rises monotonely and without jumps of speed (Eq. 36); two knots are one constant speed.

    Raises ParameterError for fewer than two knots, times that do not rise, and speeds outside 0.001 to 1000.

    >>> Retiming("walk", ((0.0, 0.0), (4.0, 2.0))).speeds
    (0.5, 0.5)
    """

    clip: str
    knots: Knots

    def __post_init__(self) -> None:
        if not isinstance(self.clip, str):
            raise ParameterError(f"Expected the key of a retimed clip's source to be text, got {self.clip!r}.")
        object.__setattr__(self, "knots", tuple(_knot(knot) for knot in _several(self.knots)))
        if len(self.knots) < 2 or self.knots[0][0] != 0.0 or self.knots[0][1] < 0.0:
            raise ParameterError(
                f"Expected two knots or more, the first at time 0 and within clip {self.clip!r}, "
                f"got {len(self.knots)} from {self.knots[0] if self.knots else 'none'} on."
            )
        for (here, shown), (later, next_shown) in pairwise(self.knots):
            if not (later > here and SLOWEST <= (next_shown - shown) / (later - here) <= FASTEST):
                raise ParameterError(
                    f"Expected knots whose times both rise, at a speed from {SLOWEST:g} to {FASTEST:g}, "
                    f"got {(here, shown)} before {(later, next_shown)} of clip {self.clip!r}."
                )

    @property
    def speeds(self) -> tuple[float, float]:
        """The slowest and the fastest speed between two knots; 1 is the source's own."""
        each = [(shown - before) / (time - earlier) for (earlier, before), (time, shown) in pairwise(self.knots)]
        return min(each), max(each)

    def frames_at(self, fps: float) -> int:
        """Number of frames of the retimed clip: all that fall on or before the last knot."""
        return math.floor(self.knots[-1][0] * fps + 1e-6) + 1


def _several(knots: object) -> Iterable[object]:
    if not isinstance(knots, Iterable):
        raise ParameterError(f"Expected knots, got {knots!r}.")
    return knots


def _knot(knot: object) -> tuple[float, float]:
    try:
        time, shown = (float(value) for value in knot)  # type: ignore[attr-defined]
    except (TypeError, ValueError, OverflowError) as error:
        raise ParameterError(f"Expected a pair of times in s, got {knot!r:.60}.") from error
    if not (abs(time) <= LONGEST and abs(shown) <= LONGEST):
        raise ParameterError(f"Expected times up to {LONGEST:g} s, got {(time, shown)}.")
    return time + 0.0, shown + 0.0
