"""What the sources of a result do by themselves around a seam, each among its own neighbours, some of which are not
part of the result: the measure of how much a seam may add without standing out.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_to_rotvec
from kinestitch.solve.placed import Placed, straddling, target_window
from kinestitch.solve.seam import SeamPlace

PERCENTILE = 95.0
"""What counts as a source's own strength: this percentile of it over the frames near the seam."""

AROUND = 1.0
"""s on each side of a seam in which its sources' own strength is looked at."""


def own_triples(placed: Placed, start: int, stop: int) -> Array:
    """Each source's own previous, present and next rotations for frames [start, stop): (3, n, J, 4)."""
    rotations, _ = target_window(placed, start - 1, stop + 1)
    triples = np.stack([rotations[:-2], rotations[1:-1], rotations[2:]])
    for seam in placed.seams:
        if start < seam.frame + 1 and seam.frame - 1 < stop:
            poses = straddling(placed, seam).rotations
            if start <= seam.frame - 1 < stop:
                triples[2, seam.frame - 1 - start] = poses[1]
            if start <= seam.frame < stop:
                triples[0, seam.frame - start] = poses[2]
    return triples


def velocity_between(before: Array, after: Array, fps: float) -> Array:
    """ω (..., 3) rad/s from rotations (..., 4) to those of the next frame, in the joint's own axes."""
    return quat_to_rotvec(quat_multiply(quat_conjugate(before), after)) * fps


def own_velocities(placed: Placed, start: int, stop: int) -> tuple[Array, Array, Array]:
    """Each source's own velocities at frames [start, stop): ω (n, J, 3) rad/s into and out of them, and those of the
    joint that carries the travel, (2, n, 3) m/s into and out of them.
    """
    fps = placed.timeline.fps
    rotations, translations = target_window(placed, start - 1, stop + 1)
    turns = velocity_between(rotations[:-1], rotations[1:], fps)
    moves = np.diff(translations[:, placed.carrier], axis=0) * fps
    into, out, ways = turns[:-1].copy(), turns[1:], np.stack([moves[:-1], moves[1:]])
    for seam in placed.seams:
        last, first = seam.frame - 1 - start, seam.frame - start
        if last >= -1 and first <= stop - start:
            around = straddling(placed, seam)
            own = velocity_between(around.rotations[[0, 2]], around.rotations[[1, 3]], fps)
            if last >= 0:
                out[last], ways[1, last] = own[0], (around.left_path[2] - around.left_path[1]) * fps
            if first < stop - start:
                into[first], ways[0, first] = own[1], (around.right_path[2] - around.right_path[1]) * fps
    return into, out, ways


@dataclass(frozen=True, slots=True)
class Strength:
    """How strongly the sources move around a seam, 95th percentiles over the frames within ``AROUND`` of it.

    acceleration, velocity : of each frame's strongest joint, rad/s² and rad/s; path : of the travel, m/s²
    """

    acceleration: float
    velocity: float
    path: float


def own_strength(placed: Placed, seam: SeamPlace) -> Strength:
    """What the sources show around a seam; 0 where the result is too short to show anything."""
    reach = max(1, round(AROUND * placed.timeline.fps))
    start, stop = max(1, seam.frame - reach), min(placed.frames - 1, seam.frame + reach)
    if stop - start < 2:
        return Strength(0.0, 0.0, 0.0)
    into, out, (before, after) = own_velocities(placed, start, stop)
    turning, path = _sizes((out - into) * placed.timeline.fps), _sizes((after - before) * placed.timeline.fps)
    speeds = np.maximum(_sizes(out[:-1]), _sizes(into[1:]))
    return Strength(*(float(np.percentile(sizes, PERCENTILE)) for sizes in (turning, speeds, path)))


def _sizes(vectors: Array) -> Array:
    """The size of each frame's largest vector: (n,) from (n, ..., 3)."""
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.sqrt((x * x + y * y + z * z).reshape(len(vectors), -1).max(axis=1))
