"""Component-first kernels: quaternions as four arrays, vectors as three, so that long clips run at memory speed.

The public functions of :mod:`kinestitch.core.rotation` are these with the components last; the solver, which works on
whole windows of whole bodies, uses them directly. Arrays broadcast like numpy's.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Parts = Sequence[Array] | Array


def split(values: Array) -> Array:
    """(..., K) values as (K, ...), each component contiguous."""
    out = np.empty((values.shape[-1], *values.shape[:-1]))
    for i in range(len(out)):
        out[i] = values[..., i]
    return out


def join(parts: Parts, out: Array | None = None) -> Array:
    """Components (...,) × K as one array (..., K), into `out` where it is given."""
    if out is None:
        out = np.empty((*np.broadcast_shapes(*(part.shape for part in parts)), len(parts)))
    for i, part in enumerate(parts):
        out[..., i] = part
    return out


def multiply(p: Parts, q: Parts) -> tuple[Array, Array, Array, Array]:
    """Hamilton product of quaternions in parts x, y, z, w."""
    px, py, pz, pw = p
    qx, qy, qz, qw = q
    x, y, z, w = pw * qx, pw * qy, pw * qz, pw * qw
    x += px * qw
    x += py * qz
    x -= pz * qy
    y -= px * qz
    y += py * qw
    y += pz * qx
    z += px * qy
    z -= py * qx
    z += pz * qw
    w -= px * qx
    w -= py * qy
    w -= pz * qz
    return x, y, z, w


def log(q: Parts, out: Array | None = None) -> Array:
    """Rotation vectors (3, ...) with angle ``2 atan2(‖v‖, w)`` in [0, 2π]; near the identity the series' leading term
    ``2v/w``. `out`, where it is given, may be the first three parts of `q`.
    """
    x, y, z, w = q
    out = np.empty((3, *np.shape(w))) if out is None else out
    sine = np.sqrt(x * x + y * y + z * z)
    if sine.min(initial=1.0) < 1e-150:  # squares have left the range of doubles; the series is exact here
        tiny = sine < 1e-150
        w_safe = np.where(tiny & (w != 0), w, 1.0)
        scale = np.where(tiny, 2.0 / w_safe, 2.0 * np.arctan2(sine, w) / np.where(tiny, 1.0, sine))
        turn = tiny & (w < 0)
        out[0] = np.where(turn, 2 * np.pi, scale * x)
        out[1] = np.where(turn, 0.0, scale * y)
        out[2] = np.where(turn, 0.0, scale * z)
        return out
    with np.errstate(divide="ignore"):
        scale = np.arctan(sine / w)  # twice as fast as arctan2
    if not w.min(initial=1.0) > 0:
        scale += np.pi * (scale < 0)
    scale /= sine
    scale *= 2.0
    np.multiply(scale, x, out=out[0, ...])
    np.multiply(scale, y, out=out[1, ...])
    np.multiply(scale, z, out=out[2, ...])
    return out


def exp(r: Parts, out: Array | None = None) -> Array:
    """Unit quaternions (4, ...) of rotation vectors of any length; ``w = cos(θ/2)`` keeps its sign. `out`, where it is
    given, may hold `r` in its first three parts.

    Sine and cosine come from one tangent of the quarter angle, which is faster than two calls; near the identity the
    scale is the series' leading term ½.
    """
    x, y, z = r
    out = np.empty((4, *np.shape(x))) if out is None else out
    half = x * x
    half += y * y
    half += z * z
    half = 0.5 * np.sqrt(half)
    tangent = np.tan(half * 0.5)
    square = tangent * tangent
    inverse = 1.0 / (1.0 + square)
    tangent *= inverse
    if half.min(initial=1.0) < 1e-150:
        tiny = half < 1e-150
        scale = np.where(tiny, 0.5, tangent / np.where(tiny, 1.0, half))
    else:
        scale = tangent / half
    np.multiply(scale, x, out=out[0, ...])
    np.multiply(scale, y, out=out[1, ...])
    np.multiply(scale, z, out=out[2, ...])
    np.multiply(1.0 - square, inverse, out=out[3, ...])
    return out
