"""As much time for every seam as it needs and no more: λ chosen so that what a seam adds stays under a share of what
its sources do anyway.

What the solve adds to the acceleration of a joint is known in closed form before anything is solved: with the curves
g₀, g₁ of λ it is ``L c − e``, two scalar curves times the two rows of offsets (Eq. 27). The smallest λ that keeps all
bounds is found on that form alone, for every part of the body by itself: an arm that hangs still at a cut need not wait
for the legs (Eq. 29).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import DEFAULT_SMOOTHING
from kinestitch.errors import ParameterError
from kinestitch.rig.groups import BODY, joint_groups
from kinestitch.solve.chart import centred_chart
from kinestitch.solve.laplacian import second_difference
from kinestitch.solve.placed import JointGroup, Placed, straddling
from kinestitch.solve.root import displacement_residuals
from kinestitch.solve.seam import VISIBLE, Cluster, SeamPlace, cluster_rows, row_curves, seam_curves
from kinestitch.solve.sources import Strength, own_strength
from kinestitch.solve.window import hips_to_world, way_to_hips

LEAST, MOST = 0.03, 0.6
"""Smoothing times in s between which an automatic seam stays."""

UNSEEN = Strength(1.0, 0.1, 0.3)
"""rad/s², rad/s, m/s²: sources that move less count as if they moved so much, or two still poses could never meet."""

NEAREST = 1.1
"""A bound that no λ keeps is replaced by this many times the least that any λ comes to."""

_STEP = 1.3  # from one tried smoothing time to the next
_NEAR = 12.0  # λ^¼ on each side that are looked at; what lies beyond is less than 3e-4 of the peaks
_CLOSE = 1e-3  # of a bound, by which a chosen λ may stay under it
_TRIES = 12


@dataclass(frozen=True, slots=True)
class Share:
    """How much a seam may add, over the 95th percentile of what its sources do within a second of it.

    acceleration, velocity : of any joint's turning; path : of the acceleration of the joint that carries the travel

    Raises ParameterError unless all are above 0; infinity sets no bound.
    """

    acceleration: float = 0.25
    velocity: float = 1.0
    path: float = 1.0

    def __post_init__(self) -> None:
        for name in ("acceleration", "velocity", "path"):
            if not getattr(self, name) > 0:
                raise ParameterError(f"Expected a share of {name} above 0, got {getattr(self, name)}.")


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


def with_automatic(placed: Placed, share: Share | None = None, *, grouped: bool = True) -> Placed:
    """The same with a λ for every automatic seam, which :func:`place_timeline` leaves at the default's.

    grouped : every part of the body takes its own (:func:`joint_groups`); the seam itself has the largest of them
    """
    share = Share() if share is None else share
    automatic = [placed.timeline.seams[seam.index].automatic for seam in placed.seams]
    if not any(automatic):
        return placed
    everything = {BODY: tuple(range(placed.skeleton.joint_count))}
    groups = joint_groups(placed.skeleton) if grouped else everything
    table = np.array(
        [
            _chosen(placed, number, share, groups) if chosen else [placed.seams[number].stiffness] * len(groups)
            for number, chosen in enumerate(automatic)
        ]
    )
    seams = tuple(replace(seam, stiffness=float(row.max())) for seam, row in zip(placed.seams, table, strict=True))
    parts = tuple(
        JointGroup(name, joints, tuple(map(float, column)))
        for (name, joints), column in zip(groups.items(), table.T, strict=True)
    )
    return replace(placed, seams=seams, groups=parts if len(parts) > 1 else ())


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


@lru_cache(maxsize=256)
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


def widest(placed: Placed, number: int) -> float:
    """The longest smoothing time in s that the seam `number` of ``placed.seams`` may take: its visible reach (Eq. 9)
    ends half way to the next seams, unless the default's is longer than that.
    """
    places = [seam.frame for seam in placed.seams]
    apart = [abs(places[number] - places[other]) for other in (number - 1, number + 1) if 0 <= other < len(places)]
    room = min(apart, default=math.inf) / 2 / VISIBLE / placed.timeline.fps
    return min(MOST, max(DEFAULT_SMOOTHING, room))


def _chosen(placed: Placed, number: int, share: Share, groups: Mapping[str, Sequence[int]]) -> list[float]:
    """λ of each group at one seam."""
    seam = placed.seams[number]
    gap, own = seam_gap(placed, seam), own_strength(placed, seam)
    limits = np.array(
        [
            share.acceleration * max(own.acceleration, UNSEEN.acceleration),
            share.velocity * max(own.velocity, UNSEEN.velocity),
            share.path * max(own.path, UNSEEN.path),
        ]
    )
    shortest, longest = LEAST * gap.fps, widest(placed, number) * gap.fps
    steps = math.ceil(math.log(longest / shortest) / math.log(_STEP))
    widths = [*(shortest * _STEP**step for step in range(steps)), longest]
    turning = [added_turning(gap, width**4) for width in widths]
    path = [added_to_path(gap, width**4) for width in widths]

    def least(joints: list[int]) -> float:
        travels = placed.carrier in joints

        def peaks(width: float) -> Array:
            acceleration, velocity = added_turning(gap, width**4, joints)
            return np.array([acceleration.max(), velocity.max(), added_to_path(gap, width**4) if travels else 0.0])

        tried = np.array(
            [(a[joints].max(), v[joints].max(), p * travels) for (a, v), p in zip(turning, path, strict=True)]
        )
        return _least(peaks, widths, tried, limits) ** 4

    return [least(list(joints)) for joints in groups.values()]


def _least(peaks: Callable[[float], Array], widths: Sequence[float], tried: Array, limits: Array) -> float:
    """The least λ^¼ in frames whose peaks keep all limits, to a thousandth of a limit (Eq. 29).

    widths : rising; tried : the peaks (K, 3) at each. Where no width keeps all limits, the one that breaks them least.
    """
    limits = np.maximum(limits, NEAREST * tried.min(axis=0))
    excess = (tried / limits).max(axis=1)
    keeps = int(np.argmax(excess <= 1.0)) if (excess <= 1.0).any() else int(np.argmin(excess))
    if keeps == 0 or excess[keeps] > 1.0:
        return widths[keeps]
    low, high = widths[keeps - 1], widths[keeps]
    over, under = math.log(excess[keeps - 1]), math.log(max(excess[keeps], 1e-12))
    for _ in range(_TRIES):
        if under > -_CLOSE:
            break
        middle = low * (high / low) ** min(0.95, over / (over - under) + 0.02)
        value = math.log(max(float((peaks(middle) / limits).max()), 1e-12))
        if value > 0:
            low, over = middle, value
        else:
            high, under = middle, value
    return high
