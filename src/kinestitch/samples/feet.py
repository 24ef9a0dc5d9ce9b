"""Where the feet are: stances that do not slide, joined by swings that leave and meet them at their own speed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array, quat_about_axis, quat_multiply, quat_rotate
from kinestitch.samples.body import ANKLE, BALL, HEEL
from kinestitch.samples.curves import Curve, ease, through

_STEP = 1e-3


@dataclass(frozen=True, slots=True)
class Stance:
    """One contact of a foot with the floor.

    x, z : m, the ball of the foot, fixed as long as the heel or the whole sole does not carry alone
    roll : rows ``(time s, pitch deg, yaw deg)``: pitch > 0 stands on the heel with the toes up, < 0 on the ball with
        the heel up; the first row is the touch-down, the last the take-off; the foot eases from row to row
    """

    x: float
    z: float
    roll: tuple[tuple[float, float, float], ...]

    @property
    def down(self) -> float:
        """Time of touch-down in s."""
        return self.roll[0][0]

    @property
    def up(self) -> float:
        """Time of take-off in s."""
        return self.roll[-1][0]

    def angles(self, t: Array) -> Array:
        """Pitch and yaw (F, 2) in degrees; the first and last pieces move at the touch-down and at the take-off."""
        table = np.array(self.roll)
        values = np.repeat(table[:1, 1:], len(t), axis=0)
        last = len(table) - 2
        for i, (a, b) in enumerate(pairwise(table)):
            s = (t - a[0]) / (b[0] - a[0])
            share = ease(s)
            if i == 0 and a[1] != 0:
                share = 1 - (1 - np.minimum(s, 1)) ** 3 * (1 + np.minimum(s, 1))
            elif i == last and b[1] != 0:
                share = np.maximum(s, 0) ** 3 * (2 - np.maximum(s, 0))
            values = values + share[:, None] * (b - a)[1:]
        return values

    def ankle(self, t: Array) -> Array:
        """Position of the ankle (F, 3) m."""
        pitch, yaw = self.angles(t).T
        turn = foot_turn(pitch, yaw)
        level = quat_about_axis(1, np.radians(yaw))
        ball = np.array([self.x, ANKLE + BALL[1], self.z])
        heel = ball + quat_rotate(level, np.array(HEEL) - np.array(BALL))
        on_heel = heel - quat_rotate(turn, np.array(HEEL))
        return np.where((pitch > 0)[:, None], on_heel, ball - quat_rotate(turn, np.array(BALL)))

    def state(self, t: Array) -> Array:
        """Ankle, pitch and yaw in one row (F, 5)."""
        return np.concatenate([self.ankle(t), self.angles(t)], axis=1)

    def rates(self, at: float) -> Array:
        """Velocity and acceleration (2, 5) of the state at a time."""
        before, here, after = self.state(np.array([at - _STEP, at, at + _STEP]))
        return np.stack([(after - before) / (2 * _STEP), (after - 2 * here + before) / _STEP**2])


def foot_turn(pitch: Array, yaw: Array) -> Array:
    """World rotation (F, 4) of a foot from pitch (toes up > 0) and yaw in degrees."""
    return quat_multiply(quat_about_axis(1, np.radians(yaw)), quat_about_axis(0, -np.radians(pitch)))


@dataclass(frozen=True, slots=True)
class Footwork:
    """A foot's whole part: its stances in order, and for each swing between two of them the points it passes.

    swings : for each pair of neighbouring stances rows ``(time, x, y, z, pitch, yaw)`` of the ankle, s, m and degrees
    """

    stances: tuple[Stance, ...]
    swings: tuple[tuple[tuple[float, ...], ...], ...] = ()

    def state(self, t: Array) -> Array:
        """Ankle position, pitch and yaw (F, 5) in m and degrees."""
        values = self.stances[0].state(t)
        for stance in self.stances[1:]:
            here = t >= stance.down
            values[here] = stance.state(t[here])
        for before, after, via in zip(self.stances[:-1], self.stances[1:], self.swings, strict=True):
            here = (t > before.up) & (t < after.down)
            values[here] = _swing(before, after, via)(t[here])
        return values

    def toes(self, t: Array) -> Array:
        """How far the toes bend up (F,) in degrees, so that they lie flat where the foot stands on its ball."""
        pitch = self.state(t)[:, 3]
        weight = np.zeros(len(t))
        for i, stance in enumerate(self.stances):
            after = self.stances[i + 1].down if i + 1 < len(self.stances) else np.inf
            before = self.stances[i - 1].up if i > 0 else -np.inf
            leave = min(0.18, 0.4 * (after - stance.up))
            arrive = min(0.14, 0.4 * (stance.down - before))
            rise = ease((t - stance.down + arrive) / arrive) if stance.roll[0][1] < 0 else t >= stance.down
            fall = ease((stance.up + leave - t) / leave)
            weight = np.maximum(weight, rise * fall)
        return weight * np.maximum(-pitch, 0.0)

    def contacts(self, t: Array) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
        """Whether the whole sole stands still (F,) and whether the ball of the foot does (F,)."""
        sole = np.zeros(len(t), dtype=bool)
        ball = np.zeros(len(t), dtype=bool)
        for stance in self.stances:
            here = (t >= stance.down - 1e-9) & (t <= stance.up + 1e-9)
            pitch, _ = stance.angles(t).T
            ball |= here & (pitch <= 0)
            rates = (stance.angles(t + _STEP) - stance.angles(t - _STEP)) / (2 * _STEP)
            sole |= here & (pitch == 0) & (np.abs(rates) < 1e-3).all(axis=1)
        return sole, ball


def _swing(before: Stance, after: Stance, via: Sequence[Sequence[float]]) -> Curve:
    start = before.state(np.array([before.up]))[0]
    end = after.state(np.array([after.down]))[0]
    times = [before.up, *(row[0] for row in via), after.down]
    points = np.stack([start, *(np.array(row[1:]) for row in via), end])
    return through(times, points, before.rates(before.up), after.rates(after.down))


def planted(x: float, z: float, yaw: float, seconds: float) -> Footwork:
    """A foot that stands flat for the whole clip."""
    return Footwork((Stance(x, z, ((-1.0, 0.0, yaw), (seconds + 1.0, 0.0, yaw))),))
