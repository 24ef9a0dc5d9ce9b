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

_NEAR = 12.0  # λ^¼ on each side that are looked at; what lies beyond is less than 3e-4 of the peaks


@dataclass(frozen=True, eq=False, slots=True)
class Gap:
    """What a seam has to close, and where in a result.

    products : (3, J) rad², of each joint d_{m−1}·d_{m−1}, d_{m−1}·d_m, d_m·d_m
    height : (2,) m, the rows d_{m−1}, d_m of the joint that carries the travel
    path : (3, 2) m, its displacements' residuals in the intervals m−2, m−1, m (Eq. 15)
    before, after : frames of the result on either side; fps : its rate
    """

    products: Array
    height: Array
    path: Array
    before: int
    after: int
    fps: float


@dataclass(frozen=True, eq=False, slots=True)
class _Response:
    """What a seam adds for unit gaps, per frame: bend (n, 2) for rows d_{m−1}, d_m; path (n, 3) for residual rows.

    bends, steps : (n, 3) and (n − 1, 3), products of columns 00, 01, 11; at_seam : (2, 3) of the seam's own interval,
    against the left source and against the right one
    """

    bend: Array
    path: Array
    bends: Array
    steps: Array
    at_seam: Array


def seam_gap(placed: Placed, seam: SeamPlace) -> Gap:
    """What a seam has to close, charted around itself; hips below the carrier as the world sees them."""
    around = straddling(placed, seam)
    poses = around.rotations
    hips_to_world(way_to_hips(placed), poses)
    first, second = np.moveaxis(centred_chart(poses[[0, 3]], poses[None], [1]).offsets, 1, 0)
    products = np.stack([(a * b).sum(axis=0) for a, b in ((first, first), (first, second), (second, second))])
    height = around.translations[2:, placed.carrier, 1] - around.translations[:2, placed.carrier, 1]
    residuals = displacement_residuals(around.left_path, around.right_path)
    return Gap(products, height, residuals, seam.frame, placed.frames - seam.frame, placed.timeline.fps)


def added_turning(gap: Gap, stiffness: float, joints: Sequence[int] | slice = slice(None)) -> tuple[Array, Array]:
    """Peaks over time of what a seam of this λ adds to its sources' angular acceleration, (J,) rad/s², and angular
    velocity, (J,) rad/s, known without solving for it (Eq. 27).
    """
    response = _response_to(gap, stiffness)
    products = gap.products[:, joints]
    bend = (response.bends @ products).max(axis=0)
    step = np.maximum((response.steps @ products).max(axis=0), (response.at_seam @ products).min(axis=0))
    return np.sqrt(np.maximum(bend, 0.0)) * gap.fps**2, np.sqrt(np.maximum(step, 0.0)) * gap.fps


def added_to_path(gap: Gap, stiffness: float) -> float:
    """Peak over time of what a seam of this λ adds to the acceleration of the joint that carries the travel: m/s²
    (Eq. 28).
    """
    response = _response_to(gap, stiffness)
    ground, height = response.path @ gap.path, response.bend @ gap.height
    return float(np.sqrt(((ground**2).sum(axis=1) + height**2).max())) * gap.fps**2


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
    path = np.zeros((cluster.frames, 3))
    moved = row_curves(cluster_rows(cluster, intervals=True), [before - 2, before - 1, before])
    path[1:-1] = np.diff(moved, axis=0)
    for frame in (before - 1, before):
        if 0 < frame < last:
            path[frame, 0] -= 1.0
    return _Response(bend, path, *(_products(rows) for rows in (bend, steps, at_seam)))


def _products(rows: Array) -> Array:
    return np.column_stack([rows[:, 0] ** 2, 2 * rows[:, 0] * rows[:, 1], rows[:, 1] ** 2])
