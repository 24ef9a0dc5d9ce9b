"""Whether feet that should stand slide over the ground: two published measures.

Both look at a joint's height over the ground and at how far it moves along it. A joint has a height of its own even
while its foot stands flat, an ankle more than a toe; heights are therefore counted from where each joint stands
(:func:`standing_heights`), else no ankle would ever be near the ground.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.resample import resample
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.rig.hips import leg_roots
from kinestitch.rig.roles import roles_of

HEIGHT = 0.025
"""m, the height H at which a foot no longer counts as standing."""

LOW, FAST, RATE = 0.05, 0.5, 20.0
"""m, m/s and fps of the second measure."""

_STANDING = 2.0  # percent of the frames lie lower than where a joint is taken to stand


def foot_joints(skeleton: Skeleton) -> tuple[int, ...]:
    """The joints that touch the ground, left before right: each side's toe, else its foot, else the end of its leg.

    Raises SkeletonMismatchError for a rig without legs.
    """
    roles = roles_of(skeleton).joints
    named = [roles.get(f"{side}_toe", roles.get(f"{side}_foot")) for side in ("left", "right")]
    if None not in named:
        return tuple(joint for joint in named if joint is not None)
    legs = leg_roots(skeleton)
    if legs is None:
        raise SkeletonMismatchError(
            "Expected a rig with two legs, got one whose feet cannot be found. Name the joints."
        )
    return tuple(_end_of(skeleton, leg) for leg in legs)


def _end_of(skeleton: Skeleton, joint: int) -> int:
    """The joint before the last on the longest way down: a leg ends with a foot and its tip."""
    way = [joint]
    while skeleton.children(way[-1]):
        way.append(max(skeleton.children(way[-1]), key=lambda child: _depth(skeleton, child)))
    return way[-2] if len(way) > 3 else way[-1]


def _depth(skeleton: Skeleton, joint: int) -> int:
    return 1 + max((_depth(skeleton, child) for child in skeleton.children(joint)), default=0)


def standing_heights(motion: Motion, joints: Sequence[int]) -> Array:
    """Where each joint is while its foot stands: the height (K,) m below which it is in 2 % of the frames.

    Measure it on the clips, not on the result: where a foot is pushed through the ground is what shall be seen.
    """
    return np.asarray(np.percentile(world_pose(motion, joints).positions[:, list(joints), 1], _STANDING, axis=0))


def weighted_skate(
    motion: Motion, joints: Sequence[int] | None = None, ground: Array | float | None = None, *, height: float = HEIGHT
) -> Array:
    """How far feet slide in each frame, weighed by how low they are: (F − 1, K) m, ``Δxz · (2 − 2^{h/H})`` for h < H.

    joints : K of them, :func:`foot_joints` when left out; ground : (K,) or one height in m that counts as h = 0,
    :func:`standing_heights` of this motion when left out; height : H in m

    h is the mean of both frames, and below the ground counts as on it. The mean over feet and frames is the usual
    number; it scales with 1/fps.

    Source: H. Zhang et al., *Mode-Adaptive Neural Networks for Quadruped Motion Control* (SIGGRAPH 2018), with
    H = 2.5 cm.
    """
    if not height > 0:
        raise ParameterError(f"Expected a height in m > 0, got {height}.")
    heights, slides = _over_ground(motion, joints, ground)
    mean = np.maximum((heights[1:] + heights[:-1]) / 2, 0.0)
    return np.where(mean < height, slides * (2 - 2.0 ** (np.minimum(mean, height) / height)), 0.0)


def skating_share(
    motion: Motion, joints: Sequence[int] | None = None, ground: Array | float | None = None, *, low: float = LOW
) -> float:
    """Share of the frames, of all feet, in which a foot slides: height below 5 cm in both frames and speed along the
    ground above 0.5 m/s, of the motion resampled to 20 fps.

    joints, ground : as in :func:`weighted_skate`; low : m. A motion of one frame slides in none of them.

    Source: K. Karunratanakul et al., *Guided Motion Diffusion* (ICCV 2023).
    """
    ground = standing_heights(motion, _joints(motion, joints)) if ground is None else ground
    heights, slides = _over_ground(resample(motion, RATE), joints, ground)
    if len(slides) == 0:
        return 0.0
    near = np.maximum(heights[1:], heights[:-1]) < low
    return float((near & (slides * RATE > FAST)).mean())


def _joints(motion: Motion, joints: Sequence[int] | None) -> list[int]:
    return list(foot_joints(motion.skeleton) if joints is None else joints)


def _over_ground(motion: Motion, joints: Sequence[int] | None, ground: Array | float | None) -> tuple[Array, Array]:
    """Heights (F, K) m over where they stand, and way along the ground (F − 1, K) m."""
    feet = _joints(motion, joints)
    positions = world_pose(motion, feet).positions[:, feet]
    floor = standing_heights(motion, feet) if ground is None else np.asarray(ground, dtype=np.float64)
    slides = np.linalg.norm(np.diff(positions[..., (0, 2)], axis=0), axis=-1)
    return positions[..., 1] - floor, slides
