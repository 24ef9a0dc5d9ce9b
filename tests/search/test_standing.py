"""Feet in a cost, against the same told place by place; and that they change no price."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import kinestitch as ks
from kinestitch.samples import sample
from kinestitch.search.features import seam_factors
from kinestitch.search.price import best_cut, price_map, squared_distances
from kinestitch.search.replacement import Limits, best_replacement
from kinestitch.search.snap import snap
from kinestitch.search.standing import CONTACT, both_standing, standing_columns, standing_feet
from kinestitch.testing import random_motion

SEEDS = st.integers(0, 2**32 - 1)


def told_place_by_place(first: np.ndarray, second: np.ndarray, stiffness: float) -> np.ndarray:
    """What feet cost between all places, one by one and foot by foot."""

    def stands(held: np.ndarray, place: int, foot: int) -> float:
        around = [held[min(max(frame, 0), len(held) - 1), foot] for frame in (place - 1, place)]
        return sum(around) / 2

    out = np.zeros((len(first) + 1, len(second) + 1))
    for i, j in np.ndindex(out.shape):
        a, b = ([stands(held, place, foot) for foot in (0, 1)] for held, place in ((first, i), (second, j)))
        one_sided = (a[0] - b[0]) ** 2 + (a[1] - b[1]) ** 2
        in_the_air = ((1 - a[0]) * (1 - a[1]) + (1 - b[0]) * (1 - b[1])) / 2
        out[i, j] = one_sided + in_the_air**2
    return out * CONTACT**2 * seam_factors(stiffness)[0]


@given(SEEDS, st.integers(1, 9), st.integers(1, 9), st.sampled_from([1.0, 81.0, 1296.0]))
def test_columns_tell_what_feet_cost(seed, frames, others, stiffness):
    rng = np.random.default_rng(seed)
    first, second = rng.random((frames, 2)) < 0.5, rng.random((others, 2)) < 0.5
    found = squared_distances(*standing_columns(first, second, stiffness))
    np.testing.assert_allclose(found, told_place_by_place(first, second, stiffness), atol=1e-12)


@pytest.fixture(scope="module")
def maps():
    a, b = sample("walk"), sample("kick")
    return price_map(a, b), price_map(a, b, contacts=False)


def test_contacts_add_to_costs_and_to_no_price(maps):
    known, blind = maps
    assert known.standing is not None
    assert blind.standing is None
    feet = told_place_by_place(*known.standing, known.stiffness)
    np.testing.assert_allclose(known.costs - blind.costs, feet, atol=1e-9)
    assert known.price(60, 70) == blind.price(60, 70)


def test_inside_a_stance_of_the_same_feet_alone_nothing_is_added(maps):
    known, blind = maps
    added = (known.costs - blind.costs)[1:-1, 1:-1]
    stands = [(held[1:].astype(float) + held[:-1]) / 2 for held in known.standing]
    same = (stands[0][:, None] == stands[1]).all(axis=-1)
    free = same & (stands[0].max(axis=1) == 1.0)[:, None]
    assert 0 < free.sum() < free.size
    np.testing.assert_array_equal(added < 1e-9, free)


def test_the_best_cut_is_the_least_of_all_with_feet(maps):
    known, blind = maps
    costs = blind.costs + told_place_by_place(*known.standing, known.stiffness)
    i, j = np.unravel_index(np.argmin(costs[40:150, 20:90]), (110, 70))
    cut = best_cut(known.a, known.b, outs=(40, 149), intos=(20, 89))
    assert (cut.out, cut.into) == (40 + i, 20 + j)
    assert cut.cost == pytest.approx(costs[40 + i, 20 + j])
    assert cut.exact_cost - cut.cost == pytest.approx(cut.price - cut.separable, abs=0.2 * abs(cut.price))


def test_plain_prices_know_no_feet(maps):
    even = price_map(maps[0].a, maps[0].b, weights="even")
    assert even.standing is None
    assert even.costs[30, 40] == pytest.approx(even.price(30, 40))


def test_a_rig_without_feet_has_none():
    a, b = (random_motion(seed, frames=30) for seed in (0, 1))
    assert standing_feet(a) is None
    np.testing.assert_array_equal(price_map(a, b).costs, price_map(a, b, contacts=False).costs)


def test_a_treadmill_says_nothing_about_feet():
    walk = sample("walk")
    translations = walk.translations.copy()
    translations[:, 0, [0, 2]] = 0.0
    on_the_spot = replace(walk, translations=translations)
    assert standing_feet(on_the_spot) is None
    assert both_standing(walk, on_the_spot) is None
    np.testing.assert_array_equal(
        price_map(walk, on_the_spot).costs, price_map(walk, on_the_spot, contacts=False).costs
    )


def test_replacement_and_snap_have_the_switch():
    clips = {name: sample(name) for name in ("walk", "run")}
    limits = Limits(start=(40, 90), pasted=(20, 60))
    known, blind = (best_replacement(*clips.values(), limits, contacts=contacts) for contacts in (True, False))
    assert (known.start, known.clip_start) != (blind.start, blind.clip_start)
    assert known.cost >= blind.cost
    line = ks.append(ks.delete(ks.timeline(clips, "walk"), 100, 201), "run", 20)
    known, blind = (snap(line, clips, 0.3, contacts=contacts) for contacts in (True, False))
    assert known.moves != blind.moves


def test_snap_counts_feet_as_the_map_does():
    clips = {name: sample(name) for name in ("walk", "run")}
    line = ks.append(ks.delete(ks.timeline(clips, "walk"), 100, 201), "run", 20)
    for contacts in (True, False):
        costs = price_map(*clips.values(), contacts=contacts).costs
        i, j = np.unravel_index(np.argmin(costs[82:119, 2:39]), (37, 37))
        ((out, into),) = snap(line, clips, 0.3, contacts=contacts).moves
        # The chart is centred on the frames within reach alone, so that a neighbour may win by a hair.
        assert max(abs(100 + out - (82 + i)), abs(20 + into - (2 + j))) <= 1
