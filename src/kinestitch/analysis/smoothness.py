"""How much a seam adds to what the clips do anyway: acceleration, speed, overshoot, and jerk in the usual units.

Rotations are looked at joint by joint, each against its parent, in the joint's own axes and on the group: what is
measured does not depend on any chart, nor on a constant turn of the pose, so that no method is measured with its own
yardstick. ω(t) = log(q(t)⁻¹ q(t+1)) · fps in rad/s lives between frames, α(t) = (ω(t) − ω(t−1)) · fps in rad/s² at
them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_mean, quat_multiply, quat_to_rotvec
from kinestitch.errors import ParameterError
from kinestitch.solve.placed import Placed, straddling
from kinestitch.solve.seam import SeamPlace
from kinestitch.solve.sources import PERCENTILE, own_velocities, velocity_between


def angular_velocity(rotations: Array, fps: float) -> Array:
    """ω (F − 1, J, 3) rad/s of rotations (F, J, 4), from each frame to the next, in the joint's own axes."""
    return velocity_between(rotations[:-1], rotations[1:], fps)


def angular_acceleration(rotations: Array, fps: float) -> Array:
    """α (F − 2, J, 3) rad/s² of rotations (F, J, 4) at all frames but the first and last, in the joint's own axes."""
    return np.diff(angular_velocity(rotations, fps), axis=0) * fps


@dataclass(frozen=True, eq=False, slots=True)
class Added:
    """What a seam adds to the strength of a movement, beside the strength that its sources show near it.

    added : (J,) the largest that the result's size exceeds its source's own in the same frame, at least 0
    own : (J,) 95th percentile of the sources' own sizes; own_body : the same of each frame's strongest joint
    strongest : (J,) the largest size in the result. All in rad/s or rad/s².
    kept : root of the sum of squares of all sizes, the result's over the sources': 1 where the movement is as strong
    survived : the same, but what is stronger than its source counts as much as its source: 1 where nothing is weaker
    """

    added: Array
    own: Array
    own_body: float
    strongest: Array
    kept: float
    survived: float

    @property
    def per_joint(self) -> Array:
        """`added` over `own`, (J,); 0 where nothing was added, infinite where it was added to a joint at rest."""
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(self.added > 0, self.added / self.own, 0.0)

    @property
    def peak(self) -> float:
        """The worst joint's `added` over what the sources' strongest joint does in 95 % of the frames."""
        return _ratio(float(self.added.max()), self.own_body)

    @property
    def total(self) -> float:
        """The strongest movement in the result over the same measure: 1 where the seam is as strong as its sources."""
        return _ratio(float(self.strongest.max()), self.own_body)


def _ratio(value: float, of: float) -> float:
    if value == 0:
        return 0.0
    return value / of if of > 0 else float("inf")


def own_acceleration(placed: Placed, seam: SeamPlace, reach: int) -> Array:
    """Sizes (n, J) rad/s² of the sources' angular acceleration within `reach` frames of a seam.

    Each source among its own neighbours, some of which are not part of the result, so that the cut itself is not in it.
    Raises ParameterError for a reach that leaves nothing to look at.
    """
    into, out, _ = own_velocities(placed, *_near(placed, seam, reach))
    return np.asarray(np.linalg.norm(out - into, axis=-1) * placed.timeline.fps)


def acceleration_near(motion: Motion, placed: Placed, seam: SeamPlace, reach: int) -> Array:
    """Sizes (n, J) rad/s² of a result's angular acceleration in the frames of :func:`own_acceleration`."""
    start, stop = _near(placed, seam, reach)
    return np.asarray(np.linalg.norm(angular_acceleration(motion.rotations[start - 1 : stop + 1], motion.fps), axis=-1))


def added_acceleration(
    motion: Motion, placed: Placed, seam: SeamPlace, reach: int, *, own: Array | None = None
) -> Added:
    """How much stronger than its sources a result accelerates within `reach` frames of a seam: angular, rad/s².

    own : what :func:`own_acceleration` gives there, to measure several results of one seam
    """
    own = own_acceleration(placed, seam, reach) if own is None else own
    return _added(acceleration_near(motion, placed, seam, reach), own)


def added_velocity(motion: Motion, placed: Placed, seam: SeamPlace, reach: int) -> Added:
    """How much faster than its sources a result turns within `reach` frames of a seam: angular, rad/s.

    Each interval between frames is compared with the faster of its two frames' own sources, which differ in the seam's
    interval only.
    """
    start, stop = _near(placed, seam, reach)
    into, out = (np.linalg.norm(velocity, axis=-1) for velocity in own_velocities(placed, start, stop)[:2])
    result = np.linalg.norm(angular_velocity(motion.rotations[start:stop], motion.fps), axis=-1)
    return _added(result, np.maximum(out[:-1], into[1:]))


def _near(placed: Placed, seam: SeamPlace, reach: int) -> tuple[int, int]:
    """Frames [start, stop) within `reach` of a seam that have a neighbour on both sides."""
    start, stop = max(1, seam.frame - reach), min(placed.frames - 1, seam.frame + reach)
    if reach < 1 or stop - start < 2:
        raise ParameterError(f"Expected a reach of at least 1 frame around frame {seam.frame}, got {reach}.")
    return start, stop


def _added(result: Array, own: Array) -> Added:
    size = float(np.linalg.norm(own))
    return Added(
        added=np.maximum(result - own, 0.0).max(axis=0),
        own=np.percentile(own, PERCENTILE, axis=0),
        own_body=float(np.percentile(own.max(axis=1), PERCENTILE)),
        strongest=result.max(axis=0),
        kept=float(np.linalg.norm(result)) / size if size > 0 else 1.0,
        survived=float(np.linalg.norm(np.minimum(result, own))) / size if size > 0 else 1.0,
    )


def overshoot(motion: Motion, cut: Motion, placed: Placed, seam: SeamPlace, reach: int) -> Array:
    """How far each joint is moved away from the other source instead of towards it: (J,) rad, 0 where it never is.

    The correction ``log(q_tar⁻¹ q)`` is looked at along the axis of the mean gap a⁻¹b: left of the seam it should turn
    with it, right of the seam against it. What goes the other way is overshoot. Over the gap of two still poses this
    is 3.3 % for the published method.

    motion, cut : the result and the hard cut of the same frames
    """
    start = max(0, seam.frame - reach)
    near = slice(start, seam.frame + reach)
    moved = quat_to_rotvec(quat_multiply(quat_conjugate(cut.rotations[near]), motion.rotations[near]))
    a, b = straddling(placed, seam).rotations.reshape(2, 2, -1, 4)
    gap = quat_to_rotvec(quat_mean(quat_multiply(quat_conjugate(a), b)))
    size = np.linalg.norm(gap, axis=-1, keepdims=True)
    along = np.einsum("fji,ji->fj", moved, gap / np.where(size > 0, size, 1.0))
    along[: seam.frame - start] *= -1.0
    return np.maximum(along.max(axis=0), 0.0)


def jerk(motion: Motion) -> Array:
    """Third difference of world positions, sum of |x|, |y| and |z|, of the worst joint: (F − 3,) m/frame³.

    It scales with 1/fps³: state the rate. Raises ParameterError for fewer than four frames.

    Source: G. Barquero et al., *Seamless Human Motion Composition with Blended Positional Encodings* (FlowMDM, CVPR
    2024).
    """
    if motion.frames < 4:
        raise ParameterError(f"Expected at least 4 frames, got {motion.frames}.")
    return np.asarray(np.abs(np.diff(world_pose(motion).positions, n=3, axis=0)).sum(axis=-1).max(axis=-1))


def mean_jerk(motions: Sequence[Motion]) -> Array:
    """Mean over motions of one length of :func:`jerk`: (F − 3,) m/frame³, the curve that FlowMDM's numbers are read
    off. Raises ParameterError for motions of different lengths, or none.
    """
    lengths = sorted({motion.frames for motion in motions})
    if len(lengths) != 1:
        raise ParameterError(f"Expected motions of one length, got lengths {lengths}. Cut them to equal windows.")
    return np.asarray(np.mean([jerk(motion) for motion in motions], axis=0))


def peak_jerk(motions: Sequence[Motion]) -> float:
    """PJ: the largest value over time of :func:`mean_jerk`, m/frame³."""
    return float(mean_jerk(motions).max())


def area_under_jerk(motions: Sequence[Motion], reference: float) -> float:
    """AUJ: ``Σ_t |J(t) − J_ref|``, m/frame³, of :func:`mean_jerk`.

    reference : m/frame³, what real motion shows: the mean over time of the sources' own :func:`jerk`

    It also counts jerk that is lost; a blend that averages its sources away is not smooth by it.
    """
    return float(np.abs(mean_jerk(motions) - reference).sum())
