"""When feet stand: each foot's ankle and toe joint, frame by frame, told by height and speed.

A joint begins to stand where it is both low and slow, and stops where it is clearly higher or clearly faster
(hysteresis), so that noise about one bound does not make it flicker. What counts as low is measured from the clip: the
lowest that the same joint of either side comes within a second. All bounds grow with the length of the legs.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import minimum_filter1d

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.rig.families import SIDES
from kinestitch.rig.hips import hip_height
from kinestitch.rig.roles import roles_of

Mask = NDArray[np.bool_]

LOW = (0.025, 0.05)
"""Leg lengths over the floor below which a joint begins to stand, and above which it stops."""

SLOW = (0.1, 0.2)
"""Leg lengths per second below which a joint begins to stand, and above which it stops."""

SHORTEST, HOLE = 0.06, 0.05
"""s; a shorter contact is none, a shorter pause of one does not end it."""

_UNEVEN = 0.08  # leg lengths by which one foot may stand higher than the other
_AROUND = 1.0  # s on each side in which a foot comes down to the floor
_STEP = 1 / 60  # s over which a speed is measured, so that noise counts alike at all rates


@dataclass(frozen=True, slots=True)
class Leg:
    """The joints of a leg; toe is None on a rig without."""

    thigh: int
    shin: int
    foot: int
    toe: int | None

    @property
    def joints(self) -> tuple[int, ...]:
        """Those that the rig has, from the hip joint down."""
        return tuple(joint for joint in (self.thigh, self.shin, self.foot, self.toe) if joint is not None)


@dataclass(frozen=True, eq=False, slots=True)
class Contacts:
    """Which joints stand in which frames.

    joints : K joint indices, for each side the foot (ankle) and then the toe, if there is one, left before right
    held : (F, K) bool, read-only
    """

    joints: tuple[int, ...]
    held: Mask

    def __post_init__(self) -> None:
        held = np.array(self.held, dtype=bool)
        if held.ndim != 2 or held.shape[1] != len(self.joints):
            raise ParameterError(f"Expected contacts of shape (F, {len(self.joints)}), got {held.shape}.")
        held.setflags(write=False)
        object.__setattr__(self, "held", held)

    def of(self, *joints: int | None) -> Mask:
        """The frames (F,) in which any of these joints stands."""
        columns = [self.joints.index(joint) for joint in joints if joint in self.joints]
        return np.asarray(self.held[:, columns].any(axis=1))


@lru_cache(maxsize=64)
def legs_of(skeleton: Skeleton) -> tuple[Leg, Leg]:
    """The left and the right leg.

    Raises SkeletonMismatchError for a rig on which thigh, shin and foot of both sides cannot be told by their names.
    """
    roles = roles_of(skeleton).joints
    legs = []
    for side in SIDES:
        chain = [roles.get(f"{side}_{part}") for part in ("upper_leg", "lower_leg", "foot")]
        found = [joint for joint in chain if joint is not None]
        if len(found) < 3:
            raise SkeletonMismatchError(
                f"Expected a rig with two feet, got one whose {side} leg cannot be found among its "
                f"{skeleton.joint_count} joints. Leave its feet unlocked, or name the joints."
            )
        legs.append(Leg(found[0], found[1], found[2], roles.get(f"{side}_toe")))
    return legs[0], legs[1]


def find_contacts(
    motion: Motion, *, low: tuple[float, float] = LOW, slow: tuple[float, float] = SLOW, shortest: float = SHORTEST
) -> Contacts:
    """The contacts of a clip's feet.

    low, slow : bounds (begin, stop) of height in leg lengths and of speed in leg lengths per second
    shortest : s, least duration of a contact

    Feet that walk on the spot, as on a treadmill, slide all the time and so never stand. A clip of one frame has no
    speed: its low joints stand.

    Raises SkeletonMismatchError for a rig without feet, ParameterError for bounds that are not 0 ≤ begin ≤ stop.
    """
    for name, (first, last) in (("low", low), ("slow", slow)):
        if not 0 <= first <= last:
            raise ParameterError(f"Expected bounds 0 ≤ begin ≤ stop for {name}, got {first} and {last}.")
    joints = tuple(j for leg in legs_of(motion.skeleton) for j in (leg.foot, leg.toe) if j is not None)
    places = world_pose(motion, joints).positions[:, joints]
    size = hip_height(motion.skeleton)
    speeds = _speeds(places, motion.fps) / size
    heights = places[..., 1] / size
    ankles = np.isin(joints, [leg.foot for leg in legs_of(motion.skeleton)])
    for kind in (ankles, ~ankles):
        if kind.any():
            heights[:, kind] -= _floor(heights[:, kind], speeds[:, kind] < slow[1], motion.fps)
    begin = (heights < low[0]) & (speeds < slow[0])
    keep = (heights < low[1]) & (speeds < slow[1])
    held = np.stack([_between(begin[:, k], keep[:, k]) for k in range(len(joints))], axis=1)
    for column in held.T:
        _tidy(column, round(HOLE * motion.fps), round(shortest * motion.fps))
    return Contacts(joints, held)


def _floor(heights: Array, slow: Mask, fps: float) -> Array:
    """The height (F, n) in leg lengths at which each of n joints of one kind stands: the lowest that it is within
    a second while it is slow; what a toe does when it pushes off goes lower and does not count.

    A joint that is far above its counterpart's floor is raised, and has that floor.
    """
    window = 2 * round(_AROUND * fps) + 1
    lowest = np.where(slow, heights, np.inf)
    rolling = np.asarray(minimum_filter1d(lowest, window, axis=0, mode="nearest"))
    ever = np.where(slow.any(axis=0), lowest.min(axis=0), heights.min(axis=0))
    own = np.where(np.isfinite(rolling), rolling, ever)
    both = own.min(axis=1, keepdims=True)
    return np.where(own - both < _UNEVEN, own, both)


def _speeds(places: Array, fps: float) -> Array:
    """Speed (F, K) m/s of the slower side of each frame, so that the last frame of a stance is one of it."""
    step = min(max(1, round(_STEP * fps)), len(places) - 1)
    if step == 0:
        return np.zeros(places.shape[:2])
    speed = np.linalg.norm(places[step:] - places[:-step], axis=-1) * fps / step
    before = np.concatenate([speed[:1].repeat(step, axis=0), speed])
    after = np.concatenate([speed, speed[-1:].repeat(step, axis=0)])
    return np.minimum(before, after)


def runs(mask: Mask) -> list[tuple[int, int]]:
    """The stretches [start, stop) of a mask (F,) in which it is set."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], mask, [False]]).astype(np.int8)))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]


def _between(begin: Mask, keep: Mask) -> Mask:
    """The stretches of `keep` that hold a frame of `begin`."""
    out = np.zeros(len(keep), dtype=bool)
    for start, stop in runs(keep):
        out[start:stop] = begin[start:stop].any()
    return out


def _tidy(column: Mask, hole: int, shortest: int) -> None:
    """Close short pauses between contacts, then drop short contacts, in place; the clip's ends cut none short."""
    for start, stop in runs(~column):
        if start > 0 and stop < len(column) and stop - start < hole:
            column[start:stop] = True
    for start, stop in runs(column):
        if start > 0 and stop < len(column) and stop - start < shortest:
            column[start:stop] = False
