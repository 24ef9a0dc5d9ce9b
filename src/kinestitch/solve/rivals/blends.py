"""Blends: both sources mixed around a seam, or the gap between them spread along its shortest way."""

from __future__ import annotations

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_continuous,
    quat_log,
    quat_mean,
    quat_multiply,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.solve.placed import Placed, straddling, target_window
from kinestitch.solve.rivals.gap import check_width, rooms
from kinestitch.solve.seam import SeamPlace, clusters, seam_curves
from kinestitch.solve.solved import as_motion


def crossfade(placed: Placed, width: int, *, eased: bool = False) -> Motion:
    """Blend both sources over `width` frames on each side of every seam: rotations by slerp, translations linearly.

    eased : weights follow s²(3 − 2s) instead of s, so that the blend starts and ends without a kink

    Both sources run on under each other; one that ends holds its last pose. Windows end half way to the next seam. It
    passes through every pose in between, but it averages both motions and slides planted feet. Rotations take the way
    that is the shorter one at the seam and follow it through the window: chosen for each frame anew, the shorter way
    changes sides where both poses come to be half a turn apart, and the limb snaps round.

    Raises ParameterError for width < 1.
    """
    check_width(width)
    rotations, translations = target_window(placed, 0, placed.frames)
    for seam, before, after in rooms(placed):
        reach = max(1, min(width, before, after))
        frames = np.arange(-reach, reach)
        here = slice(seam.frame - reach, seam.frame + reach)
        share = (frames + reach + 0.5) / (2 * reach)
        if eased:
            share = share**2 * (3 - 2 * share)
        left = own_poses(placed, seam.index, placed.timeline.segments[seam.index].range.stop + frames)
        right = own_poses(placed, seam.index + 1, placed.timeline.segments[seam.index + 1].range.start + frames)
        relative = quat_continuous(quat_multiply(quat_conjugate(left[0]), right[0]))
        turned = relative[reach - 1 : reach + 1, :, 3].sum(axis=0) < 0
        way = quat_log(relative * np.where(turned, -1.0, 1.0)[:, None])
        rotations[here] = quat_multiply(left[0], rotvec_to_quat(share[:, None, None] * way))
        translations[here] = left[1] + share[:, None, None] * (right[1] - left[1])
    return as_motion(placed, rotations, translations)


def geodesic_blend(placed: Placed, seam: SeamPlace) -> tuple[int, Array]:
    """The mean gap of one seam spread along its shortest geodesic with the seam's own curve: what no chart can spin.

    Returns the first frame and the rotations (n, J, 4) of the window, carrier in the world: ``q exp(c)`` with
    ``c = (g₀ + g₁) d̄``, d̄ the principal log of the mean relative rotation of both sources at the seam.
    """
    (cluster,) = clusters([seam], placed.frames)
    rotations, _ = target_window(placed, cluster.start, cluster.stop)
    a, b = straddling(placed, seam).rotations.reshape(2, 2, -1, 4)
    gap = quat_to_rotvec(quat_mean(quat_multiply(quat_conjugate(a), b)))
    share = seam_curves(cluster).sum(axis=1)
    return cluster.start, quat_multiply(rotations, rotvec_to_quat(share[:, None, None] * gap))


def own_poses(placed: Placed, segment: int, frames: np.ndarray) -> tuple[Array, Array]:
    """A segment's source at its own frames, held at its ends, as placed: rotations (n, J, 4), translations (n, J,
    3).
    """
    source = placed.sources[placed.timeline.segments[segment].clip]
    frames = np.clip(frames, 0, source.frames - 1)
    rotations, translations = source.rotations[frames], source.translations[frames]
    placement, joint = placed.placements[segment], placed.carrier
    rotations[:, joint] = quat_multiply(placement.rotation, rotations[:, joint])
    translations[:, joint] = placement.move(translations[:, joint])
    return rotations, translations
