"""Seams that snap to the cheapest frames near by."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinestitch as ks
from kinestitch.edit.timeline import Seam
from kinestitch.errors import ParameterError
from kinestitch.search.price import price_map
from kinestitch.search.snap import Reach, as_long_as_before, snap
from kinestitch.solve.energy import joint_price
from kinestitch.solve.placed import place_timeline


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


@given(st.integers(0, 2**32 - 1), st.integers(1, 3))
def test_the_cheapest_moves_that_keep_the_length(seed, seams):
    rng = np.random.default_rng(seed)
    choices, moves = [], []
    for _ in range(seams):
        outs, intos = (np.arange(-rng.integers(0, 3), rng.integers(0, 3) + 1) for _ in range(2))
        costs = np.where(rng.random((len(outs), len(intos))) < 0.2, np.inf, rng.random((len(outs), len(intos))))
        costs[-outs[0], -intos[0]] = rng.random()
        choices.append(Reach((0, 0), (outs[0], outs[-1]), (intos[0], intos[-1]), costs, np.empty(0), np.empty(0)))
        moves.append([(i, j) for i in range(len(outs)) for j in range(len(intos))])

    def told(entries) -> tuple[int, float]:
        pairs = list(zip(choices, entries, strict=True))
        longer = sum(out - into for out, into in (c.moves(entry) for c, entry in pairs))
        return longer, sum(float(c.costs[i, j]) for c, (i, j) in pairs)

    least = min(cost for longer, cost in map(told, product(*moves)) if longer == 0)
    assert told(as_long_as_before(choices)) == (0, pytest.approx(least, rel=1e-12))


@pytest.mark.parametrize("seconds", [0.1, 0.5])
def test_the_length_is_kept(clips, seconds):
    line = ks.timeline(clips, "walk")
    for at in (150, 60):
        line = ks.replace(line, at, at + 30, "kick", 30, 80)
    free, kept = (snap(line, clips, seconds, weights="even", keep_length=keep) for keep in (False, True))
    assert free.timeline.frames != line.frames
    assert kept.timeline.frames == line.frames
    assert sum(out - into for out, into in kept.moves) == 0
    assert kept.moves != ((0, 0),) * 4
    assert free.separable < kept.separable


def test_the_price_of_all_seams_is_told_beside_the_sum(clips):
    line = ks.replace(ks.timeline(clips, "walk"), 60, 70, "kick", 60, 70)
    near = snap(line, clips, 0.05)
    far = snap(ks.replace(ks.timeline(clips, "walk"), 50, 130, "kick", 20, 120), clips, 0.05)
    for found in (near, far):
        assert found.after == joint_price(place_timeline(found.timeline, clips))
        assert found.difference == pytest.approx(found.after / found.separable - 1)
    assert abs(far.difference) < 0.03 < abs(near.difference)


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
