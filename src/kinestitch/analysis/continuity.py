"""Whether rotation vectors keep their direction from frame to frame, within clips and where clips are joined.

Everything here looks at the principal chart, r = θu with θ in [0, π], of each joint relative to its rest pose (Eq. 1):
the one whose continuity is in question. Two things can happen to it. Where θ is small, u may point anywhere and turns
fast, which harms nobody. Where θ passes π, r jumps to the other side: u · u′ is near −1 and ‖r′ − r‖ near 2π. Only the
second makes a limb spin, so crossings are counted beside the products.

Source of the products and of the flip: *Smooth Motion Stitching via Laplacian Optimization in Rodrigues Vector Space*
(doi:10.48550/arXiv.2608.08986); the crossings and the threshold are ours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_to_rotvec
from kinestitch.errors import ParameterError

THRESHOLD = 1e-3
"""rad; joints that turn less than this have no axis worth comparing."""

ABOVE_HALF, FLIPPED, ALIGNED = 0.5, -0.9, 0.99


def principal_vectors(motion: Motion) -> Array:
    """Principal rotation vectors (F, J, 3) rad of every joint relative to its rest pose (Eq. 1)."""
    return quat_to_rotvec(quat_multiply(quat_conjugate(motion.skeleton.rest), motion.rotations))


def angles(motion: Motion) -> Array:
    """θ (F, J) rad in [0, π]: how far every joint is turned from its rest pose."""
    return np.asarray(np.linalg.norm(principal_vectors(motion), axis=-1))


def flip(vectors: Array) -> Array:
    """The same rotations told with the opposite axis, ``(2π − θ)(−u)``; (..., 3) rad (Eq. 13).

    A vector of length zero has no axis and stays as it is. Flipping twice gives the vector back where θ ≤ 2π.
    """
    theta = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return np.where(theta > 0, vectors * (1 - 2 * np.pi / np.where(theta > 0, theta, 1.0)), vectors)


@dataclass(frozen=True, eq=False, slots=True)
class Steps:
    """How rotation vectors go from one pose to the next, joint by joint; any leading axes.

    products : (..., J) u · u′, NaN where an angle is below the threshold; jumps : (..., J) ‖r′ − r‖ rad
    theta : (..., J) rad, the larger of both angles
    """

    products: Array
    jumps: Array
    theta: Array

    @property
    def values(self) -> Array:
        """All products (N,) where both angles exceed the threshold."""
        return self.products[np.isfinite(self.products)]

    @property
    def crossings(self) -> NDArray[np.bool_]:
        """Where the vector jumps to another branch: ‖r′ − r‖ > π."""
        return self.jumps > np.pi

    @property
    def flips(self) -> NDArray[np.bool_]:
        """Where the axis turns round: u · u′ < −0.9."""
        return self.products < FLIPPED


def steps_between(before: Array, after: Array, threshold: float = THRESHOLD) -> Steps:
    """Compare rotation vectors (..., J, 3) rad with those that follow them.

    Raises ParameterError for a threshold that is not positive.
    """
    if not threshold > 0:
        raise ParameterError(f"Expected a threshold in rad > 0, got {threshold}.")
    a, b = (np.linalg.norm(vectors, axis=-1) for vectors in (before, after))
    told = (a > threshold) & (b > threshold)
    size = np.where(told, a * b, 1.0)
    products = np.where(told, np.clip(np.einsum("...i,...i->...", before, after) / size, -1.0, 1.0), np.nan)
    return Steps(products, np.linalg.norm(after - before, axis=-1), np.maximum(a, b))


def clip_steps(motion: Motion, threshold: float = THRESHOLD) -> Steps:
    """From every frame of a clip to the next: arrays (F − 1, J)."""
    vectors = principal_vectors(motion)
    return steps_between(vectors[:-1], vectors[1:], threshold)


def axis_continuity(motion: Motion, threshold: float = THRESHOLD) -> Array:
    """``u_t · u_{t+1}`` (N,) of all joints and frames of a clip where both angles exceed `threshold` rad."""
    return clip_steps(motion, threshold).values


def branch_crossings(motion: Motion) -> int:
    """Number of joint-frames at which the principal vector jumps to another branch, ‖r_{t+1} − r_t‖ > π."""
    return int(clip_steps(motion).crossings.sum())


def end_to_start(clips: Mapping[str, Motion], threshold: float = THRESHOLD) -> Steps:
    """From the last frame of every clip to the first of every other: arrays (K (K − 1), J); one rig for all."""
    vectors = [principal_vectors(motion) for motion in clips.values()]
    pairs = [(i, j) for i in range(len(vectors)) for j in range(len(vectors)) if i != j]
    return steps_between(
        np.stack([vectors[i][-1] for i, _ in pairs]), np.stack([vectors[j][0] for _, j in pairs]), threshold
    )


def random_boundaries(
    clips: Mapping[str, Motion], pairs: int, rng: np.random.Generator, threshold: float = THRESHOLD
) -> Steps:
    """From a random frame of a random clip to a random frame of another: arrays (pairs, J); one rig for all.

    Clips are drawn evenly, whatever their length.
    """
    vectors = [principal_vectors(motion) for motion in clips.values()]
    before, after = [], []
    for _ in range(pairs):
        i, j = rng.choice(len(vectors), size=2, replace=False)
        before.append(vectors[i][rng.integers(len(vectors[i]))])
        after.append(vectors[j][rng.integers(len(vectors[j]))])
    return steps_between(np.stack(before), np.stack(after), threshold)


@dataclass(frozen=True, slots=True)
class Continuity:
    """Many steps in numbers: counts of values and joint-steps, shares of the values, crossings among the joint-steps.

    largest_angle : rad, the largest θ that was met
    """

    values: int
    share_above_half: float
    share_aligned: float
    share_flipped: float
    joint_steps: int
    crossings: int
    largest_angle: float


def continuity(steps: Sequence[Steps]) -> Continuity:
    """Sum steps up: shares of u · u′ above 0.5, above 0.99 and below −0.9, and how many joint-steps change branch."""
    values = np.concatenate([s.values for s in steps]) if steps else np.zeros(0)
    count = max(len(values), 1)
    return Continuity(
        values=len(values),
        share_above_half=float((values > ABOVE_HALF).sum() / count),
        share_aligned=float((values > ALIGNED).sum() / count),
        share_flipped=float((values < FLIPPED).sum() / count),
        joint_steps=sum(s.jumps.size for s in steps),
        crossings=sum(int(s.crossings.sum()) for s in steps),
        largest_angle=max((float(s.theta.max()) for s in steps if s.theta.size), default=0.0),
    )
