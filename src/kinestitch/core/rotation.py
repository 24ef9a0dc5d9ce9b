"""Rotations in space: quaternions, matrices, rotation vectors and Euler angles, with any batch axes.

Quaternions are ``(x, y, z, w)``, unit norm, active, right-handed; ``q`` and ``-q`` are the same rotation. Angles are
radians. `a_to_b` converts a representation. Two logarithms exist and the difference matters: :func:`quat_to_rotvec`
is the principal one (angle in [0, π]), :func:`quat_log` keeps the sign of ``w`` (angle in [0, 2π)), which is what
makes a path of hemisphere-continuous quaternions a continuous path of vectors.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from kinestitch.core.components import exp, join, log, multiply, split
from kinestitch.errors import ParameterError

Array = NDArray[np.float64]

_FEW = 2048  # numbers; up to so many, one matrix product with a table is quicker than many small steps
_HAMILTON = join(multiply(np.eye(4)[:, :, None], np.eye(4)[:, None, :])).reshape(16, 4)
"""Row 4 i + j holds the product of the quaternions' units i and j."""

EULER_ORDERS = ("XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX")


def quat_identity(shape: tuple[int, ...] = ()) -> Array:
    """Identity quaternions of shape ``(*shape, 4)``."""
    q = np.zeros((*shape, 4))
    q[..., 3] = 1.0
    return q


def quat_normalize(q: ArrayLike) -> Array:
    """Scale quaternions ``(..., 4)`` to unit norm; an all-zero one becomes the identity."""
    q = np.asarray(q, dtype=np.float64)
    norm = np.linalg.norm(q, axis=-1, keepdims=True)
    out = q / np.where(norm > 0, norm, 1.0)
    out[..., 3] = np.where(norm[..., 0] > 0, out[..., 3], 1.0)
    return out


def quat_conjugate(q: ArrayLike) -> Array:
    """Inverse of unit quaternions ``(..., 4)``."""
    return np.asarray(q, dtype=np.float64) * np.array([-1.0, -1.0, -1.0, 1.0])


def quat_multiply(p: ArrayLike, q: ArrayLike) -> Array:
    """Hamilton product ``p q`` of ``(..., 4)`` and ``(..., 4)``: rotate by `q` first, then by `p`."""
    p, q = np.asarray(p, dtype=np.float64), np.asarray(q, dtype=np.float64)
    if p.size + q.size <= _FEW:
        products = p[..., :, None] * q[..., None, :]
        return np.asarray(products.reshape(*products.shape[:-2], 16) @ _HAMILTON)
    return join(multiply(split(p), split(q)))


def quat_rotate(q: ArrayLike, v: ArrayLike) -> Array:
    """Rotate vectors ``v`` (..., 3) by unit quaternions ``q`` (..., 4)."""
    q = np.asarray(q, dtype=np.float64)
    v = np.asarray(v, dtype=np.float64)
    u, w = q[..., :3], q[..., 3:]
    t = 2.0 * np.cross(u, v)
    return v + w * t + np.cross(u, t)


def quat_to_matrix(q: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of unit quaternions (..., 4)."""
    q = np.asarray(q, dtype=np.float64)
    x, y, z, w = q[..., 0], q[..., 1], q[..., 2], q[..., 3]
    m = np.empty((*q.shape[:-1], 3, 3))
    m[..., 0, 0] = 1 - 2 * (y * y + z * z)
    m[..., 0, 1] = 2 * (x * y - z * w)
    m[..., 0, 2] = 2 * (x * z + y * w)
    m[..., 1, 0] = 2 * (x * y + z * w)
    m[..., 1, 1] = 1 - 2 * (x * x + z * z)
    m[..., 1, 2] = 2 * (y * z - x * w)
    m[..., 2, 0] = 2 * (x * z - y * w)
    m[..., 2, 1] = 2 * (y * z + x * w)
    m[..., 2, 2] = 1 - 2 * (x * x + y * y)
    return m


def matrix_to_quat(m: ArrayLike) -> Array:
    """Unit quaternions (..., 4), ``w ≥ 0``, of rotation matrices (..., 3, 3); the largest component is the pivot."""
    m = np.asarray(m, dtype=np.float64)
    xx, yy, zz = m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]
    four = np.stack([1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz, 1 + xx + yy + zz], axis=-1)
    xy, xz, yz = m[..., 0, 1] + m[..., 1, 0], m[..., 0, 2] + m[..., 2, 0], m[..., 1, 2] + m[..., 2, 1]
    wx, wy, wz = m[..., 2, 1] - m[..., 1, 2], m[..., 0, 2] - m[..., 2, 0], m[..., 1, 0] - m[..., 0, 1]
    rows = np.stack(
        [
            np.stack([four[..., 0], xy, xz, wx], axis=-1),
            np.stack([xy, four[..., 1], yz, wy], axis=-1),
            np.stack([xz, yz, four[..., 2], wz], axis=-1),
            np.stack([wx, wy, wz, four[..., 3]], axis=-1),
        ],
        axis=-2,
    )
    pivot = np.argmax(four, axis=-1)
    q = quat_normalize(np.take_along_axis(rows, pivot[..., None, None], axis=-2)[..., 0, :])
    return np.where(q[..., 3:] < 0, -q, q)


def quat_log(q: ArrayLike) -> Array:
    """Rotation vectors (..., 3) with angle ``2 atan2(‖v‖, w)`` in [0, 2π]: the sign of `w` is kept (Eq. 2)."""
    return join(log(split(np.asarray(q, dtype=np.float64))))


def quat_to_rotvec(q: ArrayLike) -> Array:
    """Principal rotation vectors (..., 3), angle in [0, π], of unit quaternions (..., 4) (Eq. 1)."""
    q = np.asarray(q, dtype=np.float64)
    return quat_log(np.where(q[..., 3:] < 0, -q, q))


def rotvec_to_quat(r: ArrayLike) -> Array:
    """Unit quaternions (..., 4) of rotation vectors (..., 3) of any length; ``w = cos(θ/2)`` keeps its sign (Eq. 1)."""
    return join(exp(split(np.asarray(r, dtype=np.float64))))


def matrix_to_rotvec(m: ArrayLike) -> Array:
    """Principal rotation vectors (..., 3) of rotation matrices (..., 3, 3)."""
    return quat_to_rotvec(matrix_to_quat(m))


def rotvec_to_matrix(r: ArrayLike) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3)."""
    return quat_to_matrix(rotvec_to_quat(r))


def quat_about_axis(axis: int, angle: ArrayLike) -> Array:
    """Quaternions (..., 4) that turn by `angle` (...,) rad about coordinate axis 0, 1 or 2."""
    angle = np.asarray(angle, dtype=np.float64)
    q = np.zeros((*angle.shape, 4))
    q[..., axis] = np.sin(angle / 2)
    q[..., 3] = np.cos(angle / 2)
    return q


def _check_order(order: str) -> None:
    if order not in EULER_ORDERS:
        raise ParameterError(f"Expected an Euler order out of {', '.join(EULER_ORDERS)}, got {order!r}.")


def euler_to_quat(angles: ArrayLike, order: str) -> Array:
    """Quaternions (..., 4) of Euler angles (..., 3) rad.

    ``order`` reads like BVH channels: ``"ZXY"`` with angles ``(z, x, y)`` is the product ``Rz Rx Ry`` (rotating axes).
    FBX's eEulerXYZ, which applies X first about fixed axes, is order ``"ZYX"`` with the angles reversed.
    """
    _check_order(order)
    angles = np.asarray(angles, dtype=np.float64)
    i, j, k = ("XYZ".index(letter) for letter in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    half = np.multiply(np.moveaxis(angles, -1, 0), 0.5, order="C")
    (sa, sb, sc), (ca, cb, cc) = np.sin(half), np.cos(half)
    sc = sign * sc
    q = np.empty((*angles.shape[:-1], 4))
    q[..., i] = sa * (cb * cc) + ca * (sb * sc)
    q[..., j] = ca * (sb * cc) - sa * (cb * sc)
    q[..., k] = sign * (ca * (cb * sc) + sa * (sb * cc))
    q[..., 3] = ca * (cb * cc) - sa * (sb * sc)
    return q


def quat_to_euler(q: ArrayLike, order: str) -> Array:
    """Euler angles (..., 3) rad in the given order (see :func:`euler_to_quat`); the middle one lies in [-π/2, π/2].

    In gimbal lock the third angle is 0 and the first carries the whole turn.
    """
    _check_order(order)
    m = quat_to_matrix(q)
    i, j, k = ("XYZ".index(letter) for letter in order)
    sign = 1.0 if (j - i) % 3 == 1 else -1.0
    cosine = np.hypot(m[..., j, k], m[..., k, k])
    middle = np.arctan2(sign * m[..., i, k], cosine)
    locked = cosine < 1e-12
    first = np.where(
        locked,
        np.arctan2(sign * m[..., k, j], m[..., j, j]),
        np.arctan2(-sign * m[..., j, k], m[..., k, k]),
    )
    # The third angle undoes what the first has left over, so that near the lock, where each of the two is uncertain,
    # their sum is not.
    sine, cosine = np.sin(first), np.cos(first)
    third = np.arctan2(
        sign * cosine * m[..., j, i] + sine * m[..., k, i], cosine * m[..., j, j] + sign * sine * m[..., k, j]
    )
    return np.stack([first, middle, np.where(locked, 0.0, third)], axis=-1)


def quat_distance(p: ArrayLike, q: ArrayLike) -> Array:
    """Geodesic distance (...,) in rad, in [0, π], between unit quaternions."""
    d = quat_multiply(quat_conjugate(p), q)
    return 2.0 * np.arctan2(np.linalg.norm(d[..., :3], axis=-1), np.abs(d[..., 3]))


def quat_slerp(p: ArrayLike, q: ArrayLike, t: ArrayLike) -> Array:
    """Point at share `t` (...,) of the shorter geodesic from `p` to `q` (..., 4); t may leave [0, 1]."""
    p = np.asarray(p, dtype=np.float64)
    step = quat_to_rotvec(quat_multiply(quat_conjugate(p), q))
    return quat_multiply(p, rotvec_to_quat(np.asarray(t, dtype=np.float64)[..., None] * step))


def quat_continuous(q: ArrayLike) -> Array:
    """Flip signs along axis 0 of (F, ..., 4) so that neighbours lie in one hemisphere; the first frame keeps its
    sign.
    """
    q = np.asarray(q, dtype=np.float64)
    flips = np.where(np.einsum("...i,...i->...", q[1:], q[:-1]) < 0, -1.0, 1.0)
    out = q.copy()
    out[1:] *= np.cumprod(flips, axis=0)[..., None]
    return out


def quat_mean(q: ArrayLike, weights: ArrayLike | None = None) -> Array:
    """Mean rotation of (N, ..., 4) over axis 0, blind to signs: the top eigenvector of ``Σ w q qᵀ``, ``w ≥ 0``
    component.
    """
    q = np.asarray(q, dtype=np.float64)
    scaled = q if weights is None else q * np.asarray(weights, dtype=np.float64).reshape(-1, *([1] * (q.ndim - 1)))
    vectors = np.linalg.eigh(np.einsum("n...i,n...j->...ij", scaled, q))[1][..., -1]
    return np.where(vectors[..., 3:] < 0, -vectors, vectors)


def quat_between(u: ArrayLike, v: ArrayLike) -> Array:
    """Shortest rotation (..., 4) that takes the direction of `u` (..., 3) to that of `v`; opposite ones turn by π."""
    u = np.asarray(u, dtype=np.float64)
    v = np.asarray(v, dtype=np.float64)
    u, v = np.broadcast_arrays(_direction(u), _direction(v))
    sine = np.linalg.norm(u - v, axis=-1) / 2  # of half the angle; its cosine from the sum keeps digits near π
    cosine = np.linalg.norm(u + v, axis=-1) / 2
    axis = np.cross(u, v)
    opposite = cosine < 1e-8
    if np.any(opposite):
        helper = np.where(np.abs(u[..., :1]) < 0.9, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
        axis = np.where(opposite[..., None], np.cross(u, helper), axis)
    return quat_normalize(np.concatenate([_direction(axis) * sine[..., None], cosine[..., None]], axis=-1))


def _direction(v: Array) -> Array:
    size = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.asarray(v / np.where(size > 0, size, 1.0))
