"""The pinned solves against the same problem written out densely, and what they do at length."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solve_oracles import laplacian

from kinestitch.solve.laplacian import row_stiffness
from kinestitch.solve.pinned import banded_product, eliminated, nearest, path_rows, pinned_correction, pinned_path
from kinestitch.solve.seam import Cluster, SeamPlace, cluster_rows, correction


def dense_minimum(matrix, rhs, rows, gaps, weights):
    """argmin cᵀ M c − 2 cᵀ rhs + Σ w / (S M⁻¹ Sᵀ)_pp |S c − gap|² with S c = gap for infinite weights, by its KKT
    system.
    """
    exact = np.isinf(weights)
    lone = np.einsum("pk,pk->p", rows, np.linalg.solve(matrix, rows.T).T)
    soft = np.where(exact, 0.0, weights) / lone if len(lone) else weights
    soft[exact] = 0.0
    full = matrix + rows.T @ (soft[:, None] * rows)
    fixed = rows[exact]
    count = len(fixed)
    system = np.block([[full, fixed.T], [fixed, np.zeros((count, count))]])
    right = np.vstack([rhs + rows.T @ (soft[:, None] * gaps), gaps[exact]])
    return np.linalg.solve(system, right)[: len(matrix)]


def energy(rows):
    """I + LᵀΛL, dense."""
    L = laplacian(len(rows))
    return np.eye(len(rows)) + L.T @ (rows[:, None] * L)


@st.composite
def pins(draw, count, first=0):
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    amount = draw(st.integers(1, min(6, count - first)))
    frames = np.sort(rng.choice(np.arange(first, count), amount, replace=False))
    exact = rng.random(amount) < draw(st.sampled_from([0.0, 0.5, 1.0]))
    weights = np.where(exact, np.inf, 10.0 ** rng.uniform(-3, 3, amount))
    return frames, rng.normal(size=(amount, 2)), weights


STIFFNESS = st.floats(-2, 4).map(lambda power: 10.0**power)


@given(st.data(), st.integers(3, 60), STIFFNESS)
def test_pinned_frames_equal_the_dense_solution(data, count, stiffness):
    frames, gaps, weights = data.draw(pins(count))
    rows = row_stiffness(stiffness, count)
    found = pinned_correction(rows, frames, gaps, weights)
    select = np.eye(count)[frames]
    expected = dense_minimum(energy(rows), np.zeros((count, 2)), select, gaps, weights)
    assert np.abs(found - expected).max() < 1e-9
    exact = np.isinf(weights)
    assert np.array_equal(found[frames[exact]], gaps[exact])


@given(st.data(), st.integers(1, 60), STIFFNESS, st.booleans())
def test_a_pinned_path_equals_the_dense_solution(data, count, stiffness, started):
    frames, gaps, weights = data.draw(pins(count + 1, first=1))
    count = int(frames[-1])  # the path ends with its last pin
    before = 2 if started else 0
    padded = energy(row_stiffness(stiffness, before + count + 2))[before : before + count, before : before + count]
    found = pinned_path(path_rows(np.full(count, stiffness), started=started), frames, gaps, weights)
    sums = (np.arange(count) < frames[:, None]).astype(float)
    steps = dense_minimum(padded, np.zeros((count, 2)), sums, gaps, weights)
    expected = np.vstack([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    assert np.abs(found - expected).max() < 1e-9 * max(1.0, np.abs(expected).max())
    exact = np.isinf(weights)
    assert np.abs(found[frames[exact]] - gaps[exact]).max(initial=0.0) < 1e-12


@given(st.integers(0, 2**32 - 1), st.integers(40, 90), st.floats(0, 3).map(lambda power: 10.0**power))
def test_pins_after_seams_equal_seams_and_pins_together(seed, count, stiffness):
    """Where they share Λ, which is the update ``c += G G_pp⁻¹ (gap − c_p)`` of a system that is solved already."""
    rng = np.random.default_rng(seed)
    m, frames = count // 2, np.sort(rng.choice(count, 3, replace=False))
    cluster = Cluster(0, count, (SeamPlace(0, m, stiffness),))
    rows, offsets, wanted = cluster_rows(cluster), rng.normal(size=(2, 2)), rng.normal(size=(3, 2))
    weights = np.array([np.inf, np.inf, 2.0])
    seamed = correction(cluster, offsets)
    found = seamed + pinned_correction(rows, frames, wanted - seamed[frames], weights)
    residual = np.zeros((count, 2))
    residual[m - 1], residual[m] = -offsets[1], offsets[0]
    rhs = laplacian(count).T @ (rows[:, None] * residual)
    expected = dense_minimum(energy(rows), rhs, np.eye(count)[frames], wanted, weights)
    assert np.abs(found - expected).max() < 1e-9


@given(st.integers(20, 60), STIFFNESS, st.floats(-3, 4).map(lambda power: 10.0**power), st.data())
def test_a_lone_pin_goes_its_share_of_the_way(count, stiffness, weight, data):
    frame = data.draw(st.integers(1, count - 1))
    wanted = np.array([weight / (weight + 1)])
    one, at = np.ones((1, 1)), np.array([frame])
    found = pinned_correction(row_stiffness(stiffness, count), at, one, np.array([weight]))
    assert found[frame] == pytest.approx(wanted, rel=1e-8)
    path = pinned_path(path_rows(np.full(frame, stiffness), started=True), at, one, np.array([weight]))
    assert path[frame] == pytest.approx(wanted, rel=1e-8)


LONG = 10_000
NEAR_AND_FAR = np.concatenate([np.arange(40, 60), np.arange(3000, 3040, 2), np.arange(4000, LONG, 500)])


@pytest.mark.parametrize("stiffness", [1.0, 1e4, 1e6, 1e8])
def test_ten_thousand_frames_with_many_pins_near_and_far(stiffness):
    """Smooth gaps, as of a curve through all pins; the system is followed wherever nothing is pinned."""
    gaps = np.stack([np.sin(NEAR_AND_FAR / 900), np.cos(NEAR_AND_FAR / 500)], axis=1)
    rows = row_stiffness(stiffness, LONG)
    found = pinned_correction(rows, NEAR_AND_FAR, gaps, np.full(len(gaps), np.inf))
    assert np.array_equal(found[NEAR_AND_FAR], gaps)
    assert np.abs(found).max() < 3.0
    free = np.ones(LONG, dtype=bool)
    free[NEAR_AND_FAR] = False
    assert np.abs(gradient(rows, found)[free]).max() < 1e-15 * (16 * stiffness + 1) * 3
    count = int(NEAR_AND_FAR[-1])
    bands = path_rows(np.full(count, stiffness), started=True)
    path = pinned_path(bands, NEAR_AND_FAR, gaps, np.full(len(gaps), np.inf))
    assert np.abs(path[NEAR_AND_FAR] - gaps).max() < 1e-12
    steps = np.diff(path, axis=0)
    pull = banded_product(bands, steps)  # is constant between pins, where only their forces act
    changes = np.delete(np.abs(np.diff(pull, axis=0)).max(axis=1), NEAR_AND_FAR[:-1] - 1)
    assert changes.max() < 1e-11 * np.abs(pull).max() + 1e-14


def gradient(rows, values):
    """(I + LᵀΛL) c by differences, frame by frame."""
    bent = np.zeros_like(values)
    bent[1:-1] = values[:-2] - 2 * values[1:-1] + values[2:]
    bent *= rows[:, None]
    back = np.zeros_like(values)
    back[:-2] += bent[1:-1]
    back[1:-1] -= 2 * bent[1:-1]
    back[2:] += bent[1:-1]
    return values + back


@pytest.mark.parametrize("stiffness", [1e6, 1e8])
def test_digits_at_large_stiffness(stiffness):
    """Against the same solve in extended precision; at λ = 10⁸ the system's condition leaves about eight digits between
    the pins, and all of them on the pins.
    """
    count, frames = 800, np.array([3, 4, 5, 6, 400, 790])
    gaps = np.random.default_rng(0).normal(size=(6, 1))
    rows = row_stiffness(stiffness, count)
    found = pinned_correction(rows, frames, gaps, np.full(6, np.inf))
    exact = refined(rows, frames, gaps)
    size = np.abs(exact).max()
    assert np.abs(found - exact).max() < 1e-16 * stiffness * size


def refined(rows, frames, gaps):
    """The pinned correction, improved with residuals in extended precision until nothing changes."""
    from kinestitch.solve.laplacian import normal_bands, solve_bands

    bands = eliminated(normal_bands(rows), frames)
    values = np.zeros((len(rows), 1), dtype=np.longdouble)
    values[frames] = gaps
    for _ in range(6):
        residual = -gradient(rows.astype(np.longdouble), values)
        residual[frames] = 0.0
        values = values + solve_bands(bands.copy(order="F"), residual.astype(np.float64))
    return values.astype(np.float64)


@settings(max_examples=30)
@given(st.integers(3, 30), st.data())
def test_elimination_and_product_in_bands(count, data):
    rng = np.random.default_rng(data.draw(st.integers(0, 99)))
    bands = rng.normal(size=(3, count))
    matrix = np.diag(bands[2]) + np.diag(bands[1, 1:], 1) + np.diag(bands[0, 2:], 2)
    matrix = matrix + np.triu(matrix, 1).T
    values = rng.normal(size=(count, 2))
    assert np.allclose(banded_product(bands, values), matrix @ values)
    fixed = rng.choice(count, data.draw(st.integers(0, count)), replace=False)
    expected = matrix.copy()
    expected[fixed], expected[:, fixed] = 0.0, 0.0
    expected[fixed, fixed] = 1.0
    assert np.allclose(banded_product(eliminated(bands, fixed), np.eye(count)), expected)


def test_the_nearest_pin_gives_its_value():
    found = nearest(9, np.array([1, 6]), np.array([5.0, 7.0]))
    assert found.tolist() == [5, 5, 5, 5, 7, 7, 7, 7, 7]
    assert nearest(3, np.array([1]), np.array([5.0])).tolist() == [5, 5, 5]
