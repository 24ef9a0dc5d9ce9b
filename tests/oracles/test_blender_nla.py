"""Blender's strips over each other: the sources where there is no gap, and our own crossfade where there is."""

import numpy as np
import pytest

from kinestitch.core.rotation import quat_distance
from kinestitch.edit import append, trim
from kinestitch.edit.timeline import timeline
from kinestitch.experiments.blender_measures import agreement
from kinestitch.experiments.blender_nla import VARIABLE, blend
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.stitch import stitch
from kinestitch.testing import assert_motion_close, random_motion

pytestmark = pytest.mark.oracle


@pytest.fixture(autouse=True)
def _chosen(blender_python, monkeypatch):
    monkeypatch.setenv(VARIABLE, str(blender_python))


def placed_cut(a, b, out, into):
    clips = {"a": a, "b": b}
    return place_timeline(append(trim(timeline(clips, "a"), 0, out), "b", into, b.frames), clips)


def test_without_a_gap_the_sources_come_back():
    clip = random_motion(3, joints=9, frames=60, bend=1.5)
    placed = placed_cut(clip, clip, 30, 30)
    blended = blend({"matched": [placed], "keyed": [placed]}, (2, 10, 20))
    assert len(blended.motions) == 6
    for motion in blended.motions.values():
        assert_motion_close(motion, clip, degrees=1e-4, metres=1e-6)
    assert blended.turned[placed.timeline] == 0
    assert blended.auto == (1.0, 1.0)


def test_it_interpolates_components_and_agrees_with_our_crossfade():
    placed = [
        placed_cut(*(random_motion(seed + k, joints=12, frames=90, bend=0.4) for k in (0, 50)), 40 + seed, 30)
        for seed in range(4)
    ]
    widths = (2, 5, 10, 30)
    blended = blend({"matched": placed}, widths)
    for row in agreement(placed, blended, widths, ["matched"]):
        assert row.lerp < 1e-3, row
        half, share = np.radians(row.way) / 2, row.share
        chord = 2 * np.arctan2(share * np.sin(half), 1 - share + share * np.cos(half))
        assert row.largest == pytest.approx(abs(np.degrees(chord - 2 * half * share)), abs=1e-3), row
        assert row.largest > 1.0, row


def test_outside_the_overlap_nothing_changes():
    placed = placed_cut(random_motion(1, frames=80), random_motion(2, frames=80), 40, 20)
    (motion,) = blend({"fade": [placed]}, (5,)).motions.values()
    hard = stitch(placed.timeline, {key: placed.sources[key] for key in "ab"}, method="cut")
    apart = np.degrees(quat_distance(motion.rotations, hard.rotations)).max(axis=1)
    assert apart[:35].max() < 1e-6
    assert apart[45:].max() < 1e-6
    assert apart[35:45].min() > 0.1
