"""How a foot gets from one stance to the next: by offsets to its solved way, which are known where it stands."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.ndimage import convolve1d, minimum_filter1d

from kinestitch.core.rotation import Array
from kinestitch.solve.contacts import Mask, runs
from kinestitch.solve.laplacian import normal_bands, solve_bands
from kinestitch.solve.seam import VISIBLE

GROUND = (0, 2)

_FIRM = 30.0  # weight of a height that shall be reached, beside 1 of the solved height
_ROUNDS = 4  # in which the frames are found that fall short of it
_CLEAR, _FAST, _AROUND = 0.07, 0.3, 0.15  # leg lengths, leg lengths per second, s
_LIFT, _HIGHEST = 0.2, 0.04  # of a step's length, leg lengths


def carry_over(
    offsets: Array, known: Mask, reach: float, *, wanted: Array | None = None, breaks: Sequence[int] = ()
) -> Array:
    """Offsets (n, C), known in some frames, carried over to the others as a gap of the solve is (Eq. 25).

    known : (n,); reach : frames in which they die away, or in which they bend from one stance to the next
    wanted : (n, C) what is asked for, firmly, in the frames that are not known; NaN where nothing is
    breaks : frames before which there is a hard cut, over which nothing is carried
    """
    out = np.where(known[:, None], offsets, 0.0)
    asked = None if wanted is None else np.isfinite(wanted[:, 0]) & ~known
    if known.all() or not (known.any() or (asked is not None and asked.any())):
        return out
    rows = np.full(len(known), (reach / VISIBLE) ** 4)
    rows[[0, -1]] = 0.0
    for m in breaks:
        rows[m - 1 : m + 1] = 0.0
    weights = None if asked is None else np.where(asked, 1.0 + _FIRM, 1.0)
    bands = normal_bands(rows, weights)
    rhs = np.zeros(out.shape, order="F")
    if wanted is not None and asked is not None:
        rhs[asked] = _FIRM * wanted[asked]
    for k in (1, 2):
        band, later, earlier = bands[2 - k, k:], known[k:], known[:-k]
        rhs[k:] -= np.where(~later & earlier, band, 0.0)[:, None] * out[:-k]
        rhs[:-k] -= np.where(later & ~earlier, band, 0.0)[:, None] * out[k:]
        band[later | earlier] = 0.0
    bands[2, known] = 1.0
    rhs[known] = out[known]
    return solve_bands(bands, rhs)


def carry_heights(offsets: Array, known: Mask, least: Array, reach: float, breaks: Sequence[int] = ()) -> Array:
    """Like :func:`carry_over` for heights (n,) that shall not fall short of `least` (n,) in frames that are not known.

    It is asked for, not enforced: a corner would be a kick.
    """
    out, wanted = offsets, np.full((len(known), 1), np.nan)
    for _ in range(_ROUNDS):
        out = carry_over(offsets[:, None], known, reach, wanted=wanted, breaks=breaks)[:, 0]
        short = ~known & (out < least) & np.isnan(wanted[:, 0])
        if not short.any():
            break
        wanted[short, 0] = least[short]
    return out


def floor_under(heights: Array, reach: float) -> Array:
    """The lowest (n,) m that a foot of the placed sources comes within `reach` frames."""
    return np.asarray(minimum_filter1d(heights, 2 * round(reach) + 1, mode="nearest"))


def clearance(path: Array, source: Array, *, seams: Sequence[int], fps: float, leg: float) -> Array:
    """How high (n,) m over the floor a foot has to be that moves faster over the ground than its source does.

    path, source : (n, 2) m, ways over the ground; leg : m
    """
    if len(path) < 2:
        return np.zeros(len(path))
    steps = np.linalg.norm(np.diff(source, axis=0), axis=1)
    steps[[m - 1 for m in seams]] = 0.0
    own = np.minimum(np.append(steps[0], steps), np.append(steps, steps[-1]))
    speed = np.linalg.norm(np.gradient(path, axis=0), axis=1)
    excess = np.maximum(speed - own, 0.0) * fps / (_FAST * leg)
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
