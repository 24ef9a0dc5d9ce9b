"""Quaternion paths as Euler angles that do not jump, so that what is drawn between two keys is what was meant."""

from __future__ import annotations

import numpy as np

from kinestitch.core.rotation import Array, quat_to_euler

_LOCK = 1e-6  # cosine of the middle angle below which first and third angle cannot be told apart

_WIDEST = 8192.0  # degrees; beyond, single precision errs by 0.0005° and a jump between two keys is the lesser evil


def continuous_degrees(q: Array) -> Array:
    """FBX Euler angles (F, J, 3) in degrees, x y z in the order XYZ, of quaternions (F, J, 4).

    Each frame takes, of all angles that mean its rotation, those nearest to the frame before: the other solution with
    the middle angle past 90°, whole turns, and in gimbal lock any split between first and third angle. Paths that wind
    up past 20 turns jump after all.
    """
    angles = quat_to_euler(q, "ZYX")[..., ::-1]  # x, y, z
    locked = np.abs(np.cos(angles[..., 1])) < _LOCK
    out = np.empty_like(angles)
    out[0] = angles[0]
    for frame in range(1, len(angles)):
        here, before = angles[frame], out[frame - 1]
        if locked[frame].any():
            here = _split_like(here, before, locked[frame])
        other = np.stack([here[:, 0] + np.pi, np.pi - here[:, 1], here[:, 2] + np.pi], axis=-1)
        both = np.stack([here, other])
        both -= 2 * np.pi * np.round((both - before) / (2 * np.pi))
        nearer = np.argmin(np.abs(both - before).sum(axis=-1), axis=0)
        out[frame] = np.take_along_axis(both, nearer[None, :, None], axis=0)[0]
    return _near_zero(np.degrees(out))


def _near_zero(degrees: Array) -> Array:
    """Whole turns taken off each angle, so that files' single precision does not cost digits."""
    low, high = degrees.min(axis=0), degrees.max(axis=0)
    centred = degrees - 360.0 * np.round((low + high) / 720.0)
    wound_up = high - low > _WIDEST
    return np.where(wound_up, (degrees + 180.0) % 360.0 - 180.0, centred)


def _split_like(here: Array, before: Array, locked: Array) -> Array:
    """Angles of locked joints with the x angle of the frame before; in lock only z ∓ x counts."""
    moved = here.copy()
    turn = before[:, 0] - here[:, 0]
    moved[:, 0] = before[:, 0]
    moved[:, 2] = here[:, 2] + np.sign(here[:, 1]) * turn
    return np.where(locked[:, None], moved, here)
