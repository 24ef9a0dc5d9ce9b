"""The one place where rotations become vectors and back: the two charts, and where a limb may spin.

A chart turns the quaternions of a window into vectors r that the seam solve can add a correction c to. ``principal``
is the published one: each frame on its own, angle in [0, π], relative to the rest pose. ``centred`` (the default)
measures from the mean of the poses that meet at the seams, follows each segment continuously, and so neither depends
on the rest pose nor flips (§ Charts in docs/method.md).
"""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.components import exp, join, log, multiply, split
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_distance,
    quat_log,
    quat_mean,
    quat_multiply,
    quat_normalize,
    quat_slerp,
    rotvec_to_quat,
)
from kinestitch.errors import ParameterError
from kinestitch.solve.seam import Cluster, correction, local_curves, visible_reach

Chart = Literal["centred", "principal"]
CHARTS: tuple[Chart, ...] = ("centred", "principal")
Joints = slice | NDArray[np.intp]

OVERTURN = 1.5 * np.pi
"""A joint whose corrected vector grows beyond this within reach of its seams is solved in the mid-tangent form
instead.
"""


LONG_WAY, LONG_WAY_FACTOR = 1.1, 1.6
"""A gap told by more than 1.1 π and 1.6 times its geodesic distance is closed the long way round; the chart's own
stretch stays below."""

_BLOCK = 8192
"""Quaternions worked on at a time: temporaries then stay in the processor's cache, which halves the time of a long
window.
"""

UNMOVED = 1e-10
"""rad; a window ends in frames that move by less, and they are left as they are."""

_SAME_HEMISPHERE = 0.7
"""Unit quaternions none of whose components differ by more than this are less than a right angle apart."""


@dataclass(frozen=True, eq=False, slots=True)
class Charted:
    """How a window's rotations become vectors, ``q = sign · base · exp(r)``, and where both sources' vectors stand
    at its seams.

    base : (J, 4); sign : (n, J), or None where all are +1
    principal : each frame takes the sign that makes w ≥ 0 instead
    straddling : (3, S, 4, J) rad, component first, per seam the vectors of a(m−1), a(m), b(m−1), b(m)
    """

    base: Array
    sign: Array | None
    straddling: Array
    principal: bool = False

    @property
    def offsets(self) -> Array:
        """Rows d_{m−1}, d_m = b − a of each seam: (3, 2S, J) rad, component first."""
        gaps = self.straddling[:, :, 2:] - self.straddling[:, :, :2]
        return gaps.reshape(3, -1, gaps.shape[-1])

    def of(self, joints: Joints) -> Charted:
        """The same of some joints."""
        sign = None if self.sign is None else self.sign[:, joints]
        return Charted(self.base[joints], sign, self.straddling[..., joints], self.principal)


def check_chart(chart: str) -> None:
    """Raise ParameterError unless `chart` is one of ``CHARTS``."""
    if chart not in CHARTS:
        raise ParameterError(f"Expected a chart out of {', '.join(CHARTS)}, got {chart!r}.")


def principal_chart(straddling: Array, rest: Array) -> Charted:
    """The published chart: principal vectors of ``rest⁻¹ q``, every frame on its own (Eq. 1).

    straddling : (S, 4, J, 4) per seam a(m−1), a(m), b(m−1), b(m); rest : (J, 4)
    """
    vectors, _ = chart_vectors(split(rest), split(straddling), None, principal=True)
    return Charted(rest, None, vectors, principal=True)


def centred_chart(rotations: Array, straddling: Array, local_frames: Sequence[int]) -> Charted:
    """Vectors from the mean of the poses that meet at the seams, continuous along each segment (Eq. 11).

    rotations : (n, J, 4) of the window, segments side by side
    straddling : (S, 4, J, 4) per seam a(m−1), a(m), b(m−1), b(m)
    local_frames : each seam's frame m counted from the window's start

    Each segment takes the sign that makes the sum of w over its own seam frames ≥ 0, each for itself: chaining the
    sign from segment to segment makes hips spin.
    """
    base = quat_mean(straddling.reshape(-1, *straddling.shape[2:]))
    edges = [0, *local_frames, len(rotations)]
    around = quat_multiply(quat_conjugate(base), straddling)
    flips = np.ones(around.shape[:3])
    sign = _continuous_signs(rotations, local_frames)
    for seam, m in enumerate(local_frames):
        if sign is not None:
            flips[seam, :2], flips[seam, 2:] = sign[m - 1], sign[m]
        flips[seam, 1] *= _agree(straddling[seam, 1], rotations[m - 1])
        flips[seam, 2] *= _agree(straddling[seam, 2], rotations[m])
    for piece, (first, last) in enumerate(pairwise(edges)):
        own = []  # this segment's frames around the seams on its left and on its right
        if piece > 0:
            own.append((piece - 1, slice(2, 4)))
        if piece < len(local_frames):
            own.append((piece, slice(0, 2)))
        turn = sum((around[seam, rows, :, 3] * flips[seam, rows]).sum(axis=0) for seam, rows in own) < 0
        if np.any(turn):
            sign = np.ones(rotations.shape[:2]) if sign is None else sign
            sign[first:last, turn] *= -1.0
            for seam, rows in own:
                flips[seam, rows, turn] *= -1.0
    return Charted(base, sign, log(split(flips[..., None] * around)))


def _agree(p: Array, q: Array) -> Array:
    return np.where(np.einsum("ji,ji->j", p, q) < 0, -1.0, 1.0)


def _continuous_signs(rotations: Array, local_frames: Sequence[int]) -> Array | None:
    """Signs (n, J) that make neighbouring frames of each segment agree in hemisphere; None where all are +1."""
    frames, joints = rotations.shape[:2]
    ones = np.ones(4)
    step = max(1, _BLOCK // joints)
    apart = np.zeros((frames, joints), dtype=bool)
    for start in range(1, frames, step):
        rows = slice(start, min(start + step, frames))
        here, before = rotations[rows], rotations[rows.start - 1 : rows.stop - 1]
        change = here - before
        change[[m - start for m in local_frames if start <= m < rows.stop]] = 0.0
        if max(change.max(), -change.min()) > _SAME_HEMISPHERE:
            np.less((here * before) @ ones, 0, out=apart[rows])
    some = np.flatnonzero(apart.any(axis=0))
    if len(some) == 0:
        return None
    sign = np.ones((frames, joints))
    sign[:, some] = 1.0 - 2.0 * (np.cumsum(apart[:, some], axis=0, dtype=np.int32) & 1)
    return sign


def chart_vectors(
    base: Array, rotations: Array, sign: Array | None, *, principal: bool = False
) -> tuple[Array, Array | None]:
    """Vectors (3, ...) rad and signs (...) of rotations: ``sign · base⁻¹ q = exp(r)`` (Eq. 11); all component first.

    base, rotations : (4, ...) that broadcast; sign : (...) or None for +1; principal : take the sign that makes w ≥ 0
    """
    x, y, z, w = base
    parts = multiply((-x, -y, -z, w), rotations)
    if principal:
        sign = np.where(parts[3] < 0, -1.0, 1.0)
    return log(parts if sign is None else [sign * part for part in parts]), sign


def unchart(base: Array, vectors: Array, sign: Array | None) -> tuple[Array, ...]:
    """Back to quaternions, component first: ``sign · base · exp(r)``, so that an unchanged vector gives the very one
    it came from.
    """
    parts = multiply(base, exp(vectors))
    return parts if sign is None else tuple(sign * part for part in parts)


def corrected(vectors: Array, offsets: Array, cluster: Cluster, curves: Array | None = None) -> Array:
    """The solve proper: curves, their product with the offsets, and the sum with the target's vectors: (3, n, J) rad
    (Eq. 7).

    vectors : (3, n, J) rad of the target; offsets : (3, 2S, J) rad; curves : those of the cluster, where they are known
    """
    return np.add(vectors, correction(cluster, offsets) if curves is None else curves @ offsets)


def solve_rotations(charted: Charted, cluster: Cluster, curves: Array | None, rotations: Array) -> NDArray[np.intp]:
    """Solve all seams of a cluster's window in place (Eq. 5, 7).

    curves : (n, 2S) of :func:`seam_curves`, or None for many seams; rotations : (n, J, 4), the hard cut, becomes the
    result

    Returns the indices of joints that turn almost all the way round near a seam or between two seams, for which
    :func:`mid_tangent` is the better form.
    """
    offsets = charted.offsets
    whole = correction(cluster, offsets) if curves is None else np.empty(0)
    offsets = offsets.swapaxes(1, 2).copy()
    frames, joints = rotations.shape[:2]
    overturned = _takes_long_way(charted)
    near = _near_seams(cluster)
    base = quat_multiply(charted.base[:, None], np.eye(4))  # (J, 4, 4): q @ base[j] is the product base[j] q
    step = min(frames, max(1, _BLOCK // joints))
    scratch = np.empty((4, joints, step))
    for rows in _blocks(cluster, step, (0, frames) if curves is None else _moving(curves, offsets)):
        parts = scratch[..., : rows.stop - rows.start]
        block = rotations[rows].swapaxes(0, 1)
        turn, sign = _signed(base, None if charted.sign is None else charted.sign[rows])
        np.matmul(block, turn.swapaxes(1, 2), out=parts.transpose(1, 2, 0))
        if charted.principal:
            sign = np.where(parts[3] < 0, -1.0, 1.0)
        if sign is not None:
            parts *= sign
        vectors = log(parts, out=parts[:3])
        vectors += whole[:, rows].swapaxes(1, 2) if curves is None else offsets @ curves[rows].T
        if near[rows].any() and not charted.principal:
            overturned |= ((vectors[..., near[rows]] ** 2).sum(axis=0) > OVERTURN**2).any(axis=1)
        exp(vectors, out=parts)
        if sign is not None:
            parts *= sign
        np.matmul(parts.transpose(1, 2, 0), turn, out=block)
    return np.flatnonzero(overturned)


def _moving(curves: Array, offsets: Array) -> tuple[int, int]:
    """The first frame that a correction moves by more than ``UNMOVED``, and the one after the last.

    offsets : (3, J, 2S) rad
    """
    most = np.zeros(len(curves))
    for sign in (1.0, -1.0):  # told by sum and difference, since a seam's two curves all but cancel each other
        gaps = np.abs(offsets[..., ::2] + sign * offsets[..., 1::2]).max(axis=(0, 1))
        most += np.abs(curves[:, ::2] + sign * curves[:, 1::2]) @ gaps / 2
    moved = np.flatnonzero(most > UNMOVED)
    return (int(moved[0]), int(moved[-1]) + 1) if len(moved) else (0, 0)


def _blocks(cluster: Cluster, step: int, within: tuple[int, int]) -> Iterator[slice]:
    """Some frames of a window in blocks of at most `step`, which end at a seam where one lies in their second half."""
    (start, last), seams = within, cluster.local_frames
    while start < last:
        stop = min(start + step, last)
        before = bisect_left(seams, stop) - 1
        if before >= 0 and seams[before] > start + step // 2:
            stop = seams[before]
        yield slice(start, stop)
        start = stop


def _signed(base: Array, sign: Array | None) -> tuple[Array, Array | None]:
    """The base (J, 4, 4) with the signs of a block's first frame in it, and what is left of the signs: (J, n) or
    None.
    """
    if sign is None:
        return base, None
    left = sign * sign[0]
    return base * sign[0][:, None, None], None if left.min() > 0 else left.T


def _takes_long_way(charted: Charted) -> NDArray[np.bool_]:
    """Joints (J,) whose gap at some seam is told by much more than its shortest way.

    One centre serves all seams of a cluster; a source that turns almost all the way round between two of them ends on
    another sheet than it began on, and one of its seams would be closed the long way round.
    """
    if charted.principal or charted.straddling.shape[1] < 2:
        return np.zeros(charted.base.shape[0], dtype=bool)
    told = np.linalg.norm(charted.straddling[:, :, 2:] - charted.straddling[:, :, :2], axis=0)
    far = told > LONG_WAY * np.pi
    if far.any():
        poses = join(exp(charted.straddling))
        far &= told > LONG_WAY_FACTOR * quat_distance(poses[:, :2], poses[:, 2:])
    return np.asarray(far.any(axis=(0, 1)))


def offsets_as_solved(charted: Charted, straddling: Array) -> Array:
    """:attr:`Charted.offsets`, but those of joints that :func:`mid_tangent` solves because their gap is told the long
    way round are told in its tangents: (3, 2S, J) rad.

    straddling : (S, 4, J, 4)
    """
    offsets, joints = charted.offsets, np.flatnonzero(_takes_long_way(charted))
    if len(joints):
        gaps = [_mid_offsets(poses)[1] for poses in straddling[:, :, joints]]
        offsets[:, :, joints] = np.moveaxis(np.concatenate(gaps), -1, 0)
    return offsets


def _near_seams(cluster: Cluster) -> np.ndarray:
    near = np.zeros(cluster.frames, dtype=bool)
    for seam, m in zip(cluster.seams, cluster.local_frames, strict=True):
        reach = visible_reach(seam.stiffness)
        near[max(0, m - reach) : m + reach] = True
    return near


def mid_tangent(rotations: Array, straddling: Array, cluster: Cluster, curves: Array | None) -> Array:
    """The form for joints that turn almost all the way round: corrections live in the tangent at the middle of each
    gap (Eq. 12).

    With d̄ the log of the mean relative rotation and H = exp(d̄/2), the left side becomes ``a exp(d̄/2) exp(c −
    d̄/2)``, the right side ``b exp(−d̄/2) exp(c + d̄/2)``, and the offsets are ``d̄ + log(H⁻¹ rel H⁻¹)``.

    Seams with overlapping windows are solved one after the other, each with the poses that those before it have left,
    in both orders; the middle of the two commutes with time reversal.

    rotations : (n, J, 4); straddling : (S, 4, J, 4); curves : (n, 2S), or None for many seams. Returns
    (n, J, 4).
    """
    order = range(len(straddling))
    whole = slice(0, cluster.frames)
    near = local_curves(cluster) if curves is None else [(whole, curves[:, 2 * s : 2 * s + 2]) for s in order]
    there = _mid_tangent(rotations, straddling, cluster, near, order)
    if len(order) == 1:
        return there
    return quat_slerp(there, _mid_tangent(rotations, straddling, cluster, near, order[::-1]), np.array(0.5))


def _mid_tangent(
    rotations: Array,
    straddling: Array,
    cluster: Cluster,
    curves: Sequence[tuple[slice, Array]],
    order: Sequence[int],
) -> Array:
    """One seam after the other in the given order; curves : per seam the frames it reaches and g₀, g₁ on them."""
    poses, frames, out = straddling.copy(), cluster.local_frames, rotations.copy()
    for place, seam in enumerate(order):
        mean, offsets = _mid_offsets(poses[seam])
        near, values = curves[seam]
        change = np.einsum("nk,kjc->njc", values, offsets)
        left = np.arange(near.start, near.stop)[:, None, None] < frames[seam]
        half = np.where(left, 0.5, -0.5) * mean
        out[near] = quat_multiply(quat_multiply(out[near], rotvec_to_quat(half)), rotvec_to_quat(change - half))
        for other in order[place + 1 :]:
            if not near.start < frames[other] < near.stop:
                break
            rows = [frames[other] - 1 - near.start, frames[other] - near.start] * 2
            half = (0.5 if other < seam else -0.5) * mean
            turn = quat_multiply(rotvec_to_quat(half), rotvec_to_quat(change[rows] - half))
            poses[other] = quat_multiply(poses[other], turn)
    return out


def _mid_offsets(straddling: Array) -> tuple[Array, Array]:
    """A seam's d̄ (J, 3) and its offset rows (2, J, 3) in the mid-tangent form, from poses (4, J, 4)."""
    relative = quat_multiply(quat_conjugate(straddling[:2]), straddling[2:])
    relative[1] *= _agree(relative[0], relative[1])[:, None]
    relative *= np.where(relative[..., 3].sum(axis=0) < 0, -1.0, 1.0)[:, None]
    mean = quat_log(quat_normalize(relative.sum(axis=0)))
    back = rotvec_to_quat(-mean / 2)
    return mean, mean + quat_log(quat_multiply(quat_multiply(back, relative), back))
