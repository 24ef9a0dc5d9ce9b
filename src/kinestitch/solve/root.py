"""Where the body goes: each segment is turned and moved so that it continues the one before it, and its path is joined.

Placement gives every segment one yaw and one ground shift (Eq. 14). The ground path is then solved on its
displacements, which live on the intervals between frames, in the world's axes; the correction sums to zero, so that
away from the seam the path is exactly the rigidly placed one (Eq. 15). No heading is ever extracted from one pose:
every heading function is singular somewhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array, quat_about_axis, quat_conjugate, quat_multiply, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.hips import hip_line, hips_joint

GROUND = (0, 2)
_FLAT = 0.1


@dataclass(frozen=True, slots=True)
class Placement:
    """A rigid move on the ground: turn by `yaw` rad about the world's Y axis, then shift by (x, z) m."""

    yaw: float = 0.0
    x: float = 0.0
    z: float = 0.0

    @property
    def rotation(self) -> Array:
        """The yaw as a quaternion (4,)."""
        return quat_about_axis(1, self.yaw)

    def rotate(self, vectors: Array) -> Array:
        """Vectors (..., 3) turned by the yaw."""
        cosine, sine = np.cos(self.yaw), np.sin(self.yaw)
        out = np.array(vectors, dtype=np.float64)
        out[..., 0] = cosine * vectors[..., 0] + sine * vectors[..., 2]
        out[..., 2] = cosine * vectors[..., 2] - sine * vectors[..., 0]
        return out

    def move(self, points: Array) -> Array:
        """Points (..., 3) m turned and shifted."""
        out = self.rotate(points)
        out[..., 0] += self.x
        out[..., 2] += self.z
        return out


def world_rotation(skeleton: Skeleton, carrier: int, joint: int, rotations: Array) -> Array:
    """World rotation (..., 4) of a joint below the carrier, from rotations (..., J, 4) whose carrier is told in the
    world.
    """
    chain = skeleton.chain(joint)
    return chain_rotation(chain[chain.index(carrier) :] if carrier in chain else (carrier,), rotations)


def chain_rotation(way: Sequence[int], rotations: Array) -> Array:
    """Product (..., 4) of the rotations (..., J, 4) of some joints, each below the one before it."""
    out = rotations[..., way[0], :]
    for joint in way[1:]:
        out = quat_multiply(out, rotations[..., joint, :])
    return out


def seam_yaw(skeleton: Skeleton, left: Array, right: Array) -> float:
    """Yaw in rad that turns the right side's poses onto the left's (Eq. 14).

    left, right : (2, 4) world rotations of the hips at frames m−1 and m

    It is the yaw nearest to the mean of ``a b⁻¹``; for bodies upside down to each other, the difference of their hip
    lines.
    """
    relative = quat_multiply(left, quat_conjugate(right))
    if relative[0] @ relative[1] < 0:
        relative[1] *= -1.0
    mean = relative.sum(axis=0)
    mean /= max(float(np.linalg.norm(mean)), 1e-12)
    if np.hypot(mean[1], mean[3]) >= _FLAT:
        return float(2 * np.arctan2(mean[1], mean[3]))
    line = hip_line(skeleton)
    if line is None:
        return 0.0
    a, b = quat_rotate(left, line).sum(axis=0), quat_rotate(right, line).sum(axis=0)
    return float(np.arctan2(-a[2], a[0]) - np.arctan2(-b[2], b[0]))


def continue_placement(skeleton: Skeleton, carrier: int, left: Placement, around: tuple[Array, Array]) -> Placement:
    """The placement of the segment right of a seam, given that of the segment left of it (Eq. 14).

    around : unplaced rotations (4, J, 4) and translations (4, J, 3) of a(m−1), a(m), b(m−1), b(m), carrier in the world
    """
    rotations, translations = around
    hips = hips_joint(skeleton)
    joint = hips if carrier in skeleton.chain(hips) else carrier
    world = world_rotation(skeleton, carrier, joint, rotations)
    yaw = left.yaw + seam_yaw(skeleton, world[:2], world[2:])
    a = left.move(translations[:2, carrier])
    b = Placement(yaw).rotate(translations[2:, carrier])
    shift = (a - b).mean(axis=0)
    return Placement(yaw, float(shift[0]), float(shift[2]))


def displacement_residuals(left: Array, right: Array) -> Array:
    """The three residual rows m−2, m−1, m of a seam's ground displacements: (3, 2) m (Eq. 15).

    left, right : (4, 3) m, placed positions of both sources' own frames m−2, m−1, m, m+1

    The seam's interval takes the mean of both sources' displacements and, for δ, the mean of both second differences.
    """
    return residual_rows(np.diff(left, axis=0)[:, GROUND] - np.diff(right, axis=0)[:, GROUND])


def residual_rows(gaps: Array) -> Array:
    """The same from how far both sources' displacements differ in the intervals m−2, m−1 and m: (3, 2) m (Eq. 15)."""
    return np.stack([gaps[1] / 2, (gaps[2] - gaps[0]) / 2, -gaps[1] / 2])
