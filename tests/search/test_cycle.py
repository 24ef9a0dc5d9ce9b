"""The best cycle against brute force over all starts and stops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import kinestitch as ks
from kinestitch.core.kinematics import turn_about_up
from kinestitch.core.motion import Motion
from kinestitch.edit.timeline import FrameRange
from kinestitch.errors import ParameterError, RangeError
from kinestitch.search.cycle import best_cycle, whole_cycle
from kinestitch.search.features import column_scales, joint_weights, place_features
from kinestitch.search.standing import standing_columns, standing_feet
from kinestitch.solve.loop import around_seam, loop, opened
from kinestitch.testing import random_motion

SEEDS = st.integers(0, 2**32 - 1)


def part(motion: Motion, start: int, stop: int) -> Motion:
    return replace(motion, rotations=motion.rotations[start:stop], translations=motion.translations[start:stop])


def brute_force(motion: Motion, fewest: int, most: int) -> dict[int, tuple[float, int]]:
    """Per number of frames the least cost and its start."""
    whole = [FrameRange(0, motion.frames - 1), FrameRange(0, motion.frames)]
    found = place_features([motion, *(around_seam(motion, span) for span in whole)], 81.0)
    own, *ends = (f * column_scales(motion.skeleton, joint_weights(motion.skeleton)) for f in found)
    costs = [
        (float(np.sum((own[j] - own[i]) ** 2)), i, j) for i in range(1, motion.frames) for j in range(i, motion.frames)
    ]
    costs += [(float(np.sum((end[3] - end[1]) ** 2)), s.start, s.stop) for end, s in zip(ends, whole, strict=True)]
    best: dict[int, tuple[float, int]] = {}
    for cost, start, stop in costs:
        if fewest <= stop - start <= most:
            best[stop - start] = min(best.get(stop - start, (np.inf, 0)), (cost, start))
    return best


@settings(max_examples=15, deadline=None)
@given(SEEDS, st.integers(8, 40), st.none() | st.floats(0.1, 0.6), st.none() | st.floats(0.7, 2.0))
def test_no_cycle_is_cheaper_but_for_longer_ones(seed, frames, shortest, longest):
    motion = random_motion(seed, frames=frames, bend=0.4)
    fewest = -(-frames // 2) if shortest is None else max(2, int(np.ceil(shortest * 30)))
    most = frames if longest is None else min(frames, int(longest * 30))
    if fewest > most:
        with pytest.raises(RangeError, match="holds a cycle"):
            best_cycle(motion, shortest=shortest, longest=longest)
        return
    best = brute_force(motion, fewest, most)
    least = min(cost for cost, _ in best.values())
    length = max(count for count, (cost, _) in best.items() if cost <= 1.3 * least + 1e-3)
    found = best_cycle(motion, shortest=shortest, longest=longest)
    assert found.frames == length
    assert found.cost == pytest.approx(best[length][0], rel=1e-6, abs=1e-9)


def test_strides_are_found_wherever_the_clip_is_cut():
    """The sample walks three strides of 66⅔ frames."""
    walk = ks.sample("walk")
    for start, stop in ((0, 201), (11, 160), (25, 170)):
        found = best_cycle(part(walk, start, stop), shortest=1.0, longest=1.2)
        assert found.frames in (66, 67)
        assert best_cycle(part(walk, start, stop)).frames in (133, 200)
        other = best_cycle(turn_about_up(part(walk, start, stop), 2.0, (1.0, 0.0, 3.0)), shortest=1.0, longest=1.2)
        assert (other.start, other.stop) == (found.start, found.stop)


def test_standing_feet_count_in_the_cost():
    """Feet that stand on one side only, and seams in the air, cost what Eq. 23 says; in a cycle they cost nothing."""
    walk = part(ks.sample("walk"), 11, 160)
    scales = column_scales(walk.skeleton, joint_weights(walk.skeleton))
    own = place_features([walk], (0.1 * 60) ** 4)[0] * scales
    held = standing_feet(walk)
    assert held is not None
    out, into = standing_columns(held, held, (0.1 * 60) ** 4)
    for contacts in (True, False):
        found = best_cycle(walk, shortest=0.6, longest=0.7, contacts=contacts)  # no stride is that short
        pose = np.sum((own[found.stop] - own[found.start]) ** 2)
        feet = np.sum((out[found.stop] - into[found.start]) ** 2) if contacts else 0.0
        assert found.cost == pytest.approx(pose + feet, rel=1e-3)  # the chart's centre differs a little
    assert feet == 0.0
    assert found.cost < best_cycle(walk, shortest=0.6, longest=0.7).cost
    run = ks.sample("run")
    assert (best_cycle(run).start, best_cycle(run).stop) == (0, 160)


def test_a_clip_that_is_a_cycle_is_taken_whole():
    walk, kick = ks.sample("walk"), ks.sample("kick")
    assert (whole_cycle(walk).start, whole_cycle(walk).stop) == (0, 200)
    assert (best_cycle(walk).start, best_cycle(walk).stop) == (0, 200)
    stride = loop(walk, 40, 107)
    assert whole_cycle(stride).stop == 67
    assert whole_cycle(opened(stride)).stop == 67  # without the frame that repeats the first, all of them are needed
    assert whole_cycle(kick).start == 0


def test_a_still_clip_is_taken_whole():
    walk = ks.sample("walk")
    still = replace(walk, rotations=walk.rotations[[7] * 30], translations=walk.translations[[7] * 30])
    assert best_cycle(still).frames >= 29


def test_what_holds_no_cycle_is_refused():
    walk = ks.sample("walk")
    with pytest.raises(RangeError, match="at least 3 frames to loop, got 2"):
        whole_cycle(part(walk, 0, 2))
    with pytest.raises(RangeError, match="at least 3 frames to loop, got 2"):
        best_cycle(part(walk, 0, 2))
    with pytest.raises(RangeError, match="cycle of 300 frames or more, got 201 frames"):
        best_cycle(walk, shortest=5.0)
    with pytest.raises(RangeError, match="of which 30 may count"):
        best_cycle(walk, longest=0.5)
    with pytest.raises(ParameterError, match="length in seconds"):
        best_cycle(walk, shortest=-1.0)
    with pytest.raises(ParameterError, match="λ > 0"):
        best_cycle(walk, stiffness=0.0)
