"""A clip bent round until its ends meet: what stands before its first frame and after its last one.

Like any seam, that of a loop looks at the clip's own next frame beyond each end of the cycle. Where the cycle is cut
out of a longer clip they are there. Where the clip ends they are not, and an end goes on steadily. But a clip that is a
cycle says itself how it crosses the seam, whether it repeats its first pose at its end or stops one frame before: that
step is taken at both ends, as long as the joint changes its velocity as much elsewhere in the cycle (Eq. 22).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_about_axis,
    quat_conjugate,
    quat_distance,
    quat_multiply,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import FrameRange
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.root import GROUND, seam_yaw
from kinestitch.solve.window import hips_to_world

Allowed = tuple[float, float] | None

SAME_TURN, SAME_PLACE = np.radians(1.0), 0.01
"""rad and m within which two frames show one pose."""

LIKELY = 1.5
"""Times what 95 of 100 steps within a clip do not exceed: by so much the step from its last frame to its first may lie
off the mean of the steps beside it, if the clip is to be a cycle.
"""

SPIN, PUSH = np.radians(5.0), 0.1
"""rad/s and m/s by which a change of velocity at the seam may exceed the largest in the cycle and still be its own."""


@dataclass(frozen=True, eq=False, slots=True)
class Welded:
    """A cycle of N frames with one more at either end; made by :func:`weld` only.

    rotations : (N + 2, J, 4) of frames −1 … N; those of `upright` are told in the world, the hips even below a carrier
    translations : (N + 2, J, 3) m, the carrier's in the world and without its place on the ground
    yaw : rad by which the next cycle is turned against this one, in (−π, π]
    steps : (N, 2) m, the way over the ground in each interval, the seam's last, told in a frame that turns along
    ends : (2, 2) m, the same for the clip's own way into the first frame and out of the last one
    path_gaps : (3, 2) m, by how much the ways of both ends differ in the intervals N−2, N−1 and N
    upright : the joints that turn with the placement: the carrier, and the hips below it
    repeats : whether the clip has one frame beyond the cycle, and it shows the pose at the cycle's other end again
    """

    rotations: Array
    translations: Array
    yaw: float
    steps: Array
    ends: Array
    path_gaps: Array
    upright: tuple[int, ...]
    repeats: bool

    @property
    def frames(self) -> int:
        """Number of frames N of the cycle."""
        return len(self.steps)


def weld(told: Motion, span: FrameRange, carrier: int) -> Welded:
    """The frames `span` of a clip as a cycle whose ends know each other; at least two frames.

    told : with its carrier in the world (:func:`kinestitch.rig.carrier.with_world_carrier`)
    """
    chain = told.skeleton.chain(hips_joint(told.skeleton))
    way = chain[chain.index(carrier) :]
    rotations = told.rotations.copy()
    hips_to_world(way, rotations)
    upright = (way[0], way[-1]) if len(way) > 1 else way
    positions = told.translations.copy()
    positions[:, carrier, GROUND] = 0.0
    shared = _shared_frame(rotations, positions, span, upright)
    step = _step_across(told.skeleton, rotations, upright) if len(span) == told.frames else None
    over = None if shared is None and step is None else (SPIN / told.fps, PUSH / told.fps)
    around = _rotations_around(rotations, span, step, over)
    hips = upright[-1]
    left, right = around[[-2, -1], hips], around[[0, 1], hips]
    if shared is not None:
        left, right = (rotations[[frame, frame], hips] for frame in shared)
    yaw = _half_turn(seam_yaw(told.skeleton, left, right))
    steps, ends, gaps = _ground(told.translations[:, carrier][:, GROUND], span, yaw, over)
    beyond = _positions_around(positions, span, over)
    return Welded(around, beyond, yaw, steps, ends, gaps, upright, shared is not None)


def _shared_frame(
    rotations: Array, positions: Array, span: FrameRange, upright: tuple[int, ...]
) -> tuple[int, int] | None:
    """Where the clip has one frame beyond the cycle, and it shows the pose at the cycle's other end again: both frames,
    the one in line with the cycle's end first.
    """
    if (span.start > 0) == (span.stop < len(rotations)):
        return None
    pair = (span.stop, 0) if span.start == 0 else (span.stop - 1, span.start - 1)
    first, second = rotations[list(pair)]
    apart = quat_distance(first, second)
    between = quat_multiply(second, quat_conjugate(first))[list(upright)]
    apart[list(upright)] = 2 * np.arcsin(np.minimum(np.hypot(between[:, 0], between[:, 2]), 1.0))  # all but the yaw
    moved = np.linalg.norm(positions[pair[0]] - positions[pair[1]], axis=-1)
    return pair if apart.max() <= SAME_TURN and moved.max() <= SAME_PLACE else None


def _half_turn(yaw: float) -> float:
    """The same yaw within (−π, π]."""
    return float(np.pi - (np.pi - yaw) % (2 * np.pi))


def _step_across(skeleton: Skeleton, rotations: Array, upright: tuple[int, ...]) -> Array | None:
    """The steps (J, 3) rad from a clip's last frame to its first one, placed, if they fit in between the steps beside
    them as well as others do; else None, the clip is no cycle.
    """
    steps = _turns(rotations[:-1], rotations[1:])
    hips = upright[-1]
    first, last = rotations[[0, -1], hips]
    before, after = (
        quat_multiply(first, rotvec_to_quat(-steps[0, hips])),
        quat_multiply(last, rotvec_to_quat(steps[-1, hips])),
    )
    yaw = seam_yaw(skeleton, np.stack([last, after]), np.stack([before, first]))
    following = rotations[0].copy()
    following[list(upright)] = quat_multiply(quat_about_axis(1, _half_turn(yaw)), following[list(upright)])
    across = _turns(rotations[-1], following)
    around = np.concatenate([steps, across[None], steps[:1]])
    off = np.linalg.norm(around[1:-1] - (around[:-2] + around[2:]) / 2, axis=(1, 2))
    return across if len(off) > 2 and off[-1] <= LIKELY * np.percentile(off[:-2], 95) else None


def _rotations_around(rotations: Array, span: FrameRange, across: Array | None, over: Allowed) -> Array:
    """Rotations (N + 2, J, 4) of the cycle and of the frames beyond its ends."""
    cycle = rotations[span.start : span.stop]
    into = _turns(rotations[span.start - 1], cycle[0]) if span.start > 0 else None
    out = _turns(cycle[-1], rotations[span.stop]) if span.stop < len(rotations) else None
    into, out = _meeting(_turns(cycle[:-1], cycle[1:]), into, out, across, over and over[0])
    before, after = quat_multiply(cycle[0], rotvec_to_quat(-into)), quat_multiply(cycle[-1], rotvec_to_quat(out))
    return np.concatenate([before[None], cycle, after[None]])


def _positions_around(positions: Array, span: FrameRange, over: Allowed) -> Array:
    """Translations (N + 2, J, 3) of the cycle and of the frames beyond its ends."""
    cycle = positions[span.start : span.stop]
    into = cycle[0] - positions[span.start - 1] if span.start > 0 else None
    out = positions[span.stop] - cycle[-1] if span.stop < len(positions) else None
    into, out = _meeting(np.diff(cycle, axis=0), into, out, cycle[0] - cycle[-1], over and over[1])
    return np.concatenate([(cycle[0] - into)[None], cycle, (cycle[-1] + out)[None]])


def _turns(first: Array, second: Array) -> Array:
    """Steps (..., 3) rad from one rotation to the next, in the joint's own axes."""
    return quat_to_rotvec(quat_multiply(quat_conjugate(first), second))


def _meeting(
    steps: Array, into: Array | None, out: Array | None, across: Array | None, over: float | None
) -> tuple[Array, Array]:
    """The steps (..., C) into the first frame and out of the last one (Eq. 22).

    steps : (N − 1, ..., C) within the cycle; into, out : the clip's own, where it has them
    across : the step from the last frame to the first, for a clip that has neither
    over : of a clip that is a cycle and so has one step for both: by how much its changes of velocity there may exceed
    the largest within; None for all others
    """
    across = into if into is not None else out if out is not None else across
    if over is None or across is None:
        return steps[0] if into is None else into, steps[-1] if out is None else out
    bound = np.linalg.norm(np.diff(steps, axis=0), axis=-1).max(axis=0, initial=0.0) + over
    return _towards(steps[0], across, bound), _towards(steps[-1], across, bound)


def _towards(step: Array, other: Array, bound: Array) -> Array:
    """The other step where it differs by no more than the bound, and ever less of the difference beyond."""
    gap = other - step
    share = (bound / np.maximum(np.linalg.norm(gap, axis=-1), bound)) ** 2
    return np.asarray(step + share[..., None] * gap)


def _ground(path: Array, span: FrameRange, yaw: float, over: Allowed) -> tuple[Array, Array, Array]:
    """Steps (N, 2), ends (2, 2) and gaps (3, 2) m of a path (F, 2), in the frame that turns along (Eq. 21).

    How far the body goes over the seam is the mean of what both ends say, or what the clip shows.
    """
    frames, first = len(span), max(-2, -span.start)
    intervals = np.arange(first, min(frames, len(path) - 2 - span.start) + 1)
    own = path[span.start + intervals + 1] - path[span.start + intervals]
    own = turned(own, -yaw * (intervals + 0.5) / frames)
    steps = own[-first : frames - 1 - first]
    into = own[-first - 1] if first <= -1 else None
    out = own[frames - 1 - first] if intervals[-1] >= frames - 1 else None
    shown = out if into is None else into
    into, out = _meeting(steps, into, out, (steps[0] + steps[-1]) / 2, over and over[1])
    across = (into + out) / 2 if over is None or shown is None else shown
    middle = out - into
    before = steps[-1] - own[0] if first == -2 else middle
    after = own[-1] - steps[0] if intervals[-1] == frames else middle
    return np.concatenate([steps, across[None]]), np.stack([into, out]), np.stack([before, middle, after])


def turned(ground: Array, yaw: Array) -> Array:
    """Vectors (n, 2) on the ground, each turned by its yaw (n,) rad about the upright."""
    cosine, sine = np.cos(yaw), np.sin(yaw)
    x, z = ground[:, 0], ground[:, 1]
    return np.stack([cosine * x + sine * z, cosine * z - sine * x], axis=-1)
