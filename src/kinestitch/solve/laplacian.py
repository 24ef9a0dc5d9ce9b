"""The temporal Laplacian and its banded solve, over whole clips: the plain form that everything else is checked
against.

    minimise  Σ_t W_t |R_t − R_tar,t|² + Σ_t Λ_t |(L R)_t − δ_t|²          (L R)_t = R_{t−1} − 2 R_t + R_{t+1}

Rows of L exist at interior frames only, so W = I and one Λ give the published system (I + λ LᵀL) R = R_tar + λ Lᵀδ
(Eq. 4). It is solved for the correction c = R − R_tar, never for R, which keeps twelve digits where R would lose them
(Eq. 5).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.rotation import Array
from kinestitch.errors import ParameterError


def second_difference(x: ArrayLike) -> Array:
    """``(L x)_t = x_{t−1} − 2 x_t + x_{t+1}`` along axis 0: (F, ...) → (F, ...), zero at the two ends where no row
    exists (Eq. 3).
    """
    x = np.asarray(x, dtype=np.float64)
    out = np.zeros(x.shape)
    if len(x) > 2:
        out[1:-1] = x[:-2] - 2 * x[1:-1] + x[2:]
    return out


def transposed_second_difference(e: ArrayLike) -> Array:
    """``Lᵀ e`` along axis 0: (F, ...) → (F, ...); the first and last row of `e` do not exist and are not looked at."""
    e = np.asarray(e, dtype=np.float64)
    out = np.zeros(e.shape)
    if len(e) > 2:
        inner = e[1:-1]
        out[:-2] += inner
        out[1:-1] -= 2 * inner
        out[2:] += inner
    return out


MAX_STIFFNESS = 1e12
"""Far above this λ the system is singular to double precision; its seams would reach over forty thousand frames."""


def check_stiffness(values: ArrayLike) -> None:
    """Raise ParameterError unless every λ lies in [0, ``MAX_STIFFNESS``]."""
    values = np.asarray(values, dtype=np.float64)
    bad = ~((values >= 0) & (values <= MAX_STIFFNESS))
    if bad.any():
        raise ParameterError(
            f"Expected a stiffness λ from 0 to {MAX_STIFFNESS:g}, got {values[bad].flat[0]:g}. "
            "A smoothing time τ in seconds means λ = (τ · fps)⁴."
        )


def check_smoothing(seconds: float, fps: float) -> None:
    """Raise ParameterError for a smoothing time in s whose λ = (seconds · fps)⁴ is above ``MAX_STIFFNESS``."""
    longest = MAX_STIFFNESS**0.25 / fps
    if not 0 <= seconds <= longest * (1 + 1e-9):
        raise ParameterError(
            f"Expected a smoothing time from 0 to {longest:.3g} s at {fps:g} fps, got {seconds:g} s. Try 0.1 to 0.5 s."
        )


def row_stiffness(stiffness: ArrayLike, frames: int) -> Array:
    """Λ per row (F,), zero at the ends; `stiffness` is one λ or (F,) of them. Raises ParameterError if negative or
    not finite.
    """
    values = np.asarray(stiffness, dtype=np.float64)
    check_stiffness(values)
    rows = np.zeros(frames)
    if frames > 2:
        rows[1:-1] = values if values.ndim == 0 else values[1:-1]
    return rows


def normal_bands(rows: Array, weights: Array | None = None) -> Array:
    """``W + LᵀΛL`` as upper bands (3, F) for ``scipy.linalg.solveh_banded``: symmetric, positive definite,
    pentadiagonal.

    rows : (F,) Λ, zero at the ends; weights : (F,) W, ones when left out
    """
    frames = len(rows)
    bands = np.zeros((3, frames), order="F")
    diagonal = 4 * rows
    diagonal[1:] += rows[:-1]
    diagonal[:-1] += rows[1:]
    bands[2] = diagonal + (1.0 if weights is None else weights)
    bands[1, 1:] = -2 * (rows[:-1] + rows[1:])
    bands[0, 2:] = rows[1:-1]
    return bands


def solve_bands(bands: Array, rhs: Array) -> Array:
    """Solve the banded system for every column of `rhs` (F, C)."""
    from scipy.linalg import solveh_banded

    return np.asarray(solveh_banded(bands, rhs, overwrite_ab=True, overwrite_b=True, check_finite=False))


def solve_indefinite_bands(bands: Array, rhs: Array) -> Array:
    """The same for a symmetric system (b + 1, F) that need not be positive definite. Raises LinAlgError where it is
    singular.
    """
    from scipy.linalg import solve_banded

    width = len(bands) - 1
    both = np.concatenate([bands, np.zeros((width, bands.shape[1]))])
    for k in range(1, width + 1):
        both[width + k, :-k] = bands[width - k, k:]
    return np.asarray(solve_banded((width, width), both, rhs, overwrite_ab=True, overwrite_b=True, check_finite=False))


def solve_full(target: ArrayLike, delta: ArrayLike, stiffness: ArrayLike, weights: ArrayLike | None = None) -> Array:
    """The whole clip at once (Eq. 4): (F, ...) values whose second differences follow `delta` and which stay near
    `target`.

    target, delta : (F, ...) rad or m; stiffness : λ or (F,) Λ; weights : (F,) W ≥ 0, at least two of them positive

    Minimises Σ W |R − target|² + Σ Λ |L R − delta|². Raises ParameterError for a negative stiffness or too few weights.
    """
    target = np.asarray(target, dtype=np.float64)
    rows = row_stiffness(stiffness, len(target))
    error = np.asarray(delta, dtype=np.float64) - second_difference(target)
    if weights is not None:
        weights = np.asarray(weights, dtype=np.float64)
        if (weights < 0).any() or np.count_nonzero(weights) < min(2, len(weights)):
            raise ParameterError("Expected weights ≥ 0 with at least two frames above 0, so that one solution exists.")
    rhs = transposed_second_difference(rows[:, None] * error.reshape(len(target), -1))
    try:
        return target + solve_bands(normal_bands(rows, weights), rhs).reshape(target.shape)
    except np.linalg.LinAlgError as error:
        raise ParameterError("Expected weights that leave one solution, got free frames without stiffness.") from error
