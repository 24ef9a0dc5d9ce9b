"""What a seam adds to the acceleration and speed of its sources, in closed form: known for any λ before it is solved.

With the curves g₀, g₁ of λ, the result's second differences less the sources' own are

    L c − e = u₀(t) · d_{m−1} + u₁(t) · d_m                                                          (Eq. 27)

two scalar curves times the two rows of offsets, the same for every joint. Its size is a quadratic form in the offsets,
so that the peaks of all joints are one thin matrix product.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.solve.chart import centred_chart
from kinestitch.solve.laplacian import second_difference
from kinestitch.solve.placed import Placed, straddling
from kinestitch.solve.root import displacement_residuals
from kinestitch.solve.seam import Cluster, SeamPlace, cluster_rows, row_curves, seam_curves
from kinestitch.solve.window import hips_to_world, way_to_hips

_NEAR = 12.0  # λ^¼ on each side that are solved; what lies beyond is less than 3e-4 of the peaks
_PEAKS = 5.0  # λ^¼ on each side in which the peaks lie


@dataclass(frozen=True, eq=False, slots=True)
class Gap:
    """What a seam has to close, and where in a result.

    turning : (3, J) rad², of each joint d_{m−1}·d_{m−1}, d_{m−1}·d_m, d_m·d_m
    path : (9,) m², products of the displacements' residuals in the intervals m−2, m−1, m (Eq. 15) on the ground, six in
    the order 00, 01, 02, 11, 12, 22, and those of d_{m−1}, d_m in height, three; of the joint that carries the travel
    before, after : frames of the result on either side; fps : its rate
    """

    turning: Array
    path: Array
    before: int
    after: int
    fps: float


@dataclass(frozen=True, eq=False, slots=True)
class _Response:
    """Squares of what a seam adds, per frame, as forms in the products of a :class:`Gap`.

    bends : (n, 3) acceleration; steps : (n, 3) velocity; at_seam : (2, 3) that of the seam's own interval, against the
    left source and against the right one; path : (n, 9)
    """

    bends: Array
    steps: Array
    at_seam: Array
    path: Array


def seam_gap(placed: Placed, seam: SeamPlace) -> Gap:
    """What a seam has to close, charted around itself; hips below the carrier as the world sees them."""
    around = straddling(placed, seam)
    poses = around.rotations
    hips_to_world(way_to_hips(placed), poses)
    first, second = np.moveaxis(centred_chart(poses[[0, 3]], poses[None], [1]).offsets, 1, 0)
    turning = np.stack([(a * b).sum(axis=0) for a, b in ((first, first), (first, second), (second, second))])
    ground = displacement_residuals(around.left_path, around.right_path)
    height = around.translations[2:, placed.carrier, 1] - around.translations[:2, placed.carrier, 1]
    path = np.concatenate([(ground @ ground.T)[np.triu_indices(3)], np.outer(height, height)[np.triu_indices(2)]])
    return Gap(turning, path, seam.frame, placed.frames - seam.frame, placed.timeline.fps)


def added_turning(gap: Gap, stiffness: float, joints: Sequence[int] | slice = slice(None)) -> tuple[Array, Array]:
    """Peaks over time of what a seam of this λ adds to its sources' angular acceleration, (J,) rad/s², and angular
    velocity, (J,) rad/s, known without solving for it (Eq. 27).
    """
    response = _response_to(gap, stiffness)
    products = gap.turning[:, joints]
    bend = (response.bends @ products).max(axis=0)
    step = np.maximum((response.steps @ products).max(axis=0), (response.at_seam @ products).min(axis=0))
    return np.sqrt(np.maximum(bend, 0.0)) * gap.fps**2, np.sqrt(np.maximum(step, 0.0)) * gap.fps


def added_to_path(gap: Gap, stiffness: float) -> float:
    """Peak over time of what a seam of this λ adds to the acceleration of the joint that carries the travel: m/s²
    (Eq. 28).
    """
    return math.sqrt(max(0.0, (_response_to(gap, stiffness).path @ gap.path).max())) * gap.fps**2


def _response_to(gap: Gap, stiffness: float) -> _Response:
    near = math.ceil(_NEAR * stiffness**0.25) + 8
    return _response(stiffness, min(gap.before, near), min(gap.after, near))


@lru_cache(maxsize=128)
def _response(stiffness: float, before: int, after: int) -> _Response:
    cluster = Cluster(0, before + after, (SeamPlace(0, before, stiffness),))
    last = cluster.frames - 1
    curves = seam_curves(cluster)
    bend = second_difference(curves)
    for frame, column, value in ((before - 1, 1, 1.0), (before, 0, -1.0)):  # less e, where it has a row
        if 0 < frame < last:
            bend[frame, column] += value
    steps = np.diff(curves, axis=0)
    at_seam = steps[before - 1] + np.eye(2)
    steps[before - 1] = 0.0
    ground = np.zeros((cluster.frames, 3))
    moved = row_curves(cluster_rows(cluster, intervals=True), [before - 2, before - 1, before])
    ground[1:-1] = np.diff(moved, axis=0)
    for frame in (before - 1, before):
        if 0 < frame < last:
            ground[frame, 0] -= 1.0
    reach = math.ceil(_PEAKS * stiffness**0.25) + 4
    near = slice(max(0, before - reach), before + reach)
    bends, steps, at_seam, ground = (_squares(rows) for rows in (bend[near], steps[near], at_seam, ground[near]))
    return _Response(bends, steps, at_seam, np.hstack([ground, bends]))


def _squares(rows: Array) -> Array:
    """Products of the columns of (n, K), all pairs once, so that ``_squares(u) @ products of d`` is ``(u @ d)²``."""
    first, second = np.triu_indices(rows.shape[1])
    return rows[:, first] * rows[:, second] * np.where(first == second, 1.0, 2.0)
