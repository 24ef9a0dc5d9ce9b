"""What walking and running share: two legs half a cycle apart, written once and mirrored in time."""

from __future__ import annotations

from dataclasses import dataclass

from kinestitch.samples.feet import Footwork, Stance


@dataclass(frozen=True, slots=True)
class Gait:
    """One leg's cycle; times are shares of the period, counted from its touch-down.

    period : s; speed : m/s, forwards (+Z)
    roll : rows ``(share, pitch deg)`` from touch-down to take-off
    swing : rows ``(share, y m, z m, pitch deg)`` of the ankle between take-off and touch-down, z seen from the hips
    ahead : m, how far before the hips the ball of the foot is set down
    apart : m, half the distance between the feet; toes_out : degrees
    """

    period: float
    speed: float
    roll: tuple[tuple[float, float], ...]
    swing: tuple[tuple[float, float, float, float], ...]
    ahead: float
    apart: float
    toes_out: float

    def footwork(self, side: float, start: float, seconds: float) -> Footwork:
        """The left (`side` 1) or right (−1) foot, which touches down at `start` plus whole periods, for `seconds`."""
        first = -2
        count = int(seconds / self.period) + 5
        downs = [start + (first + k) * self.period for k in range(count)]
        yaw = side * self.toes_out
        stances = tuple(
            Stance(
                side * self.apart,
                self.speed * down + self.ahead,
                tuple((down + share * self.period, pitch, yaw) for share, pitch in self.roll),
            )
            for down in downs
        )
        return Footwork(stances, tuple(self._passing(side, down, yaw) for down in downs[:-1]))

    def _passing(self, side: float, down: float, yaw: float) -> tuple[tuple[float, ...], ...]:
        rows = []
        for share, y, z, pitch in self.swing:
            time = down + share * self.period
            rows.append((time, side * self.apart, y, self.speed * time + z, pitch, yaw))
        return tuple(rows)
