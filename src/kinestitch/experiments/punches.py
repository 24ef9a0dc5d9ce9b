"""Cuts from one punch into another of a different intensity, shortly before the strike; and how much of it is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit import append, trim
from kinestitch.edit.timeline import Timeline, timeline
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.trade_off import near_seam

PAIRS = (("Boxing", "Jab To Elbow Punch"), ("Boxing", "Hook Punch")), (("light_punch", "heavy_punch"),)
"""Moderate and large difference, of real clips; of the samples there is one pair."""

BEFORE = 0.25
"""s from the seam to the strike."""


@dataclass(frozen=True, eq=False, slots=True)
class Punch:
    """A cut from one punch into another.

    speeds : m/s, peak speed of each clip's fastest joint; joint, frame : the second one's, and when it strikes in the
    result (the interval up to that frame)
    """

    name: str
    cut: Timeline
    speeds: tuple[float, float]
    joint: int
    frame: int


def joint_speeds(motion: Motion) -> Array:
    """Speed (F − 1, J) m/s of every joint in the world."""
    return np.asarray(np.linalg.norm(np.diff(world_pose(motion).positions, axis=0), axis=-1) * motion.fps)


def strike(motion: Motion) -> tuple[int, int, float]:
    """The frame at whose end the fastest joint is fastest, that joint, and its speed in m/s."""
    speeds = joint_speeds(motion)
    frame, joint = np.unravel_index(int(speeds.argmax()), speeds.shape)
    return int(frame) + 1, int(joint), float(speeds.max())


def punches(data: DataSet) -> list[Punch]:
    """Every pair of ``PAIRS`` both ways."""
    found = []
    for pair in PAIRS[0 if data.real else 1]:
        names = data.find(*pair)
        if names[0] != names[1]:
            found += [_punch(data, *names), _punch(data, *names[::-1])]
    return found


def _punch(data: DataSet, first: str, second: str) -> Punch:
    a, b = data.clips[first], data.clips[second]
    early = round(BEFORE * a.fps)
    (out, _, slow), (peak, joint, fast) = strike(a), strike(b)
    out, into = max(out - early, min(early, a.frames)), max(peak - early, 0)
    line = trim(timeline({first: a, second: b}, first), 0, out)
    cut = near_seam(append(line, second, into, b.frames))
    return Punch(f"{first} → {second}", cut, (slow, fast), joint, cut.starts[1] + peak - into)


def strike_kept(motion: Motion, cut: Motion, punch: Punch) -> float:
    """Speed of the striking joint when it strikes, over the hard cut's."""
    speed, own = (joint_speeds(m)[punch.frame - 1, punch.joint] for m in (motion, cut))
    return float(speed / own)
