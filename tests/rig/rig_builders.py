"""Rigs made from the sample body: other names, other rest poses, bones along one axis."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.kinematics import rest_pose, with_joint_axes
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_between, quat_multiply, rotvec_to_quat
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.roles import roles_of


def with_rest(motion: Motion, turns: dict[str, list[float]]) -> Motion:
    """The same motion of the same joints, whose rest pose is bent: joint (bare name) → rotation vector in degrees."""
    skeleton = motion.skeleton
    rest = skeleton.rest.copy()
    for name, degrees in turns.items():
        joint = skeleton.index(f"mixamorig:{name}")
        rest[joint] = quat_multiply(rotvec_to_quat(np.radians(degrees)), rest[joint])
    return replace(motion, skeleton=replace(skeleton, rest=rest))


def a_posed(motion: Motion) -> Motion:
    """Arms lowered by 45°, elbows bent by 30°."""
    arms = {"LeftArm": [0, 0, -45], "RightArm": [0, 0, 45], "LeftForeArm": [0, -30, 0], "RightForeArm": [0, 30, 0]}
    return with_rest(motion, arms)


def hanging(motion: Motion) -> Motion:
    """Arms down, axes parallel to the world's at rest, as in BVH files."""
    bent = with_rest(motion, {"LeftArm": [0, 0, -90], "RightArm": [0, 0, 90]})
    return with_joint_axes(bent, [0.0, 0.0, 0.0, 1.0])


def drawn_along_x(motion: Motion) -> Motion:
    """All angles zero means: every bone along +X (a right limb's along −X), as in Bandai-Namco's files."""
    skeleton = motion.skeleton
    positions, _ = rest_pose(skeleton)
    axes = np.broadcast_to([0.0, 0.0, 0.0, 1.0], (skeleton.joint_count, 4)).copy()
    for joint, name in enumerate(skeleton.names):
        children = skeleton.children(joint)
        if len(children) == 1:
            along = [-1.0, 0.0, 0.0] if "Right" in name else [1.0, 0.0, 0.0]
            axes[joint] = quat_between(along, positions[children[0]] - positions[joint])
    spines = [skeleton.index(f"mixamorig:{name}") for name in ("Hips", "Spine", "Spine1", "Spine2", "Neck", "Head")]
    axes[spines] = quat_between([1.0, 0.0, 0.0], [0.0, 1.0, 0.0])
    for side in ("Left", "Right"):
        for name in ("UpLeg", "Leg"):
            joint = skeleton.index(f"mixamorig:{side}{name}")
            axes[joint] = quat_multiply(axes[joint], quat_about_axis(0, np.pi / 2))
        for name, below in (("Leg", "Foot"), ("Foot", "ToeBase"), ("ToeBase", "Toe_End")):
            above, joint = skeleton.index(f"mixamorig:{side}{name}"), skeleton.index(f"mixamorig:{side}{below}")
            if below == "Toe_End":
                axes[joint] = axes[above]
                continue
            child = skeleton.children(joint)[0]
            bend = quat_between(positions[joint] - positions[above], positions[child] - positions[joint])
            axes[joint] = quat_multiply(bend, axes[above])
    told = with_joint_axes(motion, axes)
    return replace(told, skeleton=replace(told.skeleton, rest=None))


def renamed(motion: Motion, names: dict[str, str], *, keep: bool = True) -> Motion:
    """Joints called otherwise, by role; without `keep` those without a new name are called after their number."""
    roles = {joint: role for role, joint in roles_of(motion.skeleton).joints.items()}
    new = tuple(
        names.get(roles.get(joint, ""), name if keep else f"extra {joint}")
        for joint, name in enumerate(motion.skeleton.names)
    )
    return replace(motion, skeleton=replace(motion.skeleton, names=new))


def scaled(motion: Motion, factor: float) -> Motion:
    """A body of another size that does the same."""
    skeleton = replace(motion.skeleton, offsets=motion.skeleton.offsets * factor)
    return replace(motion, skeleton=skeleton, translations=motion.translations * factor)


def below_a_dummy(motion: Motion, name: str = "Armature") -> Motion:
    """The same under a root joint that does not move."""
    own = motion.skeleton
    skeleton = Skeleton(
        (name, *own.names),
        (-1, *(parent + 1 for parent in own.parents)),
        np.concatenate([np.zeros((1, 3)), own.offsets]),
        np.concatenate([[[0.0, 0.0, 0.0, 1.0]], own.rest]),
    )
    still = np.zeros((motion.frames, 1, 3)), np.broadcast_to([0.0, 0.0, 0.0, 1.0], (motion.frames, 1, 4))
    return replace(
        motion,
        skeleton=skeleton,
        translations=np.concatenate([still[0], motion.translations], axis=1),
        rotations=np.concatenate([still[1], motion.rotations], axis=1),
    )


def without(motion: Motion, *words: str) -> Motion:
    """The same without the joints in whose names one of these words stands, which must be leaves or lead to such."""
    own = motion.skeleton
    kept = [joint for joint, name in enumerate(own.names) if not any(word in name for word in words)]
    skeleton = Skeleton(
        tuple(own.names[joint] for joint in kept),
        tuple(kept.index(own.parents[joint]) if joint else -1 for joint in kept),
        own.offsets[kept],
        own.rest[kept],
    )
    return replace(
        motion, skeleton=skeleton, translations=motion.translations[:, kept], rotations=motion.rotations[:, kept]
    )
