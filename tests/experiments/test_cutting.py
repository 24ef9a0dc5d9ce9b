"""The table of cuts on the samples: what it measures can be foreseen there."""

from __future__ import annotations

import numpy as np
import pytest

from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.experiments import cut_feet, cutting
from kinestitch.experiments.seams import random_cut
from kinestitch.samples import sample
from kinestitch.search.price import price_map


@pytest.fixture(scope="module")
def clips():
    return {name: sample(name, fps=30.0) for name in ("walk", "kick", "run")}


def cut(clips, left: str, out: int, right: str, into: int) -> Timeline:
    infos = tuple(ClipInfo(key, clips[key].frames, clips[key].fps) for key in dict.fromkeys((left, right)))
    parts = (Segment(left, FrameRange(0, out)), Segment(right, FrameRange(into, clips[right].frames)))
    return Timeline(infos, parts, (Seam(),), 30.0)


def test_a_clip_that_goes_on_slides_no_more_than_it_does(clips):
    same = {**clips, "again": sample("walk", fps=30.0)}
    on = cut_feet.measure_feet(cut(same, "walk", 50, "again", 50), same, np.zeros(2))
    off = cut_feet.measure_feet(cut(same, "walk", 50, "kick", 35), same, np.zeros(2))
    assert (on.same, on.shared) == (True, True)
    assert on.price < 1e-9 < off.price
    assert on.moved < off.moved
    assert on.slide < 0.01 < off.slide


def test_dearer_feet_cost_less_feet_and_more_of_all_else(clips):
    pair = cut_feet.pair_of(clips["walk"], clips["run"])
    rng = np.random.default_rng(0)
    line = random_cut({key: clips[key] for key in ("walk", "run")}, rng, Seam())
    while line.segments[0].clip != "walk":
        line = random_cut({key: clips[key] for key in ("walk", "run")}, rng, Seam())
    found = [cut_feet.cheapest_cut(pair, line, 0.3, size) for size in (0.0, 1.0, 3.0)]
    places = [(one.segments[0].range.stop, one.segments[1].range.start) for one in found]
    feet, rest = ([values[place] for place in places] for values in (pair.feet, pair.prices.costs))
    assert feet == sorted(feet, reverse=True)
    assert rest == sorted(rest)
    out, into = line.segments[0].range.stop, line.segments[1].range.start
    assert all(max(abs(i - out), abs(j - into)) <= 9 for i, j in places)
    # The default is what price_map itself searches.
    known = price_map(clips["walk"], clips["run"]).costs
    np.testing.assert_allclose(known, pair.prices.costs + pair.feet, atol=1e-9)


def test_prices_are_separable_far_apart_alone(clips):
    pairs, ends = cutting.separable_errors({key: sample(key) for key in ("walk", "kick")}, seams=6, seed=0)
    for errors in (pairs, ends):
        sizes = np.median(np.abs(errors), axis=0)
        assert sizes[-1] < 0.02 < sizes[:2].min()


def test_the_document(clips):
    text = cutting.as_markdown({"samples": {key: sample(key) for key in ("walk", "kick", "run")}}, seams=4, seed=0)
    tables = [line for line in text.splitlines() if line.startswith("| samples")]
    assert len(tables) == 2 * (1 + len(cut_feet.DEARNESS)) + 2 + 1 + 1
    assert "nan" not in text
    heads = [line for line in text.splitlines() if line.startswith("| data set")]
    assert len(heads) == 5
