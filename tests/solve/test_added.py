"""What a seam adds, in closed form, against dense least squares and against the whole solve."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from solve_oracles import cast, dense, laplacian, line

from kinestitch.edit.timeline import Seam
from kinestitch.rig.carrier import world_of
from kinestitch.solve.added import Gap, added_to_path, added_turning, seam_gap
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.sources import own_velocities
from kinestitch.solve.stitch import solve_placed

SEEDS = st.integers(0, 2**32 - 1)
FPS = 30.0
RISING = np.geomspace(0.3, 12.0, 24) ** 4


def gap_of(offsets: np.ndarray, before: int, after: int) -> Gap:
    """A seam whose rows d_{m−1}, d_m are (2, J, 3) rad, and whose path needs nothing."""
    first, second = offsets
    products = np.stack([(a * b).sum(axis=-1) for a, b in ((first, first), (first, second), (second, second))])
    return Gap(products, np.zeros(9), before, after, FPS)


def solved(offsets: np.ndarray, before: int, after: int, stiffness: float) -> tuple[np.ndarray, np.ndarray]:
    """The correction c and the residual L c − e, (F, J, 3), by dense least squares over all frames."""
    frames = before + after
    e = np.zeros((frames, offsets[0].size))
    e[before - 1], e[before] = -offsets[1].ravel(), offsets[0].ravel()
    e[[0, -1]] = 0.0
    c = dense(np.zeros_like(e), e, np.full(frames, stiffness))
    bent = laplacian(frames) @ c - e
    return c.reshape(frames, -1, 3), bent.reshape(frames, -1, 3)


@given(SEEDS, st.integers(1, 40), st.integers(1, 40), st.sampled_from([0.5, 10.0, 81.0, 1296.0]))
def test_turning_equals_dense_least_squares(seed: int, before: int, after: int, stiffness: float):
    offsets = np.random.default_rng(seed).normal(size=(2, 3, 3))
    c, bent = solved(offsets, before, after, stiffness)
    steps = np.diff(c, axis=0)
    at_seam = [np.linalg.norm(steps[before - 1] + d, axis=-1) for d in offsets]
    speeds = np.linalg.norm(steps, axis=-1)
    speeds[before - 1] = np.minimum(*at_seam)
    acceleration, velocity = added_turning(gap_of(offsets, before, after), stiffness)
    np.testing.assert_allclose(acceleration, np.linalg.norm(bent, axis=-1).max(axis=0) * FPS**2, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(velocity, speeds.max(axis=0) * FPS, rtol=1e-6, atol=1e-6)


def test_a_few_joints_are_told_like_all_of_them():
    gap = gap_of(np.random.default_rng(1).normal(size=(2, 5, 3)), 30, 30)
    every, some = added_turning(gap, 81.0), added_turning(gap, 81.0, [1, 4])
    for a, b in zip(every, some, strict=True):
        np.testing.assert_allclose(a[[1, 4]], b, rtol=1e-12)


@pytest.mark.parametrize("stiffness", [1e3, 1e4, 1e5])
def test_the_laws_of_large_stiffness(stiffness: float):
    far = 400
    place = gap_of(np.ones((2, 1, 1)) * [1.0, 0.0, 0.0], far, far)
    speed = gap_of(np.array([-0.5, 0.5])[:, None, None] * [1.0, 0.0, 0.0], far, far)
    unit = FPS**2
    assert added_turning(place, stiffness)[0][0] == pytest.approx(0.161 / np.sqrt(stiffness) * unit, rel=0.03)
    assert added_turning(speed, stiffness)[0][0] == pytest.approx(0.354 / stiffness**0.25 * unit, rel=0.03)


@given(SEEDS, st.integers(1, 60), st.integers(1, 60))
def test_more_stiffness_adds_less_and_deviates_more(seed: int, before: int, after: int):
    offsets = np.random.default_rng(seed).normal(size=(2, 1, 3))
    sizes = [[np.linalg.norm(x) for x in solved(offsets, before, after, value)] for value in RISING[::3]]
    deviation, added = np.transpose(sizes)
    assert (np.diff(deviation) >= -1e-9).all()
    assert (np.diff(added) <= 1e-9).all()


@given(SEEDS)
def test_the_peaks_of_one_seam_far_from_the_ends_fall_too(seed: int):
    gap = gap_of(np.random.default_rng(seed).normal(size=(2, 4, 3)), 500, 500)
    peaks = np.array([added_turning(gap, value)[0] for value in RISING])
    assert (np.diff(peaks, axis=0) <= 1e-9 * peaks[:-1]).all()


@pytest.mark.parametrize(
    "parts", [[("a", 0, 30), ("b", 20, 60)], [("a", 0, 2), ("b", 20, 60)], [("a", 0, 30), ("b", 0, 2)]]
)
@pytest.mark.parametrize("stiffness", [1.0, 81.0, 1e3])
def test_the_path_equals_that_of_the_whole_solve(parts: list[tuple[str, int, int]], stiffness: float):
    clips = cast(2, frames=60)
    placed = place_timeline(line(parts, clips, Seam(stiffness=stiffness)), clips)
    (seam,) = placed.seams
    motion = solve_placed(placed)
    into, out = own_velocities(placed, 1, placed.frames - 1)[2]
    own = (out - into) * placed.timeline.fps
    path, _ = world_of(motion, placed.carrier)
    result = np.diff(path, n=2, axis=0) * motion.fps**2
    # the velocity that a source has by itself turns with the body: placed, it is compared as a vector
    expected = float(np.linalg.norm(result - own, axis=-1).max())
    assert added_to_path(seam_gap(placed, seam), stiffness) == pytest.approx(expected, rel=1e-6)


def test_nothing_to_close_adds_nothing():
    clips = cast(1, frames=60)
    clips["b"] = replace(clips["a"], name="b")
    placed = place_timeline(line([("a", 0, 30), ("b", 30, 60)], clips), clips)
    gap = seam_gap(placed, placed.seams[0])
    assert max(value.max() for value in added_turning(gap, 81.0)) < 1e-6
    assert added_to_path(gap, 81.0) < 1e-6
