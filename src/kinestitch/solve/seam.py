"""Seams in closed form: where they act, the two scalar curves each one needs, and what it costs.

A seam at m sits between frames m−1 and m. With offsets d_k = b(k) − a(k), the residual e = δ_tar − L R_tar is zero
but for two rows, e_{m−1} = −d_m and e_m = +d_{m−1} (Eq. 6), so the correction of every joint and channel is

    c(t) = g₀(t) · d_{m−1} + g₁(t) · d_m                                                             (Eq. 7)

with the same two curves for all of them. The curves die away as exp(−t / (√2 λ^¼)), so only a window around the seam
moves.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import Seam
from kinestitch.solve.laplacian import (
    check_smoothing,
    check_stiffness,
    normal_bands,
    solve_bands,
    transposed_second_difference,
)


def stiffness_at(seam: Seam, fps: float) -> float:
    """The λ of a seam at this rate; raises ParameterError where it, or the smoothing time, is too large to solve."""
    if seam.smoothing is not None:
        check_smoothing(seam.smoothing, fps)
    stiffness = seam.lambda_at(fps)
    check_stiffness(stiffness)
    return stiffness


def seam_reach(stiffness: float) -> int:
    """Frames on each side beyond which less than 1e-12 of the peak correction is left: ``⌈40 λ^¼⌉ + 8`` (Eq. 8)."""
    return math.ceil(40 * stiffness**0.25) + 8


VISIBLE = 4.2
"""λ^¼ on each side after which a position gap has fallen below 5 % of its peak."""


def visible_reach(stiffness: float) -> int:
    """Frames after which a position gap has fallen below 5 % of its peak: about ``4.2 λ^¼`` (Eq. 9)."""
    return max(1, math.ceil(VISIBLE * stiffness**0.25))


FEW_SEAMS = 4
"""Up to so many seams share whole curves over their window; more are taken one by one, each on its own reach."""


@dataclass(frozen=True, slots=True)
class SeamPlace:
    """A seam on the result's frames: number `index` of the timeline, before frame `frame`, with its λ."""

    index: int
    frame: int
    stiffness: float


@dataclass(frozen=True, slots=True)
class Cluster:
    """Seams whose windows overlap, solved together on the frames [start, stop) of the result.

    held : how many frames at the window's start and end have no correction, although a seam would reach them
    """

    start: int
    stop: int
    seams: tuple[SeamPlace, ...]
    held: tuple[int, int] = (0, 0)

    @property
    def frames(self) -> int:
        """Number of frames of the window."""
        return self.stop - self.start

    @property
    def local_frames(self) -> tuple[int, ...]:
        """Each seam's frame counted from the window's start."""
        return tuple(seam.frame - self.start for seam in self.seams)


_HELD = 3
"""Frames without correction, and two intervals between them, that keep the two sides of a firm frame apart."""


def clusters(places: Sequence[SeamPlace], frames: int, firm: Sequence[int] = ()) -> tuple[Cluster, ...]:
    """Group seams whose windows [m − reach, m + reach) overlap; windows end where the result of `frames` frames ends.

    A hard cut (λ = 0) has no window, but one inside another seam's window belongs to it: no correction crosses it.
    firm : frames which no correction reaches and none crosses; the seams on their two sides are solved apart
    """
    if firm:
        return _between(places, frames, sorted(firm))
    spans = []
    for place in places:
        if place.stiffness > 0:
            reach = seam_reach(place.stiffness)
            spans.append((max(0, place.frame - reach), min(frames, place.frame + reach), place))
    spans.sort(key=lambda span: span[:2])
    groups: list[tuple[int, int, list[SeamPlace]]] = []
    for start, stop, place in spans:
        if groups and start < groups[-1][1]:
            last = groups[-1]
            groups[-1] = (last[0], max(last[1], stop), [*last[2], place])
        else:
            groups.append((start, stop, [place]))
    hard = [place for place in places if place.stiffness == 0]
    return tuple(
        Cluster(a, b, tuple(sorted([*found, *(p for p in hard if a < p.frame < b)], key=lambda p: p.frame)))
        for a, b, found in groups
    )


def _between(places: Sequence[SeamPlace], frames: int, firm: Sequence[int]) -> tuple[Cluster, ...]:
    """Clusters that end at firm frames: the last frames of a window, from the firm one on, or the first are held."""
    found = []
    for before, after in pairwise([-1, *firm, frames]):
        for cluster in clusters([place for place in places if before < place.frame <= after], frames):
            start = max(cluster.start, before - _HELD + 1, 0) if before >= 0 else cluster.start
            stop = min(cluster.stop, after + _HELD, frames)
            held = max(0, before + 1 - start), max(0, stop - after)
            found.append(replace(cluster, start=start, stop=stop, held=held))
    return tuple(found)


def cluster_rows(cluster: Cluster, *, intervals: bool = False) -> Array:
    """Λ for each row of a cluster's window, zero at its ends: a seam's own rows have its λ, every other row that of the
    seam it lies nearest to, in reaches.

    intervals : rows stand for the intervals between frames (one fewer) rather than for frames
    """
    count = cluster.frames - (1 if intervals else 0)
    values = {seam.stiffness for seam in cluster.seams}
    rows = np.full(count, max(values))
    if len(values) > 1:
        row = np.arange(count) + cluster.start
        half = 1.0 if intervals else 0.5  # a seam's own rows are m−1 and m, or the intervals m−2, m−1 and m
        nearest = np.full(count, np.inf)
        for seam in sorted(cluster.seams, key=lambda s: s.stiffness):
            distance = np.maximum(np.abs(row - (seam.frame - half)) - half, 0.0) / seam_reach(seam.stiffness)
            takes = distance <= nearest
            rows[takes] = seam.stiffness
            nearest = np.where(takes, distance, nearest)
    if count:
        rows[0] = rows[-1] = 0.0
    return rows


def row_curves(rows: Array, places: Sequence[int], held: tuple[int, int] = (0, 0)) -> Array:
    """Response of the correction to a unit residual in each of the named rows: ``(I + LᵀΛL)⁻¹ LᵀΛ`` columns (n, K).

    rows : (n,) Λ of the window, zero at its ends; a place whose row does not exist yields a zero column
    held : frames at either end that have no correction, taken out of the system
    """
    count = len(rows)
    rhs = np.zeros((count, len(places)), order="F")
    for column, place in enumerate(places):
        if 0 < place < count - 1:
            rhs[place - 1 : place + 2, column] = rows[place] * np.array([1.0, -2.0, 1.0])
    return _solve_free(rows, rhs, held)


def _solve_free(rows: Array, rhs: Array, held: tuple[int, int]) -> Array:
    """``(I + LᵀΛL)⁻¹ rhs`` where the held rows at both ends are zero instead; `rhs` (n, K) is used up."""
    if held == (0, 0):
        return solve_bands(normal_bands(rows), rhs)
    free = slice(held[0], len(rows) - held[1])
    out = np.zeros(rhs.shape)
    out[free] = solve_bands(normal_bands(rows)[:, free].copy(order="F"), rhs[free].copy(order="F"))
    return out


def seam_curves(cluster: Cluster) -> Array:
    """The curves g₀, g₁ of every seam of a cluster, side by side: (n, 2S), to be multiplied by rows d_{m−1}, d_m
    (Eq. 7).
    """
    places = [place for m in cluster.local_frames for place in (m, m - 1)]
    curves = row_curves(cluster_rows(cluster), places, cluster.held)
    curves[:, 1::2] *= -1.0
    return curves


def shared_curves(cluster: Cluster) -> Array | None:
    """The curves of a cluster of few seams, (n, 2S); None where there are many, which are taken one by one."""
    return seam_curves(cluster) if len(cluster.seams) <= FEW_SEAMS else None


def local_curves(cluster: Cluster) -> list[tuple[slice, Array]]:
    """For each seam the frames of the window that it reaches, and g₀, g₁ on them, (w, 2): for clusters of many.

    The reach is that of the cluster's largest λ, so that less than 1e-12 of a curve is left out.
    """
    rows = cluster_rows(cluster)
    reach = seam_reach(max(seam.stiffness for seam in cluster.seams))
    found = []
    for m in cluster.local_frames:
        start, stop = max(0, m - reach), min(cluster.frames, m + reach)
        near = rows[start:stop].copy()
        near[0] = near[-1] = 0.0
        held = max(0, cluster.held[0] - start), max(0, cluster.held[1] - (cluster.frames - stop))
        curves = row_curves(near, [m - start, m - 1 - start], held)
        curves[:, 1] *= -1.0
        found.append((slice(start, stop), curves))
    return found


def displacement_correction(cluster: Cluster, residuals: Array) -> Array:
    """What the seams' residuals in the interval rows m−2, m−1, m, (3S, C) m, do to positions: (n, C) m (Eq. 16).

    Solved on the n−1 intervals between frames and summed up, so that the last frame of the window is where it was.
    """
    rows = cluster_rows(cluster, intervals=True)
    error = np.zeros((len(rows), residuals.shape[1]))
    for seam, m in enumerate(cluster.local_frames):
        for row, value in zip((m - 2, m - 1, m), residuals[3 * seam : 3 * seam + 3], strict=True):
            if 0 < row < len(rows) - 1:
                error[row] += value
    position = np.zeros((cluster.frames, residuals.shape[1]))
    rhs = transposed_second_difference(rows[:, None] * error)
    held = max(0, cluster.held[0] - 1), max(0, cluster.held[1] - 1)
    steps = _solve_free(rows, rhs, held)
    if held != (0, 0):  # what is held no longer sums up to zero by itself: the way between it and the seam makes up
        first, last = cluster.local_frames[0], cluster.local_frames[-1]
        between = (last, held[1]) if held[1] else (held[0], len(rows) - first + 1)
        share = _solve_free(rows, np.ones((len(rows), 1), order="F"), between if sum(between) < len(rows) else held)
        steps -= share * (steps.sum(axis=0) / share.sum())
    np.cumsum(steps, axis=0, out=position[1:])
    return position


def correction(cluster: Cluster, offsets: Array) -> Array:
    """The correction (..., n, C) of a cluster's window from its seams' offsets (..., 2S, C), rows d_{m−1}, d_m each
    (Eq. 7).
    """
    curves = shared_curves(cluster)
    if curves is not None:
        return curves @ offsets
    out = np.zeros((*offsets.shape[:-2], cluster.frames, offsets.shape[-1]))
    for seam, (near, curves) in enumerate(local_curves(cluster)):
        out[..., near, :] += curves @ offsets[..., 2 * seam : 2 * seam + 2, :]
    return out


def seam_kernel(rows: Array, place: int) -> Array:
    """The 2×2 block of ``(Λ⁻¹ + LLᵀ)⁻¹``, which is ``λ (I + λLLᵀ)⁻¹``, at rows m−1 and m (Eq. 10).

    Solved on the rows of L themselves, which keeps ten digits at λ = 10⁸; a row that does not exist yields zeros.

    rows : (n,) Λ of a window, zero at its two ends only; place : the seam's frame m counted from the window's start
    """
    inner = rows[1:-1]
    bands = np.zeros((3, len(inner)), order="F")
    bands[2] = 6.0 + 1.0 / inner
    bands[1, 1:], bands[0, 2:] = -4.0, 1.0
    pair = [row - 1 for row in (place - 1, place)]
    exists = [0 <= row < len(inner) for row in pair]
    kernel = np.zeros((2, 2))
    if any(exists):
        unit = np.zeros((len(inner), 2), order="F")
        for column, row in enumerate(pair):
            if exists[column]:
                unit[row, column] = 1.0
        solved = solve_bands(bands, unit)
        kernel[exists] = solved[[row for row, there in zip(pair, exists, strict=True) if there]]
    return kernel


def seam_energy(place: SeamPlace, frames: int, offsets: Array) -> float:
    """The least energy E* of one seam alone: ``Σ_channels sᵀ K s`` with ``s = (−d_m, d_{m−1})``, λ included (Eq. 10).

    offsets : (2, C) rad or m, rows d_{m−1} and d_m; frames : of the whole result, whose ends lack rows

    It is what the solve would leave of ``‖c‖² + λ ‖L R − δ‖²`` if this were the only seam, known before solving.
    """
    if place.stiffness < 1e-300:  # its inverse has left the range of doubles
        return 0.0
    (alone,) = clusters([place], frames)
    kernel = seam_kernel(cluster_rows(alone), place.frame - alone.start)
    s = np.stack([-offsets[1], offsets[0]])
    return float(np.einsum("ic,ij,jc->", s, kernel, s))
