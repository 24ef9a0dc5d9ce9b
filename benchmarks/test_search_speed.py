"""All pairs of two clips of 2,000 frames and 22 joints, beside SciPy's distances and the price told pair by pair."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from kinestitch.search.price import best_cuts, price_map, squared_distances
from kinestitch.search.replacement import replacement_from
from kinestitch.solve.seam import SeamPlace, seam_energy
from kinestitch.testing import random_motion

JOINTS = 22


@pytest.fixture(scope="module")
def clips(quick):
    return [random_motion(seed, joints=JOINTS, frames=200 if quick else 2000) for seed in (0, 1)]


@pytest.fixture(scope="module")
def prices(clips):
    return price_map(*clips, weights="even")


def test_map_against_scipy(clips, prices, compare):
    size = f"{clips[0].frames:,} × {clips[1].frames:,} cuts, {JOINTS} joints"
    p, q = prices.first, prices.second
    compare(
        f"price_map() as called, {size}",
        lambda: price_map(*clips),
        "SciPy cdist of features that stand ready",
        lambda: cdist(p, q, "sqeuclidean"),
        "≤ 1",
        repeats=3,
    )
    compare(
        f"the product alone, {size}",
        lambda: squared_distances(p, q),
        "SciPy cdist of the same features",
        lambda: cdist(p, q, "sqeuclidean"),
        "≤ 0.3",
        repeats=5,
    )


def test_map_against_pair_by_pair(clips, prices, compare):
    place = SeamPlace(0, 200, prices.stiffness)
    pairs = np.random.default_rng(0).normal(size=(20, 2, 3 * JOINTS))

    def one_by_one():
        for offsets in pairs:
            seam_energy(place, 400, offsets)

    compare(
        f"price_map() as called, {prices.costs.size:,} cuts",
        lambda: price_map(*clips),
        "the price of 20 cuts one by one, their offsets ready",
        one_by_one,
        "none",
        repeats=3,
    )


def test_search_in_the_map(prices, compare):
    compare(
        "best replacement of all, four frames free, from the map",
        lambda: replacement_from(prices),
        "the map's own product",
        lambda: squared_distances(prices.first, prices.second),
        "none",
        repeats=3,
    )
    compare(
        "ten best cuts, well apart, priced exactly",
        lambda: best_cuts(prices, 10),
        "the map's own product",
        lambda: squared_distances(prices.first, prices.second),
        "none",
        repeats=3,
    )
