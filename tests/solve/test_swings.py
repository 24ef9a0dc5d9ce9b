"""Offsets carried over from stance to stance: against a dense solve, and for what they must not do."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solve_oracles import laplacian

from kinestitch.solve.seam import VISIBLE
from kinestitch.solve.swings import carry_over, clearance, eased_lift, floor_under, smoothed, step_arcs

FPS = 60.0


def brute(offsets: np.ndarray, known: np.ndarray, reach: float, breaks: tuple[int, ...] = ()) -> np.ndarray:
    """argmin Σ |o|² + λ |L o|² over the unknown frames, by least squares."""
    count = len(known)
    L = (reach / VISIBLE) ** 2 * laplacian(count)
    for m in breaks:
        L[m - 1 : m + 1] = 0.0
    system = np.vstack([np.eye(count), L])
    out = np.where(known[:, None], offsets, 0.0)
    right = -system[:, known] @ out[known]
    out[~known] = np.linalg.lstsq(system[:, ~known], right, rcond=None)[0]
    return out


@st.composite
def cases(draw: st.DrawFn) -> tuple[np.ndarray, np.ndarray, float]:
    count = draw(st.integers(4, 60))
    seed = draw(st.integers(0, 2**32 - 1))
    rng = np.random.default_rng(seed)
    known = np.zeros(count, dtype=bool)
    for _ in range(draw(st.integers(1, 3))):
        start = draw(st.integers(0, count - 1))
        known[start : start + draw(st.integers(1, 20))] = True
    return rng.normal(size=(count, 2)), known, draw(st.floats(2.0, 40.0))


@settings(max_examples=60, deadline=None)
@given(cases(), st.lists(st.integers(1, 3), max_size=1))
def test_carried_offsets_are_the_least_ones(case, breaks):
    offsets, known, reach = case
    found = carry_over(offsets, known, reach, breaks=breaks)
    assert np.allclose(found, brute(offsets, known, reach, tuple(breaks)), atol=1e-8)
    assert np.array_equal(found[known], offsets[known])


@settings(max_examples=30, deadline=None)
@given(cases())
def test_time_may_run_backwards(case):
    offsets, known, reach = case
    assert np.allclose(
        carry_over(offsets[::-1], known[::-1], reach)[::-1], carry_over(offsets, known, reach), atol=1e-9
    )


def test_a_gap_is_gone_within_the_reach():
    known = np.zeros(200, dtype=bool)
    known[:50] = True
    found = carry_over(np.ones((200, 1)), known, 25.0)[:, 0]
    assert np.abs(found[50 + 25 :]).max() < 0.06
    assert np.abs(found[100:]).max() < 3e-3


def test_nothing_is_carried_over_a_hard_cut():
    known = np.arange(40) < 10
    found = carry_over(np.ones((40, 1)), known, 20.0, breaks=(12,))[:, 0]
    assert found[11] > 0.5
    assert not found[12:].any()


def test_without_a_stance_there_is_nothing_to_carry():
    assert not carry_over(np.ones((9, 2)), np.zeros(9, dtype=bool), 5.0).any()


@settings(max_examples=40, deadline=None)
@given(st.integers(40, 90), st.floats(0.01, 0.2), st.integers(0, 2**32 - 1))
def test_a_lift_gives_what_is_lacking_and_eases_in_and_out(count: int, height: float, seed: int):
    known = np.zeros(count, dtype=bool)
    known[:5] = known[-5:] = True
    lift = eased_lift(np.full(count, height), known, FPS)
    assert not lift[known].any()
    assert lift.max() == pytest.approx(height)
    assert np.allclose(lift, lift[::-1])
    swing = count - 10
    rise = min(0.2 * FPS, (swing + 1) / 2)
    assert np.abs(np.diff(lift, n=2)).max() < 8 * height / rise**2
    assert np.abs(np.diff(lift, n=2))[:5].max() < 0.6 * np.abs(np.diff(lift, n=2)).max()
    noise = np.random.default_rng(seed).normal(scale=height, size=count)
    some = eased_lift(noise, known, FPS)
    assert some.min() >= 0
    assert some.max() <= max(noise.max(), 0.0)


def test_a_foot_that_lacks_nothing_is_not_lifted_nor_where_a_clip_ends_eased():
    known = np.arange(50) < 10
    assert not eased_lift(np.full(50, -0.1), known, FPS).any()
    assert eased_lift(np.full(50, 0.1), known, FPS)[-1] == pytest.approx(0.1)
    assert not eased_lift(np.full(50, 0.1), np.ones(50, dtype=bool), FPS).any()


def test_a_foot_that_keeps_its_sources_pace_needs_no_clearance():
    path = np.cumsum(np.full((40, 2), 0.02), axis=0)
    assert np.abs(clearance(path, path + 3.0, own={}, fps=60.0, leg=0.9)).max() < 1e-12
    faster = clearance(3 * path, path, own={}, fps=60.0, leg=0.9)
    assert (faster > 0.03).all()
    assert (faster < 0.07).all()


def test_the_jump_over_a_seam_is_no_pace():
    path = np.cumsum(np.full((40, 2), 0.02), axis=0)
    cut = np.where(np.arange(40)[:, None] < 20, path, path + 5.0)
    told = clearance(path, cut, own={20: 0.0}, fps=60.0, leg=0.9)
    assert told[20] > 0.005
    assert np.abs(told[:8]).max() < 1e-12
    assert np.abs(clearance(path, cut, own={20: np.hypot(0.02, 0.02)}, fps=60.0, leg=0.9)).max() < 1e-12
    assert clearance(path[:1], path[:1], own={}, fps=60.0, leg=0.9) == pytest.approx(0.0)


def test_steps_are_arcs_between_stances():
    stands = np.array([True] * 5 + [False] * 20 + [True] * 5)
    places = np.where(np.arange(30)[:, None] < 10, [0.0, 0.0], [0.5, 0.0])
    arcs = step_arcs(stands, ~stands, places, 0.9)
    assert not arcs[stands].any()
    assert arcs.max() == pytest.approx(0.04 * 0.9, rel=0.02)
    assert np.allclose(arcs, arcs[::-1])
    short = step_arcs(stands, ~stands, places * 0.1, 0.9)
    assert short.max() == pytest.approx(0.2 * 0.05, rel=0.02)
    assert not step_arcs(stands, np.zeros(30, dtype=bool), places, 0.9).any()


@settings(max_examples=30, deadline=None)
@given(st.integers(1, 12), st.integers(0, 2**32 - 1))
def test_smoothing_keeps_a_constant_and_the_floor_is_the_lowest_near_by(half: int, seed: int):
    values = np.random.default_rng(seed).normal(size=50)
    assert np.allclose(smoothed(np.full(50, 0.3), half), 0.3)
    told = smoothed(values, half)
    assert told.max() <= values.max()
    assert told.min() >= values.min()
    expected = [values[max(0, k - half) : k + half + 1].min() for k in range(50)]
    assert np.array_equal(floor_under(values, half), expected)
