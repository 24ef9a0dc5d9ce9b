"""Offsets that fade: the right source starts where the left one was, and the difference dies away in the frames after.

The offset between both sources and its velocity are taken at the last frame before the seam; what follows is the right
source plus that offset, which a critically damped spring or a polynomial brings to rest. The left source's frames stay
as they are, which is what a game needs, where the future is not known; the price is that the right side bears the whole
gap. :func:`hermite` can also share the gap between both sides.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.errors import ParameterError
from kinestitch.solve.placed import Placed, straddling, target_window
from kinestitch.solve.rivals.gap import add_offset, check_halflife, check_width, gap_between, rooms, spans
from kinestitch.solve.solved import as_motion

Sides = Literal["after", "both"]

_SPENT = 32.0  # (1 + s) exp(−s) is below 1e-12 from here on


def spring_decay(frames: Array, halflife: float) -> tuple[Array, Array]:
    """What a critically damped spring leaves of an offset x₀ and of its velocity v₀ after some time:

        x(t) = exp(−y t) (x₀ (1 + y t) + v₀ t) ,   y = 2 ln 2 / halflife

    frames, halflife : in one unit of time, which is that of v₀ too. Returns the two shares, shaped like `frames`.

    Source: D. Holden, *Spring-It-On: The Game Developer's Spring-Roll-Call* (theorangeduck.com, 2021), whose half-life
    this is.
    """
    y = 2 * math.log(2) / halflife
    left = np.exp(-y * frames)
    return left * (1 + y * frames), left * frames


def hermite_decay(share: Array, degree: int) -> tuple[Array, Array]:
    """What a Hermite polynomial leaves of an offset and of its velocity (times the window's length) at a share of it.

    share : in [0, 1] of the window; degree 3: position and velocity end at zero, 5: acceleration starts and ends at
    zero as well. Both shares are 0 at 1.
    """
    s = np.clip(share, 0.0, 1.0)
    if degree == 3:
        return 1 - s**2 * (3 - 2 * s), s * (1 - s) ** 2
    if degree == 5:
        return 1 - s**3 * (10 - s * (15 - 6 * s)), s - s**3 * (6 - s * (8 - 3 * s))
    raise ParameterError(f"Expected degree 3 or 5, got {degree}.")


def inertialize(placed: Placed, halflife: float) -> Motion:
    """Critically damped inertialization: the right source takes over at once, and a spring brings the offset to rest.

    halflife : s, > 0; the spring's y is 2 ln 2 / halflife (:func:`spring_decay`)

    For rotations the offset is the rotation vector x with ``a = exp(x) b`` in the parent's frame, for translations and
    for the carrier's path a − b, each with its velocity from the sources' own frames m−1 and m. Frames before the seam
    are the left source's, and so, to 1e-12, are those of the right source after 32/y seconds. At a further seam within
    that time what is left of the offset belongs to its left side.

    Source: D. Bollo, *Inertialization: High-Performance Animation Transitions in Gears of War* (GDC 2018), with the
    spring of D. Holden, *Spring-It-On* (2021) in place of the quintic.

    Raises ParameterError for a half-life that is not positive.
    """
    check_halflife(halflife)
    rotations, translations = target_window(placed, 0, placed.frames)
    length = halflife * placed.timeline.fps
    reach = math.ceil(_SPENT * length / (2 * math.log(2)))
    left_over = None  # of the seam before: where its time starts, offset and velocity
    for seam, end in spans(placed):
        around = straddling(placed, seam)
        poses, places = around.rotations.copy(), around.translations.copy()
        if left_over is not None:
            since, x, v = left_over
            own = _faded(np.arange(seam.frame - 1, seam.frame + 1) - since, length, x, v)
            poses[:2], places[:2] = add_offset(poses[:2], places[:2], own)
        x, v = gap_between(poses, places).start
        left_over = (seam.frame - 1, x, v)
        here = slice(seam.frame, min(end, seam.frame + reach))
        offset = _faded(np.arange(here.start, here.stop) - (seam.frame - 1), length, x, v)
        rotations[here], translations[here] = add_offset(rotations[here], translations[here], offset)
    return as_motion(placed, rotations, translations)


def _faded(frames: np.ndarray, halflife: float, x: Array, v: Array) -> Array:
    """Offsets (n, J, 6) some frames after the spring was let go with x and v, (J, 6) each."""
    of_place, of_speed = spring_decay(frames.astype(np.float64), halflife)
    return of_place[:, None, None] * x + of_speed[:, None, None] * v


def hermite(placed: Placed, width: int, *, degree: int = 3, sides: Sides = "after") -> Motion:
    """Blend the offset and its velocity out by a Hermite polynomial that ends after `width` frames.

    width : frames, at least 1, no more than the segment has (with ``both``: than half way to the next seam)
    degree : 3 ends at rest, 5 also starts and ends without acceleration (:func:`hermite_decay`)
    sides : ``after`` leaves the left source as it is and lets the right one bear the whole gap; ``both`` gives each
    side half of it, so that they meet half way with the mean of both velocities, as no game can but an editor may

    Offsets as in :func:`inertialize`; ``both`` takes them half way between frames m−1 and m. All frames outside the
    window are the sources'.

    Source: degree 5 is the blend-out of D. Bollo, *Inertialization* (GDC 2018), without his overshoot clamp; degree 3
    is the cubic Hermite interpolant.

    Raises ParameterError for width < 1 or another degree.
    """
    check_width(width)
    hermite_decay(np.zeros(1), degree)
    rotations, translations = target_window(placed, 0, placed.frames)
    for (seam, before, after), (_, end) in zip(rooms(placed), spans(placed), strict=True):
        around = straddling(placed, seam)
        gap = gap_between(around.rotations, around.translations)
        if sides == "both":
            (x, v), length = gap.middle, max(1, min(width, before, after))
            runs = [(0.5, np.arange(0.5, length), 1.0), (-0.5, -np.arange(0.5, length), -1.0)]
        else:
            (x, v), length = gap.start, max(1, min(width, end - seam.frame))
            runs = [(1.0, np.arange(1.0, length + 1), 1.0)]
        origin = seam.frame - (0.5 if sides == "both" else 1.0)
        for share, frames, direction in runs:
            here = np.rint(origin + frames).astype(np.intp)
            of_place, of_speed = hermite_decay(np.abs(frames) / length, degree)
            speed = v * (direction * length)
            offset = share * (of_place[:, None, None] * x + of_speed[:, None, None] * speed)
            rotations[here], translations[here] = add_offset(rotations[here], translations[here], offset)
    return as_motion(placed, rotations, translations)
