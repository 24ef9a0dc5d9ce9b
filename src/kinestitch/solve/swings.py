"""How a foot gets from one stance to the next: by offsets to its solved way, which are known where it stands."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.ndimage import convolve1d, minimum_filter1d

from kinestitch.core.rotation import Array
from kinestitch.solve.contacts import Mask, runs
from kinestitch.solve.laplacian import normal_bands, solve_bands
from kinestitch.solve.seam import VISIBLE

GROUND = (0, 2)

_CLEAR, _FAST, _AROUND = 0.05, 0.3, 0.15  # leg lengths, leg lengths per second, s
_LIFT, _HIGHEST = 0.2, 0.04  # of a step's length, leg lengths
_RISE, _ROUNDED = 0.2, 0.1  # s in which a foot rises, and over which what it lacks is averaged


def carry_over(offsets: Array, known: Mask, reach: float, *, breaks: Sequence[int] = ()) -> Array:
    """Offsets (n, C), known in some frames, carried over to the others as a gap of the solve is (Eq. 25).

    known : (n,); reach : frames in which they die away, or in which they bend from one stance to the next
    breaks : frames before which there is a hard cut, over which nothing is carried
    """
    out = np.where(known[:, None], offsets, 0.0)
    if known.all() or not known.any():
        return out
    rows = np.full(len(known), (reach / VISIBLE) ** 4)
    rows[[0, -1]] = 0.0
    for m in breaks:
        rows[m - 1 : m + 1] = 0.0
    bands = normal_bands(rows)
    rhs = np.zeros(out.shape, order="F")
    for k in (1, 2):
        band, later, earlier = bands[2 - k, k:], known[k:], known[:-k]
        rhs[k:] -= np.where(~later & earlier, band, 0.0)[:, None] * out[:-k]
        rhs[:-k] -= np.where(later & ~earlier, band, 0.0)[:, None] * out[k:]
        band[later | earlier] = 0.0
    bands[2, known] = 1.0
    rhs[known] = out[known]
    return solve_bands(bands, rhs)


def eased_lift(lacking: Array, known: Mask, fps: float) -> Array:
    """By how much (n,) m a foot is lifted in its swings that lacks some height (n,) m; negative is none.

    known : (n,) frames in which it is not lifted. It leaves them and comes back without a step in height, speed or
    acceleration; what it lacks beside them it does not get.
    """
    lift = smoothed(np.where(known, 0.0, np.maximum(lacking, 0.0)), max(1, round(_ROUNDED * fps)))
    lift[known] = 0.0
    for start, stop in runs(~known):
        frames, count = np.arange(1, stop - start + 1), stop - start + 1
        before = frames if start > 0 else np.full(count - 1, count)
        after = count - frames if stop < len(known) else np.full(count - 1, count)
        share = np.clip(np.minimum(before, after) / min(_RISE * fps, count / 2), 0.0, 1.0)
        lift[start:stop] *= share**3 * (10 + share * (6 * share - 15))
    return lift


def floor_under(heights: Array, reach: float) -> Array:
    """The lowest (n,) m that a foot of the placed sources comes within `reach` frames."""
    return np.asarray(minimum_filter1d(heights, 2 * round(reach) + 1, mode="nearest"))


def clearance(path: Array, source: Array, *, own: Mapping[int, float], fps: float, leg: float) -> Array:
    """How high (n,) m over the floor a foot has to be that moves faster over the ground than its source does.

    path, source : (n, 2) m, ways over the ground; leg : m
    own : by the frame after a seam, m that the sources go over its interval, where `source` jumps
    """
    if len(path) < 2:
        return np.zeros(len(path))
    steps = np.linalg.norm(np.diff(source, axis=0), axis=1)
    for m, length in own.items():
        steps[m - 1] = length
    more = np.maximum(np.linalg.norm(np.diff(path, axis=0), axis=1) - steps, 0.0)
    excess = np.maximum(np.append(more[0], more), np.append(more, more[-1])) * fps / (_FAST * leg)
    return smoothed(_CLEAR * leg * -np.expm1(-excess), max(1, round(_AROUND * fps)))


def step_arcs(stands: Mask, released: Mask, places: Array, leg: float) -> Array:
    """The arc (n,) m over the floor of every step that takes the place of contacts, higher where it is longer.

    stands, released : (n,) frames in which the foot stands, and in which it stood in its source but does not now
    places : (n, 2) m, where it stands on the ground; leg : m
    """
    arcs = np.zeros(len(stands))
    for start, stop in runs(~stands):
        if start > 0 and stop < len(stands) and released[start:stop].any():
            length = float(np.linalg.norm(places[stop] - places[start - 1]))
            share = np.arange(1, stop - start + 1) / (stop - start + 1)
            arcs[start:stop] = min(_LIFT * length, _HIGHEST * leg) * 16 * (share * (1 - share)) ** 2
    return arcs


def smoothed(values: Array, half: int) -> Array:
    """Values (n,) averaged over `half` frames on both sides, the near ones more."""
    bell = np.hanning(2 * half + 3)[1:-1]
    return np.asarray(convolve1d(values, bell / bell.sum(), mode="nearest"))


def ease(share: Array) -> Array:
    """0 to 1 without a step in value or slope."""
    s = np.clip(share, 0.0, 1.0)
    return s * s * (3 - 2 * s)
