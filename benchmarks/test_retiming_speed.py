"""Another pace beside another rate, and seams moved to where steps meet beside seams moved to the least cost."""

from __future__ import annotations

import numpy as np

import kinestitch as ks
from kinestitch.core.resample import resample
from kinestitch.core.retime import poses_at
from kinestitch.search.align import align_phase
from kinestitch.search.snap import snap
from kinestitch.search.warp import warp_steps
from kinestitch.testing import random_motion

SPEED = 0.7


def test_smooth_slow_motion_against_straight_lines(quick, compare):
    motion = random_motion(0, joints=65, frames=60 if quick else 600, fps=60.0)
    places = np.arange(0, motion.frames - 1, SPEED)
    compare(
        f"a clip at {SPEED} of its speed, 65 joints, {motion.frames} frames",
        lambda: poses_at(motion, places),
        "as many frames by slerp: resample()",
        lambda: resample(motion, motion.fps / SPEED),
        "none",
        repeats=5,
    )


def test_steps_that_meet_against_snapping(compare):
    clips = {name: ks.sample(name) for name in ("walk", "run")}
    line = ks.append(ks.delete(ks.timeline(clips, "walk"), 110, 201), "run", 40)
    for what, call in (("align_phase()", align_phase), ("warp_steps()", warp_steps)):
        compare(
            f"{what} of one seam, 0.3 s",
            lambda call=call: call(line, clips, 0.3),
            "snap() of the same seam",
            lambda: snap(line, clips, 0.3),
            "none",
            repeats=5,
        )
