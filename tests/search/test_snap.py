"""Seams that snap to the cheapest frames near by."""

from __future__ import annotations

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.edit.timeline import Seam
from kinestitch.errors import ParameterError
from kinestitch.search.price import price_map
from kinestitch.search.snap import snap


@pytest.fixture(scope="module")
def clips():
    return {name: ks.sample(name) for name in ("walk", "kick")}


def test_moves_to_the_cheapest_pair_within_reach(clips):
    line = ks.append(ks.delete(ks.timeline(clips, "walk"), 90, 201), "kick", 70)
    found = snap(line, clips, 0.1)
    costs = price_map(clips["walk"], clips["kick"]).costs
    i, j = np.unravel_index(np.argmin(costs[84:97, 64:77]), (13, 13))
    # The chart is centred on the frames within reach alone, so that a neighbour may win by a hair.
    out, into = 90 + found.moves[0][0], 70 + found.moves[0][1]
    assert max(abs(out - (84 + i)), abs(into - (64 + j))) <= 1
    assert found.timeline.segments[0].range.stop == out
    assert found.timeline.segments[1].range.start == into
    assert found.after < found.before


def test_every_seam_moves_and_none_is_lost(clips):
    line = ks.timeline(clips, "walk")
    for at in (150, 100, 50):
        line = ks.replace(line, at, at + 9, "kick", 60, 63)
    found = snap(line, clips, 1.0)
    assert len(found.timeline.segments) == len(line.segments)
    assert any(move != (0, 0) for move in found.moves)
    reach = 60
    assert all(abs(out) <= reach and abs(into) <= reach for out, into in found.moves)


def test_no_deletion_is_undone(clips):
    line = ks.delete(ks.timeline(clips, "walk"), 60, 90)
    found = snap(line, clips, 1.0)
    left, right = found.timeline.segments
    assert right.range.start - left.range.stop >= 15


def test_what_stays(clips):
    line = ks.replace(ks.timeline(clips, "walk"), 60, 90, "kick", 20, 70)
    assert snap(line, clips, 0.0).timeline == line
    hard = ks.replace(ks.timeline(clips, "walk"), 60, 90, "kick", 20, 70, seam=Seam(stiffness=0.0))
    assert snap(hard, clips, 0.5).timeline == hard
    whole = ks.timeline(clips, "walk")
    assert snap(whole, clips, 0.5).timeline == whole
    with pytest.raises(ParameterError, match="seconds"):
        snap(line, clips, -1.0)
