"""Pins of single joints' rotations: curves in vectors around the pinned poses, on windows around the pins.

The vectors are measured from the mean of what the joint does and what it shall do in the pinned frames, and followed
continuously; each pinned pose takes the branch nearest to what it replaces. Where a joint turns almost all the way
round near its pins, the correction lives in its own axes instead: q · exp(c) (Eq. 34).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_continuous,
    quat_log,
    quat_mean,
    quat_multiply,
    quat_normalize,
    quat_to_rotvec,
    rotvec_to_quat,
)
from kinestitch.edit.pins import Pin
from kinestitch.errors import ParameterError
from kinestitch.solve.chart import OVERTURN
from kinestitch.solve.laplacian import check_smoothing
from kinestitch.solve.pinned import Frames, pinned_correction
from kinestitch.solve.seam import Cluster, SeamPlace, cluster_rows, clusters, visible_reach

TURNING = 0.15
"""s, the smoothing time of a joint's pin that says nothing else."""


@dataclass(frozen=True, eq=False, slots=True)
class Turn:
    """A joint's local rotation (4,) wanted in one frame; pin : the one that asks for it."""

    joint: int
    rotation: Array
    pin: Pin


def pin_windows(pins: Sequence[Pin], frames: int, fps: float, own: float) -> tuple[Cluster, ...]:
    """The windows around pins on different frames, numbered as they come; overlapping ones are solved together.

    own : s, the smoothing time of pins that have none
    """
    places = []
    for number, pin in enumerate(pins):
        seconds = own if pin.smoothing is None else pin.smoothing
        check_smoothing(seconds, fps)
        places.append(SeamPlace(number, pin.frame, (seconds * fps) ** 4))
    return clusters(places, frames)


def correction_of(pins: Sequence[Pin], gaps: Array, frames: int, fps: float, own: float) -> Array:
    """The correction (frames, C) that takes pins over their gaps (m, C) (Eq. 30), zero outside their windows."""
    out = np.zeros((frames, gaps.shape[1]))
    for window in pin_windows(pins, frames, fps, own):
        chosen = [place.index for place in window.seams]
        out[window.start : window.stop] = _corrected(window, [pins[k] for k in chosen], gaps[chosen])
    return out


def _corrected(window: Cluster, pins: Sequence[Pin], gaps: Array) -> Array:
    weights = np.array([pin.weight for pin in pins])
    return pinned_correction(cluster_rows(window), np.array(window.local_frames), gaps, weights)


def turned(rotations: Array, turns: Sequence[Turn], fps: float) -> Array:
    """One joint's local rotations (F, 4) with its pins, which stand on different frames."""
    out = rotations.copy()
    pins = [turn.pin for turn in turns]
    for window in pin_windows(pins, len(rotations), fps, TURNING):
        chosen = [turns[place.index] for place in window.seams]
        here = slice(window.start, window.stop)
        out[here] = _turned_window(rotations[here], chosen, window)
    return out


def _turned_window(rotations: Array, turns: Sequence[Turn], window: Cluster) -> Array:
    """A window's rotations (n, 4) with its pins (Eq. 34)."""
    frames, pins = np.array(window.local_frames), [turn.pin for turn in turns]
    wanted = quat_normalize(np.stack([turn.rotation for turn in turns]))
    base = quat_mean(np.concatenate([rotations[frames], wanted]))
    away = quat_multiply(quat_conjugate(base), rotations)
    path = quat_continuous(away)
    if path[frames, 3].sum() < 0:
        path = -path
    vectors = quat_log(path)
    gaps = _nearest_sheet(quat_multiply(quat_conjugate(base), wanted), vectors[frames]) - vectors[frames]
    vectors = vectors + _corrected(window, pins, gaps)
    if np.linalg.norm(vectors[_near(window, frames)], axis=-1).max() > OVERTURN:
        gaps = quat_to_rotvec(quat_multiply(quat_conjugate(rotations[frames]), wanted))
        return quat_multiply(rotations, rotvec_to_quat(_corrected(window, pins, gaps)))
    new = quat_multiply(base, rotvec_to_quat(vectors))
    return np.where(np.einsum("fi,fi->f", path, away)[:, None] < 0, -new, new)


def _nearest_sheet(rotations: Array, near: Array) -> Array:
    """Vectors (m, 3) of rotations (m, 4), each with the sign that brings it nearest to another vector (m, 3)."""
    both = np.stack([quat_log(rotations), quat_log(-rotations)])
    away = np.linalg.norm(both - near, axis=-1)
    return np.where((away[0] <= away[1])[:, None], both[0], both[1])


def _near(window: Cluster, frames: Frames) -> np.ndarray:
    near = np.zeros(window.frames, dtype=bool)
    for place, frame in zip(window.seams, frames, strict=True):
        reach = visible_reach(place.stiffness)
        near[max(0, frame - reach) : frame + reach + 1] = True
    return near


def turned_joints(rotations: Array, turns: Sequence[Turn], fps: float, names: Sequence[str]) -> Array:
    """Local rotations (F, J, 4) with all pins of joints' rotations.

    Raises ParameterError where two pins turn one joint in one frame.
    """
    by_joint: dict[int, dict[int, Turn]] = {}
    for turn in turns:
        other = by_joint.setdefault(turn.joint, {}).setdefault(turn.pin.frame, turn)
        if other is not turn:
            raise ParameterError(
                f"Expected pins of which one turns {names[turn.joint]!r} in frame {turn.pin.frame}, got {other.pin} "
                f"and {turn.pin}. Leave one out, or pin them in different frames."
            )
    out = rotations.copy()
    for joint, found in by_joint.items():
        out[:, joint] = turned(rotations[:, joint], [found[frame] for frame in sorted(found)], fps)
    return out
