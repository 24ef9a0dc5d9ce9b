"""The two charts: where a limb may spin, what they depend on, and the form for joints that turn all the way."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from kinestitch.core.components import split
from kinestitch.core.rotation import quat_distance, quat_multiply, quat_normalize, quat_slerp, rotvec_to_quat
from kinestitch.errors import ParameterError
from kinestitch.solve.chart import (
    OVERTURN,
    Charted,
    centred_chart,
    chart_vectors,
    check_chart,
    mid_tangent,
    principal_chart,
    solve_rotations,
    unchart,
)
from kinestitch.solve.rotvecs import stitch_rotvecs
from kinestitch.solve.seam import Cluster, SeamPlace, clusters, seam_curves
from kinestitch.testing import quaternions

SEEDS = st.integers(0, 2**32 - 1)


def swings(seed: int, frames: int, joints: int, size: float, centre: np.ndarray | None = None) -> np.ndarray:
    """Rotation vectors (frames, joints, 3) that swing smoothly about `centre`, or about no turn at all."""
    rng = np.random.default_rng(seed)
    time = np.arange(frames)[:, None, None]
    waves = [rng.normal(size=(1, joints, 3)) * np.sin(0.1 * (k + 1) * time + rng.uniform(0, 6)) for k in range(3)]
    return size * sum(waves) / 3 + (0.0 if centre is None else centre)


def window(pieces: list[np.ndarray], stiffness: float) -> tuple[np.ndarray, np.ndarray, Cluster]:
    """Rotations, straddling poses and cluster of quaternion pieces (n_i + 2, J, 4) with their own neighbours."""
    rotations = np.concatenate([piece[1:-1] for piece in pieces])
    ends = np.cumsum([len(piece) - 2 for piece in pieces])[:-1]
    (cluster,) = clusters([SeamPlace(i, int(m), stiffness) for i, m in enumerate(ends)], len(rotations))
    assert (cluster.start, cluster.stop) == (0, len(rotations))
    around = [np.concatenate([a[-2:], b[:2]]) for a, b in pairwise(pieces)]
    return rotations, np.stack(around), cluster


def turning(seed: int, lengths: list[int], joints: int = 12, speed: float = 0.05) -> list[np.ndarray]:
    """Pieces whose joints turn steadily from random poses, hardly ever in the same direction."""
    rng = np.random.default_rng(seed)
    starts = quat_normalize(rng.normal(size=(len(lengths), 1, joints, 4)))
    steps = rng.normal(size=(len(lengths), 1, joints, 3)) * speed
    return [
        quat_multiply(start, rotvec_to_quat(step * np.arange(n + 2)[:, None, None]))
        for n, start, step in zip(lengths, starts, steps, strict=True)
    ]


def spin(quats: np.ndarray) -> np.ndarray:
    """Largest turn between neighbouring frames, in rad, of each joint."""
    return quat_distance(quats[1:], quats[:-1]).max(axis=0)


@given(quaternions(), quaternions(), st.sampled_from([-1.0, 1.0]))
def test_chart_vectors_lead_back(base: np.ndarray, q: np.ndarray, sign: float):
    vectors, used = chart_vectors(base, q, np.array(sign))
    np.testing.assert_allclose(np.stack(unchart(base, vectors, used)), q, rtol=0, atol=3e-15)
    principal, own = chart_vectors(base, q, None, principal=True)
    assert np.linalg.norm(principal) <= np.pi + 1e-15
    np.testing.assert_allclose(np.stack(unchart(base, principal, own)), q, rtol=0, atol=3e-15)


def test_unknown_charts_are_refused():
    with pytest.raises(ParameterError, match="centred, principal, got 'rodrigues'"):
        check_chart("rodrigues")
    with pytest.raises(ParameterError, match="Expected a chart"):
        stitch_rotvecs([np.zeros((5, 1, 3))] * 2, 1.0, chart="rodrigues")  # type: ignore[arg-type]


@pytest.mark.parametrize("bad", [-1.0, np.nan, np.inf, [1.0, -2.0], [1.0], [1.0, 1.0, 1.0]])
def test_impossible_stiffness_is_refused(bad: float):
    with pytest.raises(ParameterError, match="stiffness"):
        stitch_rotvecs([np.zeros((5, 1, 3))] * 3, bad)


def flip(r: np.ndarray) -> np.ndarray:
    """The same rotations told by the opposite axis: (2π − θ)(−u)."""
    angle = np.linalg.norm(r, axis=-1, keepdims=True)
    return -(2 * np.pi - angle) * r / angle


@pytest.mark.parametrize("stiffness", [1.0, 81.0, 1296.0])
@given(seed=SEEDS, lengths=st.lists(st.integers(1, 40), min_size=2, max_size=4))
def test_a_flipped_axis_changes_nothing_in_the_centred_chart(seed: int, lengths: list[int], stiffness: float):
    rng = np.random.default_rng(seed)
    pieces = [swings(seed + i, n + 2, 5, 0.5, rng.normal(size=(1, 5, 3))) for i, n in enumerate(lengths)]
    plain = stitch_rotvecs(pieces, stiffness)
    which = int(rng.integers(len(pieces)))
    flipped = [flip(piece) if i == which else piece for i, piece in enumerate(pieces)]
    assert quat_distance(stitch_rotvecs(flipped, stiffness), plain).max() < 1e-9


def test_a_flipped_axis_spins_in_the_principal_chart():
    centre = np.array([[1.0, 0.3, -0.4]])
    pieces = [swings(i, 62, 1, 0.2, centre) for i in range(3)]
    flipped = [pieces[0], flip(pieces[1]), pieces[2]]
    calm = spin(stitch_rotvecs(pieces, 81.0, chart="principal"))[0]
    wild = spin(stitch_rotvecs(flipped, 81.0, chart="principal"))[0]
    assert calm < 0.12
    assert wild > 0.6
    assert quat_distance(stitch_rotvecs(flipped, 81.0), stitch_rotvecs(pieces, 81.0)).max() < 1e-9


def test_limbs_that_rest_near_pi_spin_in_the_principal_chart_only():
    centre = np.array([[np.pi, 0.0, 0.0]])
    pieces = [rotvec_to_quat(swings(3 + i, 62, 1, 0.15, centre + 0.08 * (-1) ** i)) for i in range(2)]
    rotations, around, cluster = window(pieces, 81.0)
    curves = seam_curves(cluster)
    centred, principal = rotations.copy(), rotations.copy()
    solve_rotations(centred_chart(rotations, around, cluster.local_frames), cluster, curves, centred)
    solve_rotations(principal_chart(around, np.array([[0.0, 0, 0, 1]])), cluster, curves, principal)
    assert spin(centred)[0] < 0.12
    assert spin(principal)[0] > 0.5


@given(SEEDS, st.lists(st.integers(1, 30), min_size=2, max_size=4))
def test_the_centred_chart_ignores_signs_and_frames_of_reference(seed: int, lengths: list[int]):
    rng = np.random.default_rng(seed)
    pieces = [rotvec_to_quat(swings(seed + i, n + 2, 6, 0.8)) for i, n in enumerate(lengths)]
    rotations, around, cluster = window(pieces, 81.0)
    curves = seam_curves(cluster)

    def solved(turned: np.ndarray, poses: np.ndarray) -> np.ndarray:
        out = turned.copy()
        assert not len(solve_rotations(centred_chart(turned, poses, cluster.local_frames), cluster, curves, out))
        return out

    plain = solved(rotations, around)
    signs = rng.choice([-1.0, 1.0], size=rotations.shape[:2])[..., None]
    near = rng.choice([-1.0, 1.0], size=around.shape[:3])[..., None]
    for seam, m in enumerate(cluster.local_frames):  # a(m−1) and b(m) are frames of the window themselves
        near[seam, 0], near[seam, 3] = signs[m - 1], signs[m]
    assert quat_distance(solved(rotations * signs, around * near), plain).max() < 1e-12
    left, right = quat_normalize(rng.normal(size=(2, 6, 4)))
    turned = solved(quat_multiply(left, rotations), quat_multiply(left, around))
    assert quat_distance(turned, quat_multiply(left, plain)).max() < 1e-12
    turned = solved(quat_multiply(rotations, right), quat_multiply(around, right))
    assert quat_distance(turned, quat_multiply(plain, right)).max() < 1e-12


@pytest.mark.parametrize("chart", ["centred", "principal"])
@pytest.mark.parametrize("block", [1, 30, 100])
def test_it_does_not_matter_in_which_blocks_a_window_is_worked_on(chart: str, block: int, monkeypatch):
    rng = np.random.default_rng(block)
    pieces = [rotvec_to_quat(swings(i, n, 6, 1.5)) for i, n in enumerate((40, 9, 30))]
    rotations, around, cluster = window(pieces, 81.0)
    rotations[20:] *= rng.choice([-1.0, 1.0], size=(6, 1))  # a jump inside the first segment, and others at seams
    curves = seam_curves(cluster)

    def solved() -> np.ndarray:
        out = rotations.copy()
        charted = (
            centred_chart(rotations, around, cluster.local_frames)
            if chart == "centred"
            else principal_chart(around, np.array([[0.0, 0.0, 0.0, 1.0]] * 6))
        )
        solve_rotations(charted, cluster, curves, out)
        return out

    whole = solved()
    assert quat_distance(whole, rotations).max() > 0.1
    monkeypatch.setattr("kinestitch.solve.chart._BLOCK", block)
    np.testing.assert_allclose(solved(), whole, rtol=0, atol=2e-15)


@given(SEEDS)
def test_each_segment_takes_the_sign_of_its_own_seam_frames(seed: int):
    pieces = turning(seed, [10, 6, 10], speed=0.02)
    rotations, around, cluster = window(pieces, 81.0)
    charted = centred_chart(rotations, around, cluster.local_frames)
    sign = charted.sign if charted.sign is not None else np.ones(rotations.shape[:2])
    w = quat_multiply(charted.base * [-1, -1, -1, 1], rotations)[..., 3] * sign
    vectors = np.stack(chart_vectors(split(charted.base), split(rotations), sign)[0])
    for first, last in ((0, 10), (10, 16), (16, 26)):
        assert np.abs(np.diff(vectors[:, first:last], axis=1)).max() < 0.5
    assert (w[9] > -0.1).all()
    assert (w[16] > -0.1).all()


def joint_that_turns_all_the_way() -> list[np.ndarray]:
    """Two pieces about one axis: the left one comes from far round, the right one stands on the seam's other side."""
    left, right = np.zeros((2, 42, 1, 3))
    left[:, 0, 0] = np.linspace(-4.4, 0.0, 42)
    right[:, 0, 0] = 2.8 + np.linspace(0.0, 0.1, 42)
    return [rotvec_to_quat(left), rotvec_to_quat(right)]


def test_a_joint_that_overturns_is_named_and_solved_in_the_middle():
    rotations, around, cluster = window(joint_that_turns_all_the_way(), 1e4)
    charted = centred_chart(rotations, around, cluster.local_frames)
    curves = seam_curves(cluster)
    out = rotations.copy()
    assert list(solve_rotations(charted, cluster, curves, out)) == [0]
    vectors, _ = chart_vectors(split(charted.base), split(rotations), charted.sign)
    assert np.linalg.norm(vectors + curves @ charted.offsets, axis=0).max() > OVERTURN
    middle = mid_tangent(rotations, around, cluster, curves)
    sources = max(spin(rotations[:40])[0], spin(rotations[40:])[0])
    assert spin(middle)[0] < 2 * sources + 0.2
    np.testing.assert_allclose(np.linalg.norm(middle, axis=-1), 1, atol=1e-12)


@pytest.mark.parametrize("chart", ["centred", "principal"])
def test_only_the_centred_chart_asks_for_the_middle_form(chart: str):
    rotations, around, cluster = window(joint_that_turns_all_the_way(), 1e4)
    charted = (
        centred_chart(rotations, around, cluster.local_frames)
        if chart == "centred"
        else principal_chart(around, np.array([[0.0, 0.0, 0.0, 1.0]]))
    )
    overturned = solve_rotations(charted, cluster, seam_curves(cluster), rotations.copy())
    assert len(overturned) == (1 if chart == "centred" else 0)


@pytest.mark.parametrize("size", [1e-1, 1e-2, 1e-3])
def test_the_middle_form_meets_the_plain_one_in_the_limit(size: float):
    pieces = [rotvec_to_quat(swings(i, 32, 8, size)) for i in range(3)]
    rotations, around, cluster = window(pieces, 81.0)
    curves = seam_curves(cluster)
    plain = rotations.copy()
    solve_rotations(centred_chart(rotations, around, cluster.local_frames), cluster, curves, plain)
    middle = mid_tangent(rotations, around, cluster, curves)
    assert quat_distance(middle, plain).max() < size**2 * 2
    assert quat_distance(middle, rotations).max() > size * 0.05


@given(SEEDS, st.floats(0, 1e-6))
def test_the_middle_form_is_continuous(seed: int, nudge: float):
    pieces = turning(seed, [15, 8, 15])
    rotations, around, cluster = window(pieces, 81.0)
    relative = quat_multiply(around[:, :2] * [-1, -1, -1, 1], around[:, 2:])
    calm = (np.abs(relative[..., 3]) > 0.05).all(axis=(0, 1))  # at a gap of π either way round is as short
    curves = seam_curves(cluster)
    push = rotvec_to_quat(np.random.default_rng(seed).normal(size=(1, 12, 3)) * nudge)
    there = mid_tangent(rotations, around, cluster, curves)
    moved = mid_tangent(quat_multiply(rotations, push), quat_multiply(around, push), cluster, curves)
    assert quat_distance(there, moved)[:, calm].max(initial=0) < 20 * nudge + 1e-12


@given(SEEDS, st.lists(st.integers(1, 20), min_size=2, max_size=5))
def test_the_middle_form_commutes_with_time_reversal(seed: int, lengths: list[int]):
    pieces = turning(seed, lengths)
    rotations, around, cluster = window(pieces, 81.0)
    there = mid_tangent(rotations, around, cluster, seam_curves(cluster))
    rotations, around, cluster = window([piece[::-1] for piece in pieces[::-1]], 81.0)
    back = mid_tangent(rotations, around, cluster, seam_curves(cluster))[::-1]
    turned = quat_distance(there, back)
    assert np.median(turned) < 1e-12
    assert (turned < 1e-9).mean() > 0.95  # gaps of almost π may be closed the other way round


@pytest.mark.parametrize(
    ("lengths", "most"), [([20, 20], 0.13), ([20, 4, 20], 0.13), ([20, 10, 20], 0.13), ([20, 1, 1, 20], 0.16)]
)
def test_the_middle_form_closes_every_gap(lengths: list[int], most: float):
    steps, gaps = [], []
    for seed in range(30):
        rotations, around, cluster = window(turning(seed, lengths), 81.0)
        solved = mid_tangent(rotations, around, cluster, seam_curves(cluster))
        steps.append([quat_distance(solved[m - 1], solved[m]) for m in cluster.local_frames])
        gaps.append([quat_distance(rotations[m - 1], rotations[m]) for m in cluster.local_frames])
    left, before = np.concatenate(steps, axis=-1), np.concatenate(gaps, axis=-1)
    assert (left.max(axis=-1) < np.radians(60)).all()
    shares = np.median(left / before, axis=-1)  # about 12 % of each gap remains, as 1 / (2√2 λ^¼) says
    assert (shares < most).all()


def test_frames_far_from_an_overturned_seam_stay():
    pieces = turning(1, [80, 80])
    rotations, around, _ = window([piece[40:] if i == 0 else piece[:42] for i, piece in enumerate(pieces)], 1.0)
    far = np.concatenate([piece[1:-1] for piece in pieces])
    cluster = Cluster(0, 160, (SeamPlace(0, 80, 1.0),))
    solved = mid_tangent(far, around, cluster, seam_curves(cluster))
    turned = quat_distance(solved, far).max(axis=1)
    assert turned[:32].max() < 1e-11
    assert turned[128:].max() < 1e-11
    assert quat_distance(solved[79], quat_slerp(far[79], far[80], 0.5)).max() < 0.8
    assert isinstance(centred_chart(rotations, around, (40,)), Charted)
