"""Every place where a clip could be cut as a vector, so that the distance of two vectors is the price of a seam.

With K = [[α, β], [β, α]] the price (10) of a seam alone is 2(α − β)‖mid gap‖² + ½(α + β)‖velocity gap‖², so that a
place k, between the frames k−1 and k, becomes

    f(k) = [√(2(α − β)) · (x(k) + x(k−1))/2 ;  √((α + β)/2) · (x(k) − x(k−1))]                          (Eq. 18)

and E* = ‖f_B − f_A‖². Places count like slices: place 0 stands before the first frame, place F after the last.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_log,
    quat_mean,
    quat_multiply,
    quat_rotate,
    quat_to_rotvec,
)
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError
from kinestitch.rig.carrier import world_of
from kinestitch.rig.hips import hip_height, hips_joint
from kinestitch.rig.roles import roles_of
from kinestitch.solve.energy import priced_joints
from kinestitch.solve.laplacian import check_stiffness
from kinestitch.solve.seam import SeamPlace, cluster_rows, clusters, seam_kernel, seam_reach

ROOT_COLUMNS = 4
"""The last columns of a feature: the hips' height and their velocity, in leg lengths; no part of a price."""

HANDS = 0.25
"""Share of its weight that is left to a hand and to all that hangs on it."""


def seam_factors(stiffness: float) -> tuple[float, float]:
    """What a squared mid gap and a squared velocity gap cost far from other seams and ends: 2(α − β), (α + β)/2.

    Raises ParameterError unless λ lies in (0, 1e12]: a hard cut costs nothing wherever it is.
    """
    check_stiffness(stiffness)
    if not stiffness > 0:
        raise ParameterError(f"Expected a stiffness λ > 0 to search with, got {stiffness:g}; hard cuts cost nothing.")
    middle = seam_reach(stiffness)
    (alone,) = clusters([SeamPlace(0, middle, stiffness)], 2 * middle)
    kernel = seam_kernel(cluster_rows(alone), middle)
    return float(2 * (kernel[0, 0] - kernel[0, 1])), float((kernel[0, 0] + kernel[0, 1]) / 2)


def place_features(motions: Sequence[Motion], stiffness: float) -> list[Array]:
    """Features (F + 1, 6P + 4) of every place of each motion, for the P joints from the hips down (Eq. 18).

    motions : of one skeleton and rate. One chart serves them all: logarithms centred on each joint's mean.

    The hips are told without their yaw and their place on the ground, which placement chooses: by the world's up
    direction and their own angular velocity in their own axes.
    """
    mid, speed = np.sqrt(seam_factors(stiffness))
    skeleton = motions[0].skeleton
    joints = list(priced_joints(skeleton))
    centre = quat_mean(np.concatenate([motion.rotations[:, joints] for motion in motions]))
    out = []
    for motion in map(_lengthened, motions):
        vectors = _pairs(centre, motion.rotations[:, joints])
        values, steps = (vectors[0] + vectors[1]) / 2, vectors[1] - vectors[0]
        here = joints.index(hips_joint(skeleton))
        values[:, here], steps[:, here], height, velocity = _hips(motion)
        columns = np.concatenate([mid * values, speed * steps], axis=-1).reshape(len(values), -1)
        out.append(np.concatenate([columns, mid * height, speed * velocity], axis=-1))
    return out


def _lengthened(motion: Motion) -> Motion:
    """The motion with one more frame of constant velocity at either end."""
    q, p = motion.rotations, motion.translations
    first, last = min(1, motion.frames - 1), max(motion.frames - 2, 0)
    before = quat_multiply(quat_multiply(q[0], quat_conjugate(q[first])), q[0])
    after = quat_multiply(quat_multiply(q[-1], quat_conjugate(q[last])), q[-1])
    rotations = np.concatenate([before[None], q, after[None]])
    translations = np.concatenate([(2 * p[0] - p[first])[None], p, (2 * p[-1] - p[last])[None]])
    return replace(motion, rotations=rotations, translations=translations)


def _pairs(centre: Array, rotations: Array) -> Array:
    """Vectors (2, F − 1, P, 3) of both frames of each pair, on the sheet on which the pair lies nearest the centre."""
    around = quat_multiply(quat_conjugate(centre), rotations)
    pair = np.stack([around[:-1], around[1:]])
    pair[1] *= np.where(np.einsum("fji,fji->fj", pair[0], pair[1]) < 0, -1.0, 1.0)[..., None]
    pair *= np.where(pair[..., 3].sum(axis=0) < 0, -1.0, 1.0)[..., None]
    return quat_log(pair)


def _hips(motion: Motion) -> tuple[Array, Array, Array, Array]:
    """Per pair of frames, blind to yaw and place: up (3,), turn (3,) rad, height (1,) and way (3,) in leg lengths."""
    position, rotation = world_of(motion, hips_joint(motion.skeleton))
    back = quat_conjugate(rotation)
    up = quat_rotate(back, np.array([0.0, 1.0, 0.0]))
    turn = quat_to_rotvec(quat_multiply(back[:-1], rotation[1:]))
    middle = back[:-1] + back[1:] * np.where(np.einsum("fi,fi->f", back[:-1], back[1:]) < 0, -1.0, 1.0)[:, None]
    way = quat_rotate(middle / np.linalg.norm(middle, axis=-1, keepdims=True), np.diff(position, axis=0))
    leg = hip_height(motion.skeleton)
    height = (position[:-1, 1:2] + position[1:, 1:2]) / 2
    return (up[:-1] + up[1:]) / 2, turn, height / leg, way / leg


def joint_weights(skeleton: Skeleton) -> Array:
    """How much each joint counts in a search (J,): the length of the longest way from it to an end of the body.

    Hands and fingers count a quarter of that; what stands above the hips counts nothing; the mean of the others is 1.
    """
    lengths = np.linalg.norm(skeleton.offsets, axis=-1)
    tips = np.linalg.norm(np.nan_to_num(skeleton.tips), axis=-1)
    reach = np.where(tips > 0, tips, 0.0)
    leaves = set(range(skeleton.joint_count)) - set(skeleton.parents)
    for joint in range(skeleton.joint_count - 1, -1, -1):
        if joint in leaves and reach[joint] == 0.0:
            reach[joint] = lengths[joint] / 2
        if joint > 0:
            parent = skeleton.parents[joint]
            reach[parent] = max(reach[parent], reach[joint] + lengths[joint])
    roles = roles_of(skeleton).joints
    hands = {roles[role] for role in ("left_hand", "right_hand") if role in roles}
    weights = np.array([reach[j] * (HANDS if hands & {*skeleton.chain(j)} else 1.0) for j in range(len(reach))])
    joints = list(priced_joints(skeleton))
    out = np.zeros(skeleton.joint_count)
    out[joints] = weights[joints] / weights[joints].mean() if weights[joints].any() else 1.0
    return out


def column_scales(skeleton: Skeleton, weights: Array | None) -> Array:
    """Factors (6P + 4,) that turn features into weighted ones; `weights` (J,), or None for a price's columns alone."""
    joints = list(priced_joints(skeleton))
    each = np.ones(len(joints)) if weights is None else np.sqrt(weights[joints])
    root = 0.0 if weights is None else np.sqrt(weights[hips_joint(skeleton)])
    return np.concatenate([np.repeat(each, 6), np.full(ROOT_COLUMNS, root)])
