"""Whose rig and rate the result has: the original's, whatever order its clips were named in."""

from dataclasses import replace

import pytest

from kinestitch.edit import replace as paste
from kinestitch.edit.timeline import timeline
from kinestitch.errors import RangeError
from kinestitch.solve.stitch import stitch
from kinestitch.testing import random_motion


def test_the_original_is_the_clip_that_the_timeline_starts_from():
    walk, kick = random_motion(0, frames=90), random_motion(1, frames=60)
    longer = replace(kick, skeleton=replace(kick.skeleton, offsets=2 * kick.skeleton.offsets))
    clips = {"kick": longer, "walk": walk}
    line = paste(timeline(clips, "walk"), 0, 30, "kick", 10, 40)
    assert line.clips[0].key == "walk"
    assert stitch(line, clips).skeleton == walk.skeleton


def test_a_clip_of_another_rate_than_the_timeline_knows_is_refused():
    clips = {"a": random_motion(0, frames=60), "b": random_motion(1, frames=60)}
    line = paste(timeline(clips, "a"), 20, 30, "b", 10, 20)
    with pytest.raises(RangeError, match="Expected 30 fps in clip 'b', as its timeline says, got 120"):
        stitch(line, {**clips, "b": replace(clips["b"], fps=120.0)})
