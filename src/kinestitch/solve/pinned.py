"""Pins as numbers: the least correction that brings some frames to given values, exactly or as far as they weigh.

    minimise  ‖c‖² + ‖L c‖²_Λ  with  c_p = gap_p  for exact pins,  plus w_p / G_pp · |c_p − gap_p|² for others  (Eq. 30)

Everything the seams have decided counts as the target here, which is the same as solving seams and pins together where
they share Λ. G is the inverse of I + LᵀΛL, so that a lone pin of weight w goes w / (w + 1) of the way, wherever it is
and however stiff the curve.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.rotation import Array
from kinestitch.solve.laplacian import normal_bands, solve_bands

Frames = NDArray[np.intp]


def pinned_correction(rows: Array, frames: Frames, gaps: Array, weights: Array) -> Array:
    """The correction (n, C) of a window of n frames that takes pinned frames over their gaps (Eq. 30).

    rows : (n,) Λ, zero at both ends; frames : (m,) different ones; gaps : (m, C) rad or m; weights : (m,), inf is exact

    Exact pins are eliminated, which keeps all digits however near to each other they stand; for the others the update
    ``c += G (G_pp + diag(1/w))⁻¹ (gap − c_p)`` is made in what is left.
    """
    bands = normal_bands(rows)
    exact = np.isinf(weights)
    fixed, free = frames[exact], frames[~exact]
    values = np.zeros((len(rows), gaps.shape[1]))
    values[fixed] = gaps[exact]
    rhs = -banded_product(bands, values)
    rhs[fixed] = gaps[exact]
    reduced = eliminated(bands, fixed)
    out = solve_bands(reduced.copy(order="F"), rhs)
    if len(free):
        curves = _columns(bands, free)
        give = np.diag(curves[free]) / weights[~exact]
        if len(fixed):
            curves = _columns(reduced, free)
            curves[fixed] = 0.0  # a pin on a fixed frame has no say
        out += curves @ np.linalg.solve(curves[free] + np.diag(give), gaps[~exact] - out[free])
    return out


def eliminated(bands: Array, fixed: Frames) -> Array:
    """A symmetric system in upper bands (b + 1, n) whose fixed unknowns stand alone, with 1 on their diagonal."""
    out = bands.copy(order="F")
    width = len(bands) - 1
    out[width, fixed] = 1.0
    for k in range(1, width + 1):
        out[width - k, fixed] = 0.0
        out[width - k, fixed[fixed + k < bands.shape[1]] + k] = 0.0
    return out


def banded_product(bands: Array, values: Array) -> Array:
    """The product (n, C) of a symmetric matrix in upper bands (b + 1, n) with values (n, C)."""
    width = len(bands) - 1
    out = bands[width][:, None] * values
    for k in range(1, width + 1):
        band = bands[width - k, k:][:, None]
        out[k:] += band * values[:-k]
        out[:-k] += band * values[k:]
    return out


def _columns(bands: Array, frames: Frames) -> Array:
    """Columns (n, m) of the inverse of a banded system."""
    unit = np.zeros((bands.shape[1], len(frames)), order="F")
    unit[frames, np.arange(len(frames))] = 1.0
    return solve_bands(bands.copy(order="F"), unit)


def path_rows(rows: Array, *, started: bool) -> Array:
    """The bands (3, n) of ``I + LᵀΛL`` on the n intervals of a path that goes on unchanged behind its last frame, and
    in front of its first one too where it has `started` before; L's rows that reach over those frames count.

    rows : (n,) Λ of the intervals
    """
    before = 2 if started else 0
    padded = np.concatenate([np.full(before, rows[0]), rows, np.full(2, rows[-1])])
    padded[0] = padded[-1] = 0.0
    return normal_bands(padded)[:, before : before + len(rows)].copy(order="F")


def pinned_path(bands: Array, frames: Frames, gaps: Array, weights: Array) -> Array:
    """What the positions (n + 1, C) m of a path gain so that it passes its pins; it starts where it was (Eq. 31).

        minimise  ‖u‖² + ‖L u‖²_Λ   with  Σ_{k<p} u_k = gap_p ,      u the change of the displacements

    bands : (3, n) of :func:`path_rows`; frames : (m,) from 1 to n, the last one n; gaps : (m, C) m; weights : (m,)

    Pins of a path are dense in displacements. So the sums up to every frame are unknowns too, each tied to the one
    before by a Lagrange multiplier, and the system stays banded: its cost grows with n alone, and near pins cost no
    digits.
    """
    from scipy.linalg import solve_banded

    exact, count = np.isinf(weights), bands.shape[1]
    give, size = np.zeros(count), float(bands[2].max())
    give[frames[~exact] - 1] = weights[~exact] / (_lone_sums(bands, frames[~exact]) * size)
    rhs = np.zeros((3 * count, gaps.shape[1]))
    rhs[3 * frames - 1] = np.where(exact, 1.0, give[frames - 1])[:, None] * gaps
    system = _chained(bands / size, give, frames[exact] - 1)
    solved = solve_banded((_WIDE, _WIDE), system, rhs, overwrite_ab=True, overwrite_b=True, check_finite=False)
    return np.concatenate([np.zeros((1, gaps.shape[1])), solved[2::3]])


_WIDE = 6


def _chained(bands: Array, give: Array, fixed: Frames) -> Array:
    """The system of a pinned path in bands for ``scipy.linalg.solve_banded``.

    Its unknowns are, interval by interval, the displacement u_k, the multiplier ν_k and the sum c_{k+1} up to there;
    its equations M u = ν, c_{k+1} − c_k = u_k, and ν_k − ν_{k+1} = give_k (gap_k − c_{k+1}), or c_{k+1} = gap_k where
    it is fixed.
    """
    count = bands.shape[1]
    system = np.zeros((2 * _WIDE + 1, 3 * count))

    def put(row: Frames, column: Frames, value: Array | float) -> None:
        system[_WIDE + row - column, column] = value

    u = 3 * np.arange(count)
    nu, c = u + 1, u + 2
    for off in range(3):
        put(u[: count - off], u[off:], bands[2 - off, off:])
        put(u[off:], u[: count - off], bands[2 - off, off:])
    put(u, nu, -1.0)
    put(nu, u, -1.0)
    put(nu, c, 1.0)
    put(nu[1:], c[:-1], -1.0)
    put(c, nu, 1.0)
    put(c[:-1], nu[1:], -1.0)
    put(c, c, give)
    put(c[fixed], nu[fixed], 0.0)
    inner = fixed[fixed < count - 1]
    put(c[inner], nu[inner + 1], 0.0)
    put(c[fixed], c[fixed], 1.0)
    return system


def _lone_sums(bands: Array, frames: Frames) -> Array:
    """For each pin alone, its own entry (m,) of the inverse of its system: of the sums of `bands`' inverse."""
    if not len(frames):
        return np.zeros(0)
    ones = (np.arange(bands.shape[1])[:, None] < frames).astype(np.float64)
    return np.asarray(np.einsum("km,km->m", ones, solve_bands(bands.copy(order="F"), ones.copy(order="F"))))


def nearest(count: int, frames: Array | Frames, values: Array) -> Array:
    """For each of `count` frames the value (count,) of the pinned frame (m,) next to it; frames ascend."""
    between = (np.asarray(frames[1:], dtype=np.float64) + frames[:-1]) / 2
    return np.asarray(values[np.searchsorted(between, np.arange(count))])
