"""The plain form: L, its transpose, the banded matrix and the full solve, each against dense matrices."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from solve_oracles import dense, energy, laplacian

from kinestitch.errors import ParameterError
from kinestitch.solve import laplacian as kl

SEEDS = st.integers(0, 2**32 - 1)
FRAMES = st.integers(1, 60)
LAMBDAS = st.sampled_from([0.0, 1e-6, 1.0, 81.0, 1296.0, 1e4])


@given(FRAMES, SEEDS)
def test_second_difference_and_its_transpose_are_the_matrix(frames: int, seed: int):
    x = np.random.default_rng(seed).normal(size=(frames, 2, 3))
    L = laplacian(frames)
    np.testing.assert_allclose(kl.second_difference(x), np.einsum("ts,sij->tij", L, x), rtol=0, atol=1e-14)
    np.testing.assert_allclose(kl.transposed_second_difference(x), np.einsum("st,sij->tij", L, x), rtol=0, atol=1e-14)


@given(FRAMES, LAMBDAS, SEEDS)
def test_bands_are_the_normal_matrix(frames: int, stiffness: float, seed: int):
    rng = np.random.default_rng(seed)
    rows = kl.row_stiffness(stiffness * rng.uniform(0, 1, frames), frames)
    weights = rng.uniform(0, 2, frames)
    L = laplacian(frames)
    full = np.diag(weights) + L.T @ np.diag(rows) @ L
    bands = kl.normal_bands(rows, weights)
    for k in range(3):
        np.testing.assert_allclose(bands[2 - k, k:], np.diag(full, k), rtol=1e-13, atol=1e-12)
    assert not np.triu(full, 3).any()
    np.testing.assert_array_equal(kl.normal_bands(rows), kl.normal_bands(rows, np.ones(frames)))


@given(FRAMES, LAMBDAS, SEEDS)
def test_full_solve_is_the_least_squares_solution(frames: int, stiffness: float, seed: int):
    rng = np.random.default_rng(seed)
    target, delta = rng.normal(size=(2, frames, 3))
    per_row = stiffness * rng.uniform(0.5, 1, frames)
    for given_stiffness in (stiffness, per_row):
        rows = kl.row_stiffness(given_stiffness, frames)
        solved = kl.solve_full(target, delta, given_stiffness)
        np.testing.assert_allclose(solved, dense(target, delta, rows), rtol=0, atol=1e-9)
        least = energy(solved, target, delta, rows)
        assert energy(solved + 1e-3 * rng.normal(size=solved.shape), target, delta, rows) > least


def test_full_solve_keeps_a_target_that_is_its_own_wish():
    target = np.random.default_rng(0).normal(size=(200, 5)) * 100
    solved = kl.solve_full(target, kl.second_difference(target), 1e8)
    np.testing.assert_allclose(solved, target, rtol=0, atol=1e-6)
    np.testing.assert_array_equal(kl.solve_full(target, np.zeros_like(target), 0.0), target)


def test_full_solve_takes_any_trailing_axes():
    rng = np.random.default_rng(1)
    target, delta = rng.normal(size=(2, 30, 4, 3))
    flat = kl.solve_full(target.reshape(30, -1), delta.reshape(30, -1), 81.0)
    np.testing.assert_allclose(kl.solve_full(target, delta, 81.0).reshape(30, -1), flat, rtol=0, atol=1e-14)


def test_frames_without_weight_are_filled():
    line = np.linspace(0, 1, 21)[:, None]
    target = line.copy()
    target[5:15] = 7.0
    weights = np.ones(21)
    weights[5:15] = 0.0
    np.testing.assert_allclose(kl.solve_full(target, np.zeros((21, 1)), 10.0, weights), line, rtol=0, atol=1e-9)


@pytest.mark.parametrize("bad", [-1.0, np.nan, np.inf, 1e20, [1.0, -1.0, 1.0]])
def test_impossible_stiffness_is_refused(bad: float):
    with pytest.raises(ParameterError, match="stiffness λ from 0 to 1e"):
        kl.solve_full(np.zeros((3, 1)), np.zeros((3, 1)), bad)


@pytest.mark.parametrize("weights", [[1.0, -1.0, 1.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]])
def test_impossible_weights_are_refused(weights: list[float]):
    with pytest.raises(ParameterError, match="weights ≥ 0 with at least two"):
        kl.solve_full(np.zeros((3, 1)), np.zeros((3, 1)), 1.0, weights)


def test_free_frames_without_stiffness_are_refused():
    with pytest.raises(ParameterError, match="free frames without stiffness"):
        kl.solve_full(np.zeros((5, 1)), np.zeros((5, 1)), 0.0, [1.0, 1.0, 0.0, 0.0, 0.0])
