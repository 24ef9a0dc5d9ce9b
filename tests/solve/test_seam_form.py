"""The seam form against dense least squares and against the closed figures that the method gives for it."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from solve_oracles import dense, energy, joined, laplacian, reach, rows_of

from kinestitch.solve.laplacian import row_stiffness, solve_full
from kinestitch.solve.seam import (
    Cluster,
    SeamPlace,
    cluster_rows,
    clusters,
    correction,
    displacement_correction,
    row_curves,
    seam_curves,
    seam_energy,
    seam_kernel,
    seam_reach,
    visible_reach,
)

SEEDS = st.integers(0, 2**32 - 1)
LAMBDAS = st.sampled_from([1e-4, 0.3, 1.0, 10.0, 81.0, 1000.0, 1296.0, 1e4])


def pieces_of(seed: int, lengths: list[int]) -> list[np.ndarray]:
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(n + 2, 2)) + np.cumsum(rng.normal(size=(n + 2, 2)), axis=0) * 0.1 for n in lengths]


def sparse(pieces: list[np.ndarray], stiffness: list[float]) -> np.ndarray:
    target, _ = joined(pieces)
    out = target.copy()
    ends = np.cumsum([len(piece) - 2 for piece in pieces])
    places = [SeamPlace(i, int(ends[i]), value) for i, value in enumerate(stiffness)]
    for cluster in clusters(places, len(target)):
        offsets = np.concatenate([pieces[s.index + 1][:2] - pieces[s.index][-2:] for s in cluster.seams])
        out[cluster.start : cluster.stop] += correction(cluster, offsets)
    return out


def middle(stiffness: float) -> tuple[Cluster, np.ndarray, int]:
    """A seam far from both ends, its curves on three times its window, and its frame there."""
    far = 3 * seam_reach(stiffness)
    place = SeamPlace(0, far, stiffness)
    wide = Cluster(0, 2 * far, (place,))
    return clusters([place], 2 * far)[0], seam_curves(wide), far


@given(SEEDS, st.lists(st.integers(1, 30), min_size=1, max_size=4), LAMBDAS)
def test_equals_dense_least_squares(seed: int, lengths: list[int], stiffness: float):
    pieces = pieces_of(seed, lengths)
    target, delta = joined(pieces)
    solved = sparse(pieces, [stiffness] * (len(pieces) - 1))
    if len(pieces) == 1:
        np.testing.assert_array_equal(solved, target)
    rows = row_stiffness(stiffness, len(target))
    np.testing.assert_allclose(solved, dense(target, delta, rows), rtol=0, atol=1e-9)
    np.testing.assert_allclose(solved, solve_full(target, delta, stiffness), rtol=0, atol=1e-9)


@given(SEEDS, st.integers(0, 12), st.integers(0, 12), st.sampled_from([1.0, 81.0, 1296.0]))
def test_equals_dense_least_squares_near_the_ends(seed: int, left: int, right: int, stiffness: float):
    pieces = pieces_of(seed, [1 + left, 1 + right])
    target, delta = joined(pieces)
    rows = row_stiffness(stiffness, len(target))
    np.testing.assert_allclose(sparse(pieces, [stiffness]), dense(target, delta, rows), rtol=0, atol=1e-9)


@given(SEEDS, st.lists(st.tuples(st.integers(1, 25), LAMBDAS), min_size=2, max_size=4), st.integers(1, 25))
def test_equals_dense_least_squares_with_a_stiffness_for_each_seam(
    seed: int, parts: list[tuple[int, float]], first: int
):
    pieces = pieces_of(seed, [first, *(n for n, _ in parts)])
    stiffness = [value for _, value in parts]
    target, delta = joined(pieces)
    ends = np.cumsum([len(piece) - 2 for piece in pieces])[:-1]
    if (
        len(
            clusters(
                [SeamPlace(i, int(m), s) for i, (m, s) in enumerate(zip(ends, stiffness, strict=True))], len(target)
            )
        )
        > 1
    ):
        return
    rows = rows_of(len(target), [(m - 0.5, s) for m, s in zip(ends, stiffness, strict=True)])
    np.testing.assert_allclose(sparse(pieces, stiffness), dense(target, delta, rows), rtol=0, atol=1e-9)


def test_seams_far_apart_are_solved_apart():
    pieces = pieces_of(3, [60, 140, 60])
    target, delta = joined(pieces)
    assert len(clusters([SeamPlace(0, 60, 1.0), SeamPlace(1, 200, 1.0)], 260)) == 2
    solved = sparse(pieces, [1.0, 1.0])
    np.testing.assert_allclose(solved, dense(target, delta, row_stiffness(1.0, 260)), rtol=0, atol=1e-11)
    np.testing.assert_array_equal(solved[:12], target[:12])
    np.testing.assert_array_equal(solved[108:152], target[108:152])
    np.testing.assert_array_equal(solved[248:], target[248:])


@pytest.mark.parametrize("frames", [1, 2])
def test_two_frames_have_no_second_difference(frames: int):
    pieces = pieces_of(1, [1] * frames)
    target, _ = joined(pieces)
    np.testing.assert_array_equal(sparse(pieces, [81.0] * (frames - 1)), target)


@pytest.mark.parametrize("stiffness", [1e-6, 1e-2, 1.0, 10.0, 81.0, 1296.0, 1e4, 1e6])
def test_the_curves_are_spent_where_the_window_ends(stiffness: float):
    cluster, curves, m = middle(stiffness)
    assert cluster.stop - m == m - cluster.start == seam_reach(stiffness) == reach(stiffness)
    outside = np.abs(np.concatenate([curves[: cluster.start], curves[cluster.stop :]]))
    assert outside.max() < 1e-12 * np.abs(curves).max()
    inside = curves[cluster.start : cluster.stop]
    np.testing.assert_allclose(
        seam_curves(cluster), inside, rtol=0, atol=1e-12 * np.abs(curves).max() * max(1, stiffness / 1e3)
    )


@pytest.mark.parametrize(("stiffness", "frames"), [(1.0, 4), (10.0, 7), (100.0, 13), (1e3, 23), (1e4, 42)])
def test_five_percent_after_the_visible_reach(stiffness: float, frames: int):
    _, curves, m = middle(stiffness)
    change = np.abs(curves.sum(axis=1))
    still = np.flatnonzero(change[m:] > 0.05 * change.max()).max() + 1
    assert still == pytest.approx(frames, abs=1.01)
    assert visible_reach(stiffness) in (frames, frames + 1)


@pytest.mark.parametrize("stiffness", [81.0, 100.0, 1296.0, 1e4])
def test_overshoot_and_the_step_that_remains(stiffness: float):
    _, curves, m = middle(stiffness)
    gap = curves.sum(axis=1)  # the answer to d_{m−1} = d_m = 1
    assert gap[m - 1] > 0 > gap[m]
    assert -gap[:m].min() == pytest.approx(0.033, abs=0.001)
    assert -gap[:m].min() / gap.max() == pytest.approx(0.07, abs=0.006)
    step = 1 + gap[m] - gap[m - 1]
    assert step == pytest.approx(1 / (2 * np.sqrt(2) * stiffness**0.25), rel=0.02)


@pytest.mark.parametrize(("stiffness", "share"), [(100.0, 0.26), (1e4, 0.22)])
def test_overshoot_of_a_velocity_gap(stiffness: float, share: float):
    _, curves, m = middle(stiffness)
    change = curves @ [-0.5, 0.5]
    peak = np.abs(change).max()
    lobe = np.sign(change[m])
    assert np.abs(change[np.sign(change) == -lobe]).max() / peak == pytest.approx(share, abs=0.02)


@pytest.mark.parametrize("stiffness", [81.0, 1296.0, 1e4])
def test_added_acceleration(stiffness: float):
    _, curves, m = middle(stiffness)
    L = laplacian(len(curves))

    def added(d: list[float]) -> float:
        e = np.zeros(len(curves))
        e[m - 1], e[m] = -d[1], d[0]
        return float(np.abs(L @ (curves @ d) - e).max())

    assert added([1.0, 1.0]) == pytest.approx(0.161 / np.sqrt(stiffness), rel=0.03)
    assert added([-0.5, 0.5]) == pytest.approx(0.354 / stiffness**0.25, rel=0.03)


def test_stiffness_goes_with_the_fourth_power_of_the_frame_rate():
    curves = {}
    for fps in (30, 60, 120):
        _, both, m = middle((0.1 * fps) ** 4)
        time = (np.arange(len(both)) - (m - 0.5)) / fps
        curves[fps] = (time, both.sum(axis=1), (both @ [-0.5, 0.5]) / fps)
    seconds = np.concatenate([np.linspace(-1, -0.05, 50), np.linspace(0.05, 1, 50)])
    for kind in (1, 2):
        slow, fast, faster = (np.interp(seconds, curves[fps][0], curves[fps][kind]) for fps in (30, 60, 120))
        peak = np.abs(faster).max()
        assert np.abs(slow - faster).max() < 0.04 * peak
        assert np.abs(fast - faster).max() < 0.012 * peak


@given(SEEDS, st.integers(1, 40), st.integers(1, 40), LAMBDAS)
def test_the_price_is_the_energy_that_the_solve_leaves(seed: int, left: int, right: int, stiffness: float):
    pieces = pieces_of(seed, [left, right])
    target, delta = joined(pieces)
    rows = row_stiffness(stiffness, len(target))
    solved = dense(target, delta, rows)
    offsets = pieces[1][:2] - pieces[0][-2:]
    price = seam_energy(SeamPlace(0, left, stiffness), len(target), offsets)
    np.testing.assert_allclose(price, energy(solved, target, delta, rows), rtol=1e-9, atol=1e-25)


@pytest.mark.parametrize("stiffness", [1.0, 81.0, 1296.0, 1e4, 1e6])
def test_the_price_is_a_distance_between_features(stiffness: float):
    """E* = ‖f_B − f_A‖² with a feature for every frame of a clip, so that the best cut is a nearest neighbour."""
    rng = np.random.default_rng(5)
    a, b = rng.normal(size=(2, 30, 6))
    far = 2 * seam_reach(stiffness)
    kernel = seam_kernel(row_stiffness(stiffness, 2 * far), far)
    alpha, beta = kernel[0]
    np.testing.assert_allclose(kernel, [[alpha, beta], [beta, alpha]], rtol=1e-9)

    def feature(clip: np.ndarray, k: int) -> np.ndarray:
        return np.concatenate(
            [
                np.sqrt(2 * (alpha - beta)) * (clip[k] + clip[k - 1]) / 2,
                np.sqrt((alpha + beta) / 2) * (clip[k] - clip[k - 1]),
            ]
        )

    for i, j in ((3, 7), (20, 1), (29, 29)):
        price = seam_energy(SeamPlace(0, far, stiffness), 2 * far, b[j - 1 : j + 1] - a[i - 1 : i + 1])
        np.testing.assert_allclose(price, ((feature(b, j) - feature(a, i)) ** 2).sum(), rtol=1e-8)


def test_the_price_is_about_a_mid_gap_and_a_velocity_gap():
    place, gap, velocity = SeamPlace(0, 500, 100.0), 0.7, 0.2
    offsets = np.array([[gap - velocity / 2], [gap + velocity / 2]])
    about = 100**0.25 / (2 * np.sqrt(2)) * (gap**2 + np.sqrt(100) * velocity**2)
    assert seam_energy(place, 1000, offsets) == pytest.approx(about, rel=0.013)


def test_the_kernel_keeps_its_digits_at_large_stiffness():
    price = seam_energy(SeamPlace(0, 150, 1e8), 300, np.ones((2, 1)))
    L = laplacian(300)[1:-1].astype(np.longdouble)
    e = np.zeros((298, 1), dtype=np.longdouble)
    e[148], e[149] = -1, 1
    matrix = np.eye(298, dtype=np.longdouble) / 1e8 + L @ L.T
    for i in range(298):  # elimination in long doubles, which LAPACK does not know
        below = slice(i + 1, min(298, i + 3))
        factors = matrix[below, i : i + 1] / matrix[i, i]
        matrix[below] -= factors * matrix[i]
        e[below] -= factors * e[i]
    solved = np.zeros_like(e)
    for i in reversed(range(298)):
        solved[i] = (e[i] - matrix[i, i + 1 :] @ solved[i + 1 :]) / matrix[i, i]
    right = np.zeros(298)
    right[148], right[149] = -1, 1
    assert price == pytest.approx(float(right @ solved[:, 0]), rel=1e-8)


def test_no_price_without_stiffness():
    assert seam_energy(SeamPlace(0, 5, 0.0), 10, np.ones((2, 3))) == 0.0
    assert seam_energy(SeamPlace(0, 1, 81.0), 2, np.ones((2, 3))) == 0.0


def test_clusters_group_overlapping_windows():
    a, b, c, d = SeamPlace(0, 50, 1.0), SeamPlace(1, 145, 1.0), SeamPlace(2, 241, 1.0), SeamPlace(3, 300, 0.0)
    assert seam_reach(1.0) == 48
    found = clusters([a, b, c, d], 1000)
    assert [(k.start, k.stop, k.seams) for k in found] == [(2, 193, (a, b)), (193, 289, (c,))]
    assert found[0].local_frames == (48, 143)
    assert clusters([a], 60)[0].stop == 60
    assert clusters([d], 1000) == ()
    assert clusters([c, SeamPlace(3, 280, 0.0)], 1000)[0].seams == (c, SeamPlace(3, 280, 0.0))
    wide = clusters([SeamPlace(0, 500, 1e4), SeamPlace(1, 520, 1.0)], 1000)
    assert [(k.start, k.stop) for k in wide] == [(92, 908)]


def test_rows_take_the_stiffness_of_the_nearest_seam_in_reaches():
    cluster = clusters([SeamPlace(0, 60, 1e4), SeamPlace(1, 100, 1.0)], 160)[0]
    rows = cluster_rows(cluster)
    assert rows[0] == rows[-1] == 0
    assert set(rows[1:-1]) == {1e4, 1.0}
    np.testing.assert_array_equal(rows, rows_of(160, [(59.5, 1e4), (99.5, 1.0)]))
    np.testing.assert_array_equal(np.flatnonzero(rows == 1.0), np.arange(95, 106))  # an island in the wide seam


@given(SEEDS, st.integers(2, 30), st.integers(2, 30), LAMBDAS)
def test_displacements_come_back_to_where_they_were(seed: int, left: int, right: int, stiffness: float):
    place = SeamPlace(0, left, stiffness)
    cluster = clusters([place], left + right)[0]
    moved = displacement_correction(cluster, np.random.default_rng(seed).normal(size=(3, 2)))
    np.testing.assert_array_equal(moved[0], 0)
    np.testing.assert_allclose(moved[-1], 0, atol=1e-10 * max(1.0, np.abs(moved).max()))


@given(SEEDS, st.integers(6, 14), st.sampled_from([(81.0,), (1.0, 81.0, 1e4), (0.0, 10.0, 1e3)]))
def test_many_seams_are_solved_as_few_are(seed: int, seams: int, stiffness: tuple[float, ...]):
    rng = np.random.default_rng(seed)
    frames = np.cumsum(rng.integers(5, 60, size=seams + 1))
    places = [SeamPlace(i, int(frames[i]), stiffness[i % len(stiffness)]) for i in range(seams)]
    for cluster in clusters(places, int(frames[-1])):
        offsets = rng.normal(size=(3, 2 * len(cluster.seams), 4))
        whole = seam_curves(cluster) @ offsets
        np.testing.assert_allclose(correction(cluster, offsets), whole, rtol=0, atol=1e-10)


@given(st.integers(1, 30), st.integers(1, 30), LAMBDAS)
def test_curves_run_backwards_in_reversed_time(left: int, right: int, stiffness: float):
    frames = left + right
    there = seam_curves(Cluster(0, frames, (SeamPlace(0, left, stiffness),)))
    back = seam_curves(Cluster(0, frames, (SeamPlace(0, right, stiffness),)))
    np.testing.assert_allclose(back[::-1], -there[:, ::-1], rtol=0, atol=1e-10)


def test_a_row_that_does_not_exist_moves_nothing():
    rows = row_stiffness(81.0, 10)
    curves = row_curves(rows, [-1, 0, 4, 9, 10])
    assert not curves[:, [0, 1, 3, 4]].any()
    assert curves[:, 2].any()
