"""The best replacement against four nested loops."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.errors import RangeError
from kinestitch.samples import sample
from kinestitch.search.price import price_map
from kinestitch.search.replacement import (
    Limits,
    best_replacement,
    best_replacements,
    replacement_from,
    sliding_minimum,
)
from kinestitch.testing import random_motion

SEEDS = st.integers(0, 2**32 - 1)


def brute_force(costs: np.ndarray, limits: Limits) -> float:
    def within(value: int, span) -> bool:
        return span is None or span[0] <= value <= span[1]

    frames, clip = costs.shape[0] - 1, costs.shape[1] - 1
    best = np.inf
    for ts, te in product(range(1, frames), repeat=2):
        if te < ts or not (within(ts, limits.start) and within(te, limits.stop) and within(te - ts, limits.removed)):
            continue
        for into, out in product(range(clip), range(1, clip + 1)):
            if not (within(into, limits.clip_start) and within(out, limits.clip_stop)):
                continue
            if out > into and within(out - into, limits.pasted):
                best = min(best, costs[ts, into] + costs[te, out])
    return best


spans = st.tuples(st.integers(1, 11), st.integers(0, 6)).map(lambda s: (s[0], min(s[0] + s[1], 11)))


@settings(max_examples=40, deadline=None)
@given(SEEDS, spans, spans, spans, spans, st.tuples(st.integers(0, 4), st.integers(0, 8)), spans)
def test_equals_brute_force(seed, start, stop, clip_start, clip_stop, removed, pasted):
    a, b = (random_motion(seed % 1000 + i, frames=12) for i in range(2))
    prices = price_map(a, b, stiffness=3.0)
    limits = Limits(start, stop, clip_start, clip_stop, (removed[0], removed[0] + removed[1]), pasted)
    least = brute_force(prices.costs, limits)
    if not np.isfinite(least):
        with pytest.raises(RangeError, match="some replacement keeps"):
            replacement_from(prices, limits)
        return
    found = replacement_from(prices, limits)
    assert found.cost == pytest.approx(least, rel=1e-12)
    both = prices.costs[found.start, found.clip_start] + prices.costs[found.stop, found.clip_stop]
    assert found.cost == pytest.approx(both, rel=1e-12)
    assert start[0] <= found.start <= start[1]
    assert stop[0] <= found.stop <= stop[1]
    assert pasted[0] <= found.clip_stop - found.clip_start <= pasted[1]


def test_left_open():
    a, b = (random_motion(i, frames=12) for i in range(2))
    found = best_replacement(a, b, stiffness=0.01)
    prices = price_map(a, b, stiffness=0.01)
    assert prices.apart == 2
    own = Limits(start=(2, 11), stop=(1, 10), removed=(1, 12), pasted=(4, 12))
    assert found.cost == pytest.approx(brute_force(prices.costs, own), rel=1e-12)


@settings(max_examples=20, deadline=None)
@given(SEEDS)
def test_several_are_well_apart_and_each_goes_out_most_cheaply(seed):
    a, b = (random_motion(seed % 1000 + i, frames=16) for i in range(2))
    prices = price_map(a, b, stiffness=0.01)
    limits = Limits(start=(1, 15), stop=(1, 15), removed=(2, 9), pasted=(3, 12))
    found = best_replacements(prices, limits, 4)
    assert found[0] == replacement_from(prices, limits)
    assert [one.cost for one in found] == sorted(one.cost for one in found)
    ways_in = [(one.start, one.clip_start) for one in found]
    for n, ((start, into), one) in enumerate(zip(ways_in, found, strict=True)):
        here = replace(limits, start=(start, start), clip_start=(into, into))
        assert one.cost == pytest.approx(brute_force(prices.costs, here), rel=1e-12)
        assert all(max(abs(start - i), abs(into - j)) >= prices.apart for i, j in ways_in[:n])
    exact = best_replacements(prices, limits, 2, exact=True)
    assert list(exact) == sorted(best_replacements(prices, limits, 8), key=lambda one: one.exact_cost)[:2]


def test_the_price_counts_both_seams_together():
    walk, kick = sample("walk"), sample("kick")
    near = best_replacement(walk, kick, Limits(start=(60, 100), pasted=(10, 10), removed=(10, 40)))
    far = best_replacement(walk, kick, Limits(start=(60, 100), pasted=(70, 120), removed=(10, 40)))
    assert abs(far.difference) < 0.03
    assert abs(near.difference) > 2 * abs(far.difference)


@given(SEEDS, st.integers(0, 12), st.integers(0, 12))
def test_sliding_minimum(seed, first, more):
    values = np.random.default_rng(seed).normal(size=(9, 2))
    found = sliding_minimum(values, first, first + more)
    for i in range(9):
        window = values[i + first : i + first + more + 1]
        np.testing.assert_array_equal(found[i], window.min(axis=0) if len(window) else [np.inf, np.inf])


@pytest.mark.parametrize(
    "limits",
    [Limits(start=(0, 3)), Limits(stop=(3, 99)), Limits(pasted=(5, 3)), Limits(clip_start=(-1, 2))],
)
def test_limits_outside_the_clips_are_refused(limits):
    a, b = (random_motion(i, frames=12) for i in range(2))
    with pytest.raises(RangeError, match="Expected"):
        best_replacement(a, b, limits)
