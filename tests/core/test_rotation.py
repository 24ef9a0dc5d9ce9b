"""Conversions of rotations, against SciPy's and each other; angles are ordinary, tiny, near π and beyond."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from kinestitch.core import rotation as kr
from kinestitch.errors import ParameterError
from kinestitch.testing import quaternions

TINY = [0.0, 5e-324, 1e-300, 1e-160, 1e-151, 1e-100, 1e-20, 1e-16, 1e-9, 1e-8, 1e-4]
AXES = np.array([[1.0, 0, 0], [0, -1, 0], [0, 0, 1], [0.6, 0, -0.8], [0.48, 0.6, 0.64]])


def close(actual: np.ndarray, expected: np.ndarray, *, atol: float, rtol: float = 0.0) -> None:
    np.testing.assert_allclose(actual, expected, atol=atol, rtol=rtol)


def many(seed: int = 0, shape: tuple[int, ...] = (500,)) -> np.ndarray:
    return kr.quat_normalize(np.random.default_rng(seed).normal(size=(*shape, 4)))


def vectors(angle: float) -> np.ndarray:
    return AXES * angle


@given(quaternions())
def test_matrix_and_vector_agree_with_scipy(q: np.ndarray):
    theirs = Rotation.from_quat(q)
    close(kr.quat_to_matrix(q), theirs.as_matrix(), atol=1e-14)
    back = Rotation.from_rotvec(kr.quat_to_rotvec(q))
    assert (back * theirs.inv()).magnitude() < 1e-14
    assert np.linalg.norm(kr.quat_to_rotvec(q)) <= np.pi + 1e-15
    assert (Rotation.from_quat(kr.matrix_to_quat(theirs.as_matrix())) * theirs.inv()).magnitude() < 1e-14


@given(quaternions())
def test_round_trips(q: np.ndarray):
    same = np.where(q[3:] < 0, -q, q)
    close(kr.rotvec_to_quat(kr.quat_log(q)), q, atol=2e-15)
    assert kr.quat_distance(kr.rotvec_to_quat(kr.quat_to_rotvec(q)), q) < 2e-15
    close(kr.rotvec_to_quat(kr.quat_to_rotvec(same)), same, atol=2e-15)
    assert kr.quat_distance(kr.matrix_to_quat(kr.quat_to_matrix(q)), q) < 2e-15
    assert kr.quat_distance(kr.rotvec_to_quat(kr.matrix_to_rotvec(kr.rotvec_to_matrix(kr.quat_log(q)))), q) < 4e-15


@pytest.mark.parametrize("angle", TINY)
def test_tiny_angles_keep_all_their_digits(angle: float):
    r = vectors(angle)
    back = kr.quat_log(kr.rotvec_to_quat(r))
    close(back, r, rtol=1e-15, atol=1e-323)
    close(kr.quat_to_rotvec(-kr.rotvec_to_quat(r)), r, rtol=1e-15, atol=1e-323)


@pytest.mark.parametrize("less", TINY)
def test_angles_near_pi(less: float):
    angle = np.pi - less
    q = kr.rotvec_to_quat(vectors(angle))
    close(kr.quat_log(q), vectors(angle), atol=2e-15)
    close(np.linalg.norm(kr.quat_to_rotvec(-q), axis=-1), angle, atol=2e-15)


@pytest.mark.parametrize("less", [*TINY, 0.5, 1.0, 2.0, 3.0])
def test_signed_logarithm_reaches_two_pi(less: float):
    angle = 2 * np.pi - less
    q = kr.rotvec_to_quat(vectors(angle))
    assert (q[:, 3] < 0).all()
    close(np.linalg.norm(kr.quat_log(q), axis=-1), angle, atol=2e-15)
    if less > 1e-8:
        close(kr.quat_log(q), vectors(angle), atol=1e-14 / less)
    close(kr.rotvec_to_quat(kr.quat_log(q)), q, atol=2e-15)


def test_minus_identity_has_a_full_turn():
    assert np.linalg.norm(kr.quat_log([0.0, 0.0, 0.0, -1.0])) == 2 * np.pi
    assert np.linalg.norm(kr.quat_log([-0.0, 1e-200, 0.0, -1.0])) == pytest.approx(2 * np.pi)
    np.testing.assert_array_equal(kr.quat_to_rotvec([0.0, 0.0, 0.0, -1.0]), 0.0)


def test_signed_logarithm_follows_a_turn_through_pi():
    angles = np.linspace(0.01, 2 * np.pi - 0.01, 400)
    q = kr.rotvec_to_quat(angles[:, None] * AXES[4])
    steps = np.linalg.norm(np.diff(kr.quat_log(q), axis=0), axis=-1)
    assert steps.max() < 0.02
    assert np.linalg.norm(np.diff(kr.quat_to_rotvec(q), axis=0), axis=-1).max() > 6


@pytest.mark.parametrize("turns", [3.0, 7.5, 40.0])
def test_long_vectors_turn_several_times(turns: float):
    r = AXES[3] * turns * 2
    expected = np.append(AXES[3] * np.sin(turns), np.cos(turns))
    close(kr.rotvec_to_quat(r), expected, atol=1e-14)


def test_products_of_few_and_of_many_are_the_same():
    p, q = many(1, (2000,)), many(2, (2000,))
    whole = kr.quat_multiply(p, q)
    theirs = (Rotation.from_quat(p) * Rotation.from_quat(q)).as_quat()
    close(whole * np.sign(whole[:, 3:]), theirs * np.sign(theirs[:, 3:]), atol=1e-15)
    close(np.stack([kr.quat_multiply(a, b) for a, b in zip(p[:50], q[:50], strict=True)]), whole[:50], atol=1e-15)
    close(kr.quat_multiply(p[:3, None], q[:5]), kr.quat_multiply(p[:3, None], q)[:, :5], atol=1e-15)


@pytest.mark.parametrize("order", kr.EULER_ORDERS)
@given(q=quaternions())
def test_euler_angles_agree_with_scipy(order: str, q: np.ndarray):
    angles = kr.quat_to_euler(q, order)
    assert kr.quat_distance(kr.euler_to_quat(angles, order), q) < 3e-12
    assert abs(angles[1]) <= np.pi / 2
    theirs = Rotation.from_euler(order, angles).as_quat()
    assert kr.quat_distance(kr.euler_to_quat(angles, order), theirs) < 2e-15


@pytest.mark.parametrize("order", kr.EULER_ORDERS)
@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("off", [0.0, *(10.0**-e for e in range(1, 17))])
def test_euler_angles_near_gimbal_lock(order: str, side: int, off: float):
    angles = np.random.default_rng(1).uniform(-np.pi, np.pi, (200, 3))
    angles[:, 1] = side * (np.pi / 2 - off)
    q = kr.euler_to_quat(angles, order)
    back = kr.quat_to_euler(q, order)
    assert kr.quat_distance(kr.euler_to_quat(back, order), q).max() < 3e-12
    if off == 0.0:
        assert (back[:, 2] == 0).all()
    elif off >= 1e-4:
        close(back, angles, atol=1e-14 / off**2)


def test_euler_angles_read_like_bvh_channels():
    z, x, y = 0.3, -0.4, 1.1
    product = kr.quat_multiply(
        kr.quat_multiply(kr.quat_about_axis(2, z), kr.quat_about_axis(0, x)), kr.quat_about_axis(1, y)
    )
    close(kr.euler_to_quat([z, x, y], "ZXY"), product, atol=1e-16)


@pytest.mark.parametrize("order", ["XYX", "xyz", "", "XY"])
def test_unknown_euler_orders_are_refused(order: str):
    with pytest.raises(ParameterError, match="Expected an Euler order"):
        kr.euler_to_quat([0.0, 0.0, 0.0], order)
    with pytest.raises(ParameterError, match="Expected an Euler order"):
        kr.quat_to_euler([0.0, 0.0, 0.0, 1.0], order)


@given(quaternions(), quaternions(), quaternions(), st.integers(0, 2**32 - 1))
def test_group_axioms(p: np.ndarray, q: np.ndarray, s: np.ndarray, seed: int):
    one = kr.quat_identity()
    close(kr.quat_multiply(kr.quat_multiply(p, q), s), kr.quat_multiply(p, kr.quat_multiply(q, s)), atol=2e-15)
    np.testing.assert_array_equal(kr.quat_multiply(p, one), p)
    np.testing.assert_array_equal(kr.quat_multiply(one, p), p)
    close(kr.quat_multiply(p, kr.quat_conjugate(p)), one, atol=1e-15)
    close(np.linalg.norm(kr.quat_multiply(p, q)), 1, atol=1e-15)
    v = np.random.default_rng(seed).normal(size=3)
    close(kr.quat_rotate(kr.quat_multiply(p, q), v), kr.quat_rotate(p, kr.quat_rotate(q, v)), atol=1e-14)
    close(kr.quat_rotate(p, v), kr.quat_to_matrix(p) @ v, atol=1e-14)
    close(kr.quat_to_matrix(kr.quat_multiply(p, q)), kr.quat_to_matrix(p) @ kr.quat_to_matrix(q), atol=1e-14)


@given(quaternions(), quaternions(), quaternions())
def test_distance_is_a_metric_that_ignores_signs_and_frames(p: np.ndarray, q: np.ndarray, s: np.ndarray):
    d = kr.quat_distance(p, q)
    assert 0 <= d <= np.pi
    assert kr.quat_distance(p, p) < 1e-15
    close(kr.quat_distance(q, p), d, atol=2e-15)
    close(kr.quat_distance(p, -q), d, atol=2e-15)
    close(kr.quat_distance(kr.quat_multiply(s, p), kr.quat_multiply(s, q)), d, atol=4e-15)
    close(kr.quat_distance(kr.quat_multiply(p, s), kr.quat_multiply(q, s)), d, atol=4e-15)
    assert kr.quat_distance(p, s) <= d + kr.quat_distance(q, s) + 1e-14
    close(d, (Rotation.from_quat(p).inv() * Rotation.from_quat(q)).magnitude(), atol=4e-15)


@given(quaternions(), quaternions(), st.floats(0, 1))
def test_slerp_walks_the_shorter_geodesic_evenly(p: np.ndarray, q: np.ndarray, t: float):
    d = kr.quat_distance(p, q)
    here = kr.quat_slerp(p, q, t)
    close(kr.quat_distance(p, here), t * d, atol=4e-15)
    close(kr.quat_distance(here, q), (1 - t) * d, atol=4e-15)
    assert kr.quat_distance(kr.quat_slerp(p, -q, t), here) < 4e-15 or d > np.pi - 1e-12


def test_slerp_takes_shares_of_any_shape():
    p, q = many(1, (5, 3)), many(2, (5, 3))
    share = np.linspace(-0.5, 1.5, 5)[:, None]
    out = kr.quat_slerp(p, q, share)
    assert out.shape == (5, 3, 4)
    close(out[4, 2], kr.quat_slerp(p[4, 2], q[4, 2], 1.5), atol=1e-15)
    close(kr.quat_distance(out[0], p[0]), kr.quat_distance(p[0], q[0]) / 2, atol=1e-14)


@given(quaternions(), quaternions(), st.floats(0, 0.3))
def test_mean_of_two_is_their_middle(p: np.ndarray, step: np.ndarray, size: float):
    q = kr.quat_multiply(p, kr.rotvec_to_quat(size * kr.quat_to_rotvec(step)))
    mean = kr.quat_mean(np.stack([p, -q]))
    assert kr.quat_distance(mean, kr.quat_slerp(p, q, 0.5)) < 1e-14
    assert mean[3] >= 0
    close(np.linalg.norm(mean), 1, atol=1e-15)


def test_mean_minimises_the_chordal_distance_and_takes_weights():
    q = kr.quat_multiply(many(3, (7,))[0], kr.rotvec_to_quat(np.random.default_rng(4).normal(scale=0.4, size=(7, 3))))
    weights = np.arange(1.0, 8.0)
    ours = kr.quat_mean(q, weights)
    theirs = Rotation.from_quat(q).mean(weights).as_quat()
    assert kr.quat_distance(ours, theirs) < 1e-14
    batch = kr.quat_mean(np.stack([q, q[::-1]], axis=1))
    assert batch.shape == (2, 4)
    assert kr.quat_distance(batch[0], batch[1]) < 1e-14


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e-15, 1e-12, 1e-9, 1e-7, 1e-4, 0.1, 1.0]), st.booleans())
def test_between_takes_one_direction_to_the_other(seed: int, off: float, opposite: bool):
    rng = np.random.default_rng(seed)
    u = kr.quat_rotate(kr.quat_normalize(rng.normal(size=4)), [1.0, 0.0, 0.0])
    side = np.cross(u, rng.normal(size=3))
    angle = np.pi - off if opposite else off
    v = u * np.cos(angle) + side / np.linalg.norm(side) * np.sin(angle)
    q = kr.quat_between(3.0 * u, 0.2 * v)
    close(kr.quat_rotate(q, u), v, atol=3e-8)
    if off == 0 or off > 1e-6:
        close(kr.quat_rotate(q, u), v, atol=1e-9)
    close(kr.quat_distance(q, kr.quat_identity()), angle, atol=3e-8)
    close(np.linalg.norm(q), 1, atol=1e-15)


def test_between_knows_axes_batches_and_nothing():
    u = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0, 0, 0]])
    q = kr.quat_between(u, -u)
    close(kr.quat_rotate(q, u), -u, atol=1e-15)
    assert kr.quat_between(u[:, None], u[:3]).shape == (4, 3, 4)
    np.testing.assert_array_equal(kr.quat_between([0.0, 0, 0], [0.0, 1, 0]), [0, 0, 0, 1])


def test_continuous_signs():
    angles = np.linspace(0, 4 * np.pi, 200)
    q = kr.rotvec_to_quat(angles[:, None, None] * AXES[:3])
    flipped = q * np.random.default_rng(0).choice([-1.0, 1.0], size=(200, 3, 1))
    flipped[0] = q[0]
    np.testing.assert_array_equal(kr.quat_continuous(flipped), q)
    np.testing.assert_array_equal(kr.quat_continuous(q[:1]), q[:1])


def test_normalize():
    np.testing.assert_array_equal(kr.quat_normalize([0, 0, 0, 0]), [0, 0, 0, 1])
    close(kr.quat_normalize([0, 3, 0, -4]), [0, 0.6, 0, -0.8], atol=1e-16)
    assert np.isnan(kr.quat_normalize([np.nan, 0, 0, 1])).any()


@pytest.mark.parametrize("shape", [(), (1,), (0,), (3,), (2, 3), (2, 1, 3)])
def test_every_conversion_takes_any_batch_axes(shape: tuple[int, ...]):
    q = many(5, shape)
    r, m, angles = kr.quat_log(q), kr.quat_to_matrix(q), kr.quat_to_euler(q, "ZXY")
    assert r.shape == (*shape, 3)
    assert m.shape == (*shape, 3, 3)
    assert angles.shape == (*shape, 3)
    flat = q.reshape(-1, 4)
    for got, one in ((r, kr.quat_log), (m, kr.quat_to_matrix), (angles, lambda p: kr.quat_to_euler(p, "ZXY"))):
        singly = [one(p) for p in flat]
        assert got.size == 0 or np.array_equal(got.reshape(np.stack(singly).shape), np.stack(singly))
    for back in (kr.rotvec_to_quat(r), kr.matrix_to_quat(m), kr.euler_to_quat(angles, "ZXY"), kr.quat_multiply(q, q)):
        assert back.shape == (*shape, 4)
    assert kr.quat_distance(q, q).shape == shape
    assert kr.quat_rotate(q, [1.0, 2.0, 3.0]).shape == (*shape, 3)
    assert kr.quat_multiply(q, kr.quat_identity()).shape == (*shape, 4)
    assert kr.quat_about_axis(1, np.zeros(shape)).shape == (*shape, 4)
