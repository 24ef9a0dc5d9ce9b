"""Quaternion paths as Euler angles that do not jump, so that what is drawn between two keys is what was meant."""

from __future__ import annotations

import numpy as np

from kinestitch.core.rotation import Array, quat_to_euler
from kinestitch.files.fbx.transform import order_name

_LOCK = 1e-6  # cosine of the middle angle below which first and third angle cannot be told apart

_WIDEST = 8192.0  # degrees; beyond, single precision errs by 0.0005° and a jump between two keys is the lesser evil


def continuous_degrees(q: Array, order: int = 0) -> Array:
    """FBX Euler angles (F, J, 3) in degrees, x y z whatever the order of rotation, of quaternions (F, J, 4).

    Each frame takes, of all angles that mean its rotation, those nearest to the frame before: the other solution with
    the middle angle past 90°, whole turns, and in gimbal lock any split between first and third angle. Paths that wind
    up past 20 turns jump after all.
    """
    name = order_name(order)
    angles = _unlocked(quat_to_euler(q, name)[..., ::-1], name)  # the one that turns first comes first
    other = np.stack([angles[..., 0] + np.pi, np.pi - angles[..., 1], angles[..., 2] + np.pi], axis=-1)
    # both solutions move on by the same amount, so one comparison a frame tells where to change over
    change = _gap(other[1:] - angles[:-1]) < _gap(angles[1:] - angles[:-1])
    changed = np.concatenate([np.zeros((1, *change.shape[1:]), dtype=bool), np.cumsum(change, axis=0) % 2 == 1])
    smooth = np.unwrap(np.where(changed[..., None], other, angles), axis=0)
    return _near_zero(np.degrees(smooth[..., [name[::-1].index(letter) for letter in "XYZ"]]))


def _gap(difference: Array) -> Array:
    """Sum of the three differences (..., 3) of angles, whole turns aside."""
    return np.abs(difference - 2 * np.pi * np.round(difference / (2 * np.pi))).sum(axis=-1)


def _unlocked(angles: Array, name: str) -> Array:
    """In gimbal lock only third ∓ first angle counts: keep the first of the last frame before it."""
    locked = np.abs(np.cos(angles[..., 1])) < _LOCK
    if not locked.any():
        return angles
    frame = np.arange(len(angles)).reshape(-1, *[1] * (angles.ndim - 2))
    last_free = np.maximum.accumulate(np.where(locked, 0, frame), axis=0)
    kept = np.take_along_axis(angles[..., 0], last_free, axis=0)
    out = angles.copy()
    out[..., 0] = np.where(locked, kept, angles[..., 0])
    side = 1.0 if name in {"ZYX", "YXZ", "XZY"} else -1.0
    out[..., 2] += side * np.sign(angles[..., 1]) * (out[..., 0] - angles[..., 0])
    return out


def _near_zero(degrees: Array) -> Array:
    """Whole turns taken off each angle, so that files' single precision does not cost digits."""
    low, high = degrees.min(axis=0), degrees.max(axis=0)
    centred = degrees - 360.0 * np.round((low + high) / 720.0)
    wound_up = high - low > _WIDEST
    return np.where(wound_up, (degrees + 180.0) % 360.0 - 180.0, centred)
