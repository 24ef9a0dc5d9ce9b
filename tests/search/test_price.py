"""Prices before solving against prices after it, and the best cuts against brute force."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.core.components import join, split
from kinestitch.core.rotation import quat_about_axis, quat_multiply, quat_rotate, quat_to_rotvec
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.errors import ParameterError, RangeError
from kinestitch.samples import sample
from kinestitch.search.features import joint_weights, place_features, seam_factors
from kinestitch.search.price import best_cut, best_cuts, check_weights, exact_price, price_map, squared_distances
from kinestitch.solve.chart import chart_vectors
from kinestitch.solve.energy import cluster_energy, joint_price, joint_shares, seam_price
from kinestitch.solve.placed import place_timeline, straddling, target_window
from kinestitch.solve.seam import Cluster, SeamPlace, cluster_rows, clusters, correction
from kinestitch.solve.stitch import solve_timeline
from kinestitch.solve.window import chart_window
from kinestitch.testing import random_motion

SEEDS = st.integers(0, 2**32 - 1)


def pair(seed: int, **options: object):
    return tuple(random_motion(seed % 1000 + i, frames=30, bend=0.4, **options) for i in range(2))


def joined(a, b, pieces, stiffness: float) -> Timeline:
    infos = (ClipInfo("a", a.frames, a.fps), ClipInfo("b", b.frames, b.fps))
    segments = tuple(Segment(key, FrameRange(start, stop)) for key, start, stop in pieces)
    return Timeline(infos, segments, (Seam(stiffness),) * (len(segments) - 1), a.fps)


def solved_energy(solved) -> float:
    return float(solved_energies(solved).sum())


def solved_energies(solved) -> np.ndarray:
    """‖R − R_tar‖² + λ‖L R − δ_tar‖² of each joint (J,), read off a result whose seams share one window, with plain
    differences.
    """
    placed = solved.placed
    (cluster,) = clusters(solved.seams, placed.frames)
    target, _ = target_window(placed, cluster.start, cluster.stop)
    poses = np.stack([straddling(placed, seam).rotations for seam in cluster.seams])
    charted = chart_window(placed, cluster, target, poses, "centred")
    base = split(charted.base)[:, None]
    wanted = join(chart_vectors(base, split(target), charted.sign)[0])
    found = join(chart_vectors(base, split(solved.motion.rotations[cluster.start : cluster.stop]), charted.sign)[0])
    delta = np.diff(wanted, 2, axis=0)
    around = join(charted.straddling)  # (S, 4, J, 3)
    for (before, own_next, own_last, first), m in zip(around, cluster.local_frames, strict=True):
        if m >= 2:
            delta[m - 2] = wanted[m - 2] - 2 * before + own_next
        if m + 1 < len(wanted):
            delta[m - 1] = own_last - 2 * first + wanted[m + 1]
    rows = cluster_rows(cluster)[1:-1, None, None]
    bent = rows * (np.diff(found, 2, axis=0) - delta) ** 2
    return ((found - wanted) ** 2).sum(axis=(0, 2)) + bent.sum(axis=(0, 2))


@pytest.mark.parametrize("stiffness", [1.0, 81.0, 1296.0])
@pytest.mark.parametrize("pasted", [5, 20, 50])
def test_the_joint_price_is_the_energy_of_the_result(stiffness, pasted):
    clips = {"a": sample("walk"), "b": sample("kick")}
    pieces = [("a", 0, 84), ("b", 30, 30 + pasted), ("a", 130, 200)]
    solved = solve_timeline(joined(clips["a"], clips["b"], pieces, stiffness), clips)
    assert len(clusters(solved.seams, solved.placed.frames)) == 1
    assert joint_price(solved.placed) == pytest.approx(solved_energy(solved), rel=1e-9)
    np.testing.assert_allclose(joint_shares(solved.placed), solved_energies(solved), rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("stiffness", [1.0, 81.0, 1296.0])
def test_the_price_of_one_seam_is_the_energy_of_the_result(stiffness):
    clips = {"a": sample("walk"), "b": sample("kick")}
    prices = price_map(clips["a"], clips["b"], stiffness=stiffness)
    for out, into in ((90, 60), (3, 100), (201, 0)):
        pieces = [("a", 0, out), ("b", into, clips["b"].frames)]
        solved = solve_timeline(joined(clips["a"], clips["b"], pieces, stiffness), clips)
        price = exact_price(prices, pieces)
        assert price == pytest.approx(solved_energy(solved), rel=1e-9)
        assert price == pytest.approx(seam_price(solved.placed, solved.seams[0]), rel=1e-9)


@settings(max_examples=30)
@given(SEEDS, st.integers(20, 80), st.integers(20, 80), st.sampled_from([0.5, 3.0]))
def test_the_price_of_an_isolated_seam_is_the_energy_of_any_result(seed, out, into, stiffness):
    clips = dict(
        zip("ab", (random_motion(seed % 1000 + i, joints=5, frames=100, bend=1.0) for i in range(2)), strict=True)
    )
    solved = solve_timeline(joined(clips["a"], clips["b"], [("a", 0, out), ("b", into, 100)], stiffness), clips)
    assert seam_price(solved.placed, solved.seams[0]) == pytest.approx(solved_energy(solved), rel=1e-9)


def test_seams_farther_apart_than_their_windows_are_priced_one_by_one():
    clips = {"a": sample("walk"), "b": sample("kick")}
    for pasted, alone in ((100, True), (10, False)):
        line = joined(clips["a"], clips["b"], [("a", 0, 90), ("b", 30, 30 + pasted), ("a", 100, 201)], 1.0)
        placed = place_timeline(line, clips)
        apart = sum(seam_price(placed, seam) for seam in placed.seams)
        assert (joint_price(placed) == pytest.approx(apart, rel=1e-9)) == alone


@given(SEEDS, st.lists(st.integers(2, 12), min_size=2, max_size=4), st.sampled_from([0.5, 81.0, 1e4]))
def test_the_energy_of_a_cluster_is_that_of_its_correction(seed, lengths, stiffness):
    rng = np.random.default_rng(seed)
    ends = np.cumsum(lengths)
    places = tuple(SeamPlace(i, int(m), stiffness) for i, m in enumerate(ends[:-1]))
    if len(places) > 1:
        places = (*places[:-1], replace(places[-1], stiffness=0.0))
    cluster = Cluster(0, int(ends[-1]), places)
    offsets = rng.normal(size=(2 * len(places), 3))
    residual = np.zeros((cluster.frames, 3))
    for s, m in enumerate(cluster.local_frames):
        residual[m - 1] -= offsets[2 * s + 1]
        residual[m] += offsets[2 * s]
    change = correction(cluster, offsets)
    bent = np.diff(change, 2, axis=0)
    rows = cluster_rows(cluster)[1:-1, None]
    energy = (change**2).sum() + (rows * (bent - residual[1:-1]) ** 2).sum()
    assert cluster_energy(cluster, offsets) == pytest.approx(energy, rel=1e-7)


@pytest.mark.parametrize("names", [("walk", "kick"), ("run", "jump"), ("idle", "heavy_punch")])
def test_the_map_lies_within_two_percent_of_the_exact_price(names):
    a, b = map(sample, names)
    prices = price_map(a, b, stiffness=81.0, weights="even")
    rng = np.random.default_rng(0)
    off = []
    for _ in range(20):
        out, into = int(rng.integers(40, a.frames - 40)), int(rng.integers(40, b.frames - 40))
        off.append(prices.price(out, into) / exact_price(prices, [("a", 0, out), ("b", into, b.frames)]) - 1)
    assert np.median(np.abs(off)) < 0.005
    # Where a joint has to turn by almost half a turn the map may tell it the long way round; such cuts are never good.
    assert np.sort(np.abs(off))[-2] < 0.02
    assert min(off) > -0.02


@settings(max_examples=20)
@given(SEEDS)
def test_the_map_is_the_features_distance(seed):
    a, b = pair(seed)
    prices = price_map(a, b, stiffness=10.0, weights="even")
    slow = [[prices.price(i, j) for j in range(b.frames + 1)] for i in range(a.frames + 1)]
    np.testing.assert_allclose(prices.costs, slow, rtol=1e-9, atol=1e-9)


@settings(max_examples=20)
@given(SEEDS, st.sampled_from(["even", None]))
def test_the_best_cut_is_the_least_of_all(seed, weights):
    a, b = pair(seed)
    prices = price_map(a, b, stiffness=10.0, weights=weights)
    keep = prices.apart
    least = min((prices.costs[i, j], i, j) for i in range(keep, a.frames + 1) for j in range(b.frames - keep + 1))
    cut = best_cut(a, b, stiffness=10.0, weights=weights)
    assert (cut.cost, cut.out, cut.into) == least
    assert (cut.separable, cut.difference) == (
        prices.price(cut.out, cut.into),
        pytest.approx(cut.price / cut.separable - 1),
    )
    least = min((prices.costs[i, j], i, j) for i in range(1, a.frames + 1) for j in range(b.frames))
    cut = best_cut(a, b, outs=(1, a.frames), intos=(0, b.frames - 1), stiffness=10.0, weights=weights)
    assert (cut.cost, cut.out, cut.into) == least
    inside = min((prices.costs[i, j], i, j) for i in range(5, 9) for j in range(11, 21))
    cut = best_cut(a, b, outs=(5, 8), intos=(11, 20), stiffness=10.0, weights=weights)
    assert (cut.cost, cut.out, cut.into) == inside


def test_many_cuts_are_minima_and_apart():
    prices = price_map(sample("walk"), sample("kick"))
    cuts = best_cuts(prices, 8)
    assert len(cuts) == 8
    assert [c.cost for c in cuts] == sorted(c.cost for c in cuts)
    places = [(c.out, c.into) for c in cuts]
    for n, (i, j) in enumerate(places):
        first, last = prices.apart, prices.b.frames - prices.apart
        near = prices.costs[max(i - 1, first) : i + 2, max(j - 1, 0) : min(j + 2, last + 1)]
        assert prices.costs[i, j] == near.min()
        assert all(max(abs(i - k), abs(j - m)) >= prices.apart for k, m in places[:n])


def test_the_exact_order_is_that_of_a_longer_list():
    prices = price_map(sample("walk"), sample("kick"))
    ends = {"outs": (1, 12), "intos": (0, 150)}  # where few frames are left to bear a seam
    by_map, longer, exact = (best_cuts(prices, n, exact=e, apart=4, **ends) for n, e in ((5, 0), (20, 0), (5, 1)))
    assert len(by_map) == len(exact) == 5
    assert list(exact) == sorted(longer, key=lambda cut: cut.exact_cost)[:5]
    assert [c.out for c in exact] != [c.out for c in by_map]
    assert by_map == longer[:5]


@pytest.mark.parametrize("weights", ["even", None])
def test_the_exact_cost_has_the_exact_price_in_it(weights):
    prices = price_map(sample("run"), sample("jump"), weights=weights)
    for cut in best_cuts(prices, 3, outs=(3, 60)):
        pieces = [("a", 0, cut.out), ("b", cut.into, prices.b.frames)]
        clips = {"a": prices.a, "b": prices.b}
        energies = solved_energies(solve_timeline(joined(prices.a, prices.b, pieces, prices.stiffness), clips))
        each = np.ones(len(energies)) if weights == "even" else joint_weights(prices.a.skeleton)
        gap = (prices.first[cut.out] - prices.second[cut.into])[:-4].reshape(-1, 6)
        rest = cut.cost - each @ (gap**2).sum(axis=1)
        assert cut.exact_cost == pytest.approx(rest + each @ energies, rel=1e-9)
        if weights == "even":
            assert (cut.exact_cost, cut.cost) == (pytest.approx(cut.price), pytest.approx(cut.separable))


@given(SEEDS, st.floats(-3, 3))
def test_heading_and_place_cost_nothing(seed, yaw):
    a, b = pair(seed)
    turn = quat_about_axis(1, yaw)
    rotations, translations = b.rotations.copy(), b.translations.copy()
    rotations[:, 0] = quat_multiply(turn, rotations[:, 0])
    translations[:, 0] = quat_rotate(turn, translations[:, 0]) + np.array([3.0, 0.0, -2.0])
    moved = replace(b, rotations=rotations, translations=translations)
    for weights in ("even", None):
        costs = price_map(a, b, weights=weights).costs
        np.testing.assert_allclose(price_map(a, moved, weights=weights).costs, costs, rtol=1e-7, atol=1e-9)


def test_speed_of_the_root_counts_in_a_cost_alone():
    still = sample("idle")
    gliding = still.translations.copy()
    gliding[:, 0, 2] += np.linspace(0, 3, still.frames)
    gliding = replace(still, translations=gliding)
    assert price_map(still, gliding, weights="even").costs[50, 50] < 1e-9
    assert price_map(still, gliding).costs[50, 50] > 1e-3


def test_a_limb_that_turns_past_its_mean_has_no_jump_in_speed():
    a = random_motion(3, joints=4, frames=60)
    rotations = a.rotations.copy()
    rotations[:, 2] = quat_about_axis(0, np.linspace(0, 4 * np.pi, 60))
    spun = replace(a, rotations=rotations)
    features = place_features([spun, a], 10.0)[0][1:-1, 6 * 2 + 3 : 6 * 3]
    speed = np.sqrt(seam_factors(10.0)[1]) * np.linalg.norm(quat_to_rotvec(quat_about_axis(0, 4 * np.pi / 59)))
    assert np.linalg.norm(features, axis=-1).max() < 3 * speed


def test_weights():
    skeleton = sample("walk").skeleton
    weights = joint_weights(skeleton)
    by_name = {name.split(":")[-1]: weights[j] for j, name in enumerate(skeleton.names)}
    assert weights.mean() == pytest.approx(1.0)
    assert by_name["LeftUpLeg"] > by_name["LeftLeg"] > by_name["LeftFoot"] > 0
    assert by_name["LeftArm"] == by_name["RightArm"] > by_name["LeftForeArm"] > 4 * by_name["LeftHand"]
    assert check_weights(skeleton, "even") is None
    own = np.zeros(skeleton.joint_count)
    own[3] = 2.0
    a, b = sample("walk"), sample("kick")
    assert price_map(a, b, weights=own).costs.shape == (a.frames + 1, b.frames + 1)
    for wrong in ("odd", [1.0], -np.ones(skeleton.joint_count)):
        with pytest.raises(ParameterError, match="weight"):
            price_map(a, b, weights=wrong)


def test_joints_above_the_hips_are_not_priced():
    from kinestitch.rig.hips import hips_joint

    a, b = (replace_root(sample(name)) for name in ("walk", "kick"))
    assert hips_joint(a.skeleton) == 1
    prices = price_map(a, b, weights="even")
    plain = price_map(sample("walk"), sample("kick"), weights="even")
    np.testing.assert_allclose(prices.costs, plain.costs, rtol=1e-7, atol=1e-9)
    assert joint_weights(a.skeleton)[0] == 0.0


def replace_root(motion):
    """The motion below a joint that carries the travel."""
    from kinestitch.core.motion import Motion
    from kinestitch.core.skeleton import Skeleton

    old = motion.skeleton
    skeleton = Skeleton(
        ("Carrier", *old.names),
        (-1, *(parent + 1 for parent in old.parents)),
        np.vstack([np.zeros(3), old.offsets]),
        np.vstack([[0, 0, 0, 1.0], old.rest]),
        np.vstack([np.full(3, np.nan), old.tips]),
    )
    rotations = np.concatenate([np.tile([0, 0, 0, 1.0], (motion.frames, 1, 1)), motion.rotations], axis=1)
    travel = np.zeros((motion.frames, 1, 3))
    travel[:, 0, [0, 2]] = motion.translations[:, 0, [0, 2]]
    translations = np.concatenate([travel, motion.translations], axis=1)
    translations[:, 1, [0, 2]] = 0.0
    return Motion(skeleton, translations, rotations, motion.fps)


def test_squared_distances():
    rng = np.random.default_rng(0)
    p, q = rng.normal(size=(7, 5)), rng.normal(size=(4, 5))
    np.testing.assert_allclose(squared_distances(p, q), ((p[:, None] - q[None]) ** 2).sum(axis=-1), atol=1e-12)
    assert squared_distances(p, p).min() >= 0.0


def test_what_cannot_be_searched_is_refused():
    a, b = pair(0)
    with pytest.raises(ParameterError, match="λ > 0"):
        price_map(a, b, stiffness=0.0)
    for window in ((0, 3), (3, 31), (5, 4)):
        with pytest.raises(RangeError, match="places of the first clip"):
            best_cut(a, b, outs=window)


def test_clips_of_one_frame():
    a, b = random_motion(0, frames=1), random_motion(1, frames=1)
    cut = best_cut(a, b)
    assert (cut.out, cut.into) == (1, 0)
    assert np.isfinite(cut.cost)
