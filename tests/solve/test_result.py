"""What a result is besides its poses."""

from __future__ import annotations

from kinestitch.edit.operations import append, insert
from kinestitch.edit.timeline import timeline
from kinestitch.solve.stitch import solve_timeline, stitch
from kinestitch.testing import random_motion


def test_it_is_named_after_the_clip_it_starts_with():
    clips = {name: random_motion(seed, frames=30) for seed, name in enumerate(("walk", "kick", "jump"))}
    line = append(timeline(clips, "walk"), "kick")
    assert stitch(line, clips).name == "walk"
    solved = solve_timeline(insert(line, 0, "jump"), clips)
    assert (solved.motion.name, solved.cut.name) == ("jump", "jump")
