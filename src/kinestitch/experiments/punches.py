"""Cuts from one punch into another of a different intensity, shortly before the strike; and how much of it is left."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit import append, trim
from kinestitch.edit.timeline import Timeline, timeline
from kinestitch.experiments.blender_nla import Blended
from kinestitch.experiments.dataset import DataSet
from kinestitch.experiments.page import Picture, panels, picture
from kinestitch.experiments.trade_off import near_seam
from kinestitch.solve.stitch import stitch

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
    # a strike that comes at once leaves no room for a blend: then the middle of the clip has to do
    out, into = out - early if out >= early + a.fps else a.frames // 2, max(peak - early, 0)
    line = trim(timeline({first: a, second: b}, first), 0, out)
    cut = near_seam(append(line, second, into, b.frames))
    return Punch(f"{first} → {second}", cut, (slow, fast), joint, cut.starts[1] + peak - into)


def strike_kept(motion: Motion, cut: Motion, punch: Punch) -> float:
    """Speed of the striking joint when it strikes, over the hard cut's."""
    speed, own = (joint_speeds(m)[punch.frame - 1, punch.joint] for m in (motion, cut))
    return float(speed / own)


def strike_drawn(data: DataSet, blended: Blended) -> Picture:
    """Speed of the striking joint over time, both ways between the punches that differ most: cut, ours, Blender."""
    found = sorted(punches(data), key=lambda punch: max(punch.speeds) / min(punch.speeds))[-2:]
    drawing, axes = panels(1, len(found), size=(5.2 * len(found), 3.2))
    for axis, punch in zip(axes, found, strict=True):
        widths = sorted({width for cut, width, mode in blended.motions if cut == punch.cut and mode == "matched"})
        lines = [("hard cut", "#9A9A9A", stitch(punch.cut, data.clips, method="cut"))]
        lines += [
            (f"Blender, {width} frames", colour, blended.motions[punch.cut, width, "matched"])
            for width, colour in zip((widths[len(widths) // 2], widths[-1]), ("#56B4E9", "#0072B2"), strict=True)
        ]
        lines.append(("ours, default", "#111111", stitch(punch.cut, data.clips)))
        seam, fps = punch.cut.starts[1], punch.cut.fps
        for label, colour, motion in lines:
            speed = joint_speeds(motion)[:, punch.joint]
            axis.plot((np.arange(len(speed)) + 1 - seam) / fps, speed, color=colour, label=label)
        axis.set_ylim(0, 1.3 * max(punch.speeds))  # the hard cut's jump would leave no room for the rest
        axis.axvline(0, color="#CC79A7", linestyle="--", linewidth=1)
        axis.set_xlim(-1, 1)
        axis.set_title(punch.name, loc="left")
        axis.set_xlabel("s from the seam")
    axes[0].set_ylabel("speed of the striking joint (m/s)")
    axes[0].legend(frameon=False, fontsize="small")
    return picture(drawing, "A strike over a seam a quarter of a second before it.", own=not data.real)
