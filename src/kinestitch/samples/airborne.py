"""Bodies in the air: the hips of a jump follow a parabola between take-off and landing, and sink into it softly."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.samples.curves import Curve, pieces, through

GRAVITY = 9.81


def hops(
    flights: Sequence[tuple[float, float, float, float]],
    grounded: Sequence[Sequence[tuple[float, float]]],
) -> Curve:
    """Height (F, 1) m of the hips over several jumps.

    flights : rows ``(take-off s, landing s, height at take-off m, height at landing m)``; the parabola follows
    grounded : the keys ``(time, height)`` before, between and after the flights, one list more than flights; the
        first list starts and the last one ends at rest
    """
    bounds, curves = [grounded[0][0][0]], []
    rest = np.zeros((2, 1))
    state, at = rest, None
    for (off, on, rise, fall), keys in zip(flights, grounded[:-1], strict=True):
        speed = (fall - rise) / (on - off) + 0.5 * GRAVITY * (on - off)
        leave = np.array([[speed], [-GRAVITY]])
        land = np.array([[speed - GRAVITY * (on - off)], [-GRAVITY]])
        rows = [*([at] if at else []), *keys, (off, rise)]
        curves.append(through([r[0] for r in rows], [[r[1]] for r in rows], state, leave))
        curves.append(through([off, on], [[rise], [fall]], leave, land))
        bounds += [off, on]
        state, at = land, (on, fall)
    rows = [*([at] if at else []), *grounded[-1]]
    curves.append(through([r[0] for r in rows], [[r[1]] for r in rows], state, rest))
    return pieces([*bounds, rows[-1][0]], curves)


def beside(horizontal: Curve, height: Curve) -> Curve:
    """Position (F, 3) from x and z (F, 2) and a height (F, 1)."""

    def at(t: Array) -> Array:
        ground = horizontal(t)
        return np.stack([ground[:, 0], height(t)[:, 0], ground[:, 1]], axis=-1)

    return at
