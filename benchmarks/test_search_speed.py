"""All pairs of two clips of 2,000 frames and 22 joints with feet, beside SciPy's distances and the price told pair by
pair.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from kinestitch.core.motion import Motion
from kinestitch.core.skeleton import Skeleton
from kinestitch.samples import sample
from kinestitch.search.price import best_cuts, price_map, squared_distances
from kinestitch.search.replacement import replacement_from
from kinestitch.solve.seam import SeamPlace, seam_energy

JOINTS = 22


def over_and_over(name: str, frames: int) -> Motion:
    """A sample without its fingers and ends, repeated."""
    motion = sample(name)
    skeleton = motion.skeleton
    keep = [j for j, joint in enumerate(skeleton.names) if "Middle" not in joint and not joint.endswith("_End")]
    parents = tuple(keep.index(p) if p >= 0 else -1 for p in (skeleton.parents[j] for j in keep))
    names = tuple(skeleton.names[j] for j in keep)
    body = Skeleton(names, parents, skeleton.offsets[keep], skeleton.rest[keep])
    shown = np.arange(frames) % motion.frames
    return replace(
        motion,
        skeleton=body,
        translations=motion.translations[shown][:, keep],
        rotations=motion.rotations[shown][:, keep],
    )


@pytest.fixture(scope="module")
def clips(quick):
    found = [over_and_over(name, 200 if quick else 2000) for name in ("walk", "run")]
    assert all(clip.skeleton.joint_count == JOINTS for clip in found)
    assert price_map(*found).standing is not None
    return found


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
        f"price_map() as called, feet left out, {size}",
        lambda: price_map(*clips, contacts=False),
        "the same with feet",
        lambda: price_map(*clips),
        "none",
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
