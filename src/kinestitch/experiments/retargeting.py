"""Retargeting measured where the truth is known: clips that exist on several rigs, as their source retargeted them.

Run as ``python -m kinestitch.experiments.retargeting FOLDER -o docs/retargeting.md``. FOLDER holds one folder of clips
per data set.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from kinestitch import files
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.resample import resample
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.mapping import find_mapping
from kinestitch.rig.retarget import retargeted
from kinestitch.rig.roles import roles_of

BONES = {
    "trunk": (("spine_1", "neck_1"), ("hips", "head")),
    "upper arm": (("upper_arm", "lower_arm"),),
    "forearm": (("lower_arm", "hand"),),
    "hand": (("hand", "index_1"),),
    "thigh": (("upper_leg", "lower_leg"),),
    "shin": (("lower_leg", "foot"),),
    "foot": (("foot", "toe"),),
}
"""Limb → pairs of roles between which a direction is measured, on both sides where they have one."""


@dataclass(frozen=True, slots=True)
class Case:
    """A clip on two rigs. source, truth : paths in the folder; speed : how much faster the truth plays."""

    source: str
    truth: str
    speed: float = 1.0


CASES = (
    Case("mixamo_xbot_30fps/Jumping Jacks.fbx", "mixamo_other_rigs/mario_Jumping Jacks.fbx"),
    Case("mixamo_other_rigs/mario_Jumping Jacks.fbx", "mixamo_xbot_30fps/Jumping Jacks.fbx"),
    Case("mixamo_other_rigs/readyplayerme_Punching.fbx", "mixamo_other_rigs/fbx7400_Punching.fbx"),
    Case("mixamo_other_rigs/fbx7400_Punching.fbx", "mixamo_other_rigs/readyplayerme_Punching.fbx"),
    Case("mixamo_other_rigs/readyplayerme_Punching.fbx", "mixamo_ybot_60fps/Punching_Right.fbx"),
    Case("mixamo_ybot_60fps/Punching_Right.fbx", "mixamo_other_rigs/readyplayerme_Punching.fbx"),
    Case("mixamo_ybot_60fps/Hook Punch.fbx", "mixamo_xbot_60fps/Hook Punch.fbx", 0.5),
    Case("mixamo_xbot_60fps/Hook Punch.fbx", "mixamo_ybot_60fps/Hook Punch.fbx", 2.0),
)
CROSSINGS = (
    ("bandai/dataset-1_walk_normal_001.bvh", "mixamo_xbot_60fps/Idle.fbx"),
    ("bandai/dataset-1_kick_normal_001.bvh", "mixamo_xbot_60fps/Idle.fbx"),
    ("cmu/02_01.bvh", "mixamo_xbot_60fps/Idle.fbx"),
    ("cmu/131_01.bvh", "mixamo_xbot_60fps/Idle.fbx"),
    ("cmu/16_15.bvh", "mixamo_xbot_60fps/Idle.fbx"),
    ("mixamo_xbot_60fps/Kicking.fbx", "ue_mannequin/MCU_am_OrcHammer_Loco_Walk_Fwd.FBX"),
    ("mixamo_xbot_60fps/Walking.fbx", "bandai/dataset-1_walk_normal_001.bvh"),
    ("mixamo_xbot_60fps/Walking.fbx", "cmu/02_01.bvh"),
    ("ue_mannequin/MCU_am_OrcHammer_Loco_Walk_Fwd.FBX", "mixamo_xbot_60fps/Idle.fbx"),
)

_STANDS = 0.1  # m/s

Method = Callable[[Motion, Motion], Motion]


def copied_locals(motion: Motion, target: Motion) -> Motion:
    """What a plain copy does: each joint's local rotation is given to its counterpart."""
    return _copied(motion, target, lambda local, _, __: local)


def copied_turns(motion: Motion, target: Motion) -> Motion:
    """The next simplest: each joint's local turn away from rest is given to its counterpart."""
    return _copied(
        motion, target, lambda local, own, rest: quat_multiply(rest, quat_multiply(quat_conjugate(own), local))
    )


def _copied(motion: Motion, target: Motion, rule: Callable[[Array, Array, Array], Array]) -> Motion:
    own, skeleton = motion.skeleton, target.skeleton
    rotations = np.broadcast_to(skeleton.rest, (motion.frames, skeleton.joint_count, 4)).copy()
    for pair in find_mapping(own, skeleton).pairs:
        a, b = own.index(pair.source), skeleton.index(pair.target)
        rotations[:, b] = rule(motion.rotations[:, a], own.rest[a], skeleton.rest[b])
    translations = np.broadcast_to(skeleton.offsets, (motion.frames, skeleton.joint_count, 3))
    return replace(motion, skeleton=skeleton, rotations=rotations, translations=translations)


METHODS: dict[str, Method] = {
    "kinestitch": lambda motion, target: retargeted(motion, target.skeleton, example=target).motion,
    "kinestitch, no foot IK": lambda motion, target: (
        retargeted(motion, target.skeleton, example=target, foot_ik=False).motion
    ),
    "local turns copied": copied_turns,
    "local rotations copied": copied_locals,
}


def directions(motion: Motion) -> dict[str, Array]:
    """Limb → unit directions (F, n, 3) of its bones in the world, left before right, without limbs the rig lacks."""
    joints = roles_of(motion.skeleton).joints
    positions = world_pose(motion).positions
    found = {}
    for limb, bones in BONES.items():
        ends = [
            (joints[side + a], joints[side + b])
            for a, b in bones
            for side in ("", "left_", "right_")
            if side + a in joints and side + b in joints
        ]
        if ends:
            bone = np.stack([positions[:, b] - positions[:, a] for a, b in ends], axis=1)
            found[limb] = bone / np.maximum(np.linalg.norm(bone, axis=-1, keepdims=True), 1e-12)
    return found


def direction_errors(motion: Motion, truth: Motion) -> dict[str, float]:
    """Limb → mean angle in degrees between the directions of two motions of equally many frames."""
    ours, theirs = directions(motion), directions(truth)
    return {
        limb: float(np.degrees(_angles(ours[limb], theirs[limb]).mean()))
        for limb in BONES
        if limb in ours and limb in theirs and ours[limb].shape == theirs[limb].shape
    }


def _angles(a: Array, b: Array) -> Array:
    return 2 * np.arcsin(np.clip(np.linalg.norm(a - b, axis=-1) / 2, 0.0, 1.0))


def aligned(source: Motion, truth: Motion, speed: float) -> tuple[Motion, Motion, int]:
    """Both at one rate and speed, cut to the frames where they agree best; and the truth's first frame there."""
    source = resample(replace(source, fps=source.fps * speed), truth.fps)
    ours, theirs = directions(source), directions(truth)
    limbs = ("upper arm", "forearm", "thigh", "shin")
    best = (np.inf, 0)
    shortest = min(source.frames, truth.frames) * 3 // 4
    for shift in range(shortest - source.frames, truth.frames - shortest + 1):
        a, b = max(0, -shift), max(0, shift)
        count = min(source.frames - a, truth.frames - b)
        error = np.mean([_angles(ours[limb][a : a + count], theirs[limb][b : b + count]).mean() for limb in limbs])
        best = min(best, (float(error), shift))
    shift = best[1]
    a, b = max(0, -shift), max(0, shift)
    count = min(source.frames - a, truth.frames - b)
    return _cut(source, a, count), _cut(truth, b, count), shift


def _cut(motion: Motion, start: int, count: int) -> Motion:
    part = slice(start, start + count)
    return replace(motion, rotations=motion.rotations[part], translations=motion.translations[part])


def hips_error(motion: Motion, truth: Motion) -> float:
    """Mean distance of the hips from the truth's, in % of its leg length, the mean place on the ground taken out."""
    from kinestitch.rig.hips import hip_height, hips_joint

    joint = hips_joint(truth.skeleton)
    ours, theirs = (world_pose(m, [joint]).positions[:, joint] for m in (motion, truth))
    gap = ours - theirs
    gap[:, [0, 2]] -= gap[:, [0, 2]].mean(axis=0)
    return float(np.linalg.norm(gap, axis=-1).mean() / hip_height(truth.skeleton) * 100)


def toe_slide(motion: Motion, source: Motion) -> float:
    """Mean speed over the ground in cm/s of toes in frames in which the source's stand (move by less than 10 cm/s)."""
    speeds = []
    for side in ("left", "right"):
        ours, theirs = (roles_of(m.skeleton).joints.get(f"{side}_toe") for m in (motion, source))
        if ours is None or theirs is None:
            return float("nan")
        paths = (world_pose(m, [joint]).positions[:, joint] for m, joint in ((motion, ours), (source, theirs)))
        ours_speed, theirs_speed = (np.linalg.norm(np.diff(path[:, [0, 2]], axis=0), axis=-1) for path in paths)
        speeds.append(ours_speed[theirs_speed * source.fps < _STANDS] * motion.fps)
    return float(np.concatenate(speeds).mean() * 100)


def rest_difference(source: Skeleton, target: Skeleton) -> float:
    """Mean angle in degrees between the limbs' directions at rest."""
    still = [Motion(skeleton, skeleton.offsets[None], skeleton.rest[None], 30.0) for skeleton in (source, target)]
    return float(np.mean(list(direction_errors(*still).values())))


def _row(name: str, errors: dict[str, float], *more: str) -> str:
    cells = [f"{errors[limb]:.1f}" if limb in errors else "–" for limb in BONES]
    return f"| {name} | {' | '.join([*cells, *more])} |"


def _table(*columns: str) -> list[str]:
    names = ["", *BONES, *columns]
    return [f"| {' | '.join(names)} |", f"|---|{'---:|' * (len(names) - 1)}"]


def known_table(folder: Path) -> list[str]:
    """Clips that exist on both rigs: every method against what the source's own retargeting made of them."""
    lines = []
    for case in CASES:
        source, truth, shift = aligned(files.read(folder / case.source), files.read(folder / case.truth), case.speed)
        rest = rest_difference(source.skeleton, truth.skeleton)
        lines += [
            f"**{Path(case.source).stem} ({Path(case.source).parent}) → {Path(case.truth).stem} "
            f"({Path(case.truth).parent})**: {source.frames} frames at {truth.fps:g} fps, speed {case.speed:g}, shift "
            f"{shift}, rest poses {rest:.0f}° apart",
            "",
            *_table("hips, % of leg"),
            _row("the two clips themselves", direction_errors(source, truth), "–"),
        ]
        for name, method in METHODS.items():
            result = method(source, truth)
            path = f"{hips_error(result, truth):.1f}" if name.startswith("kinestitch") else "–"
            lines.append(_row(name, direction_errors(result, truth), path))
        lines.append("")
    return lines


def crossing_table(folder: Path) -> list[str]:
    """Clips between families: how far the result's limbs point from the source's own."""
    lines = []
    for path, onto in CROSSINGS:
        source, target = files.read(folder / path), files.read(folder / onto)
        rest = rest_difference(source.skeleton, target.skeleton)
        lines += [
            f"**{Path(path).stem} → the rig of {Path(onto).stem}**: rest poses {rest:.0f}° apart; the source's own "
            f"toes slide at {toe_slide(source, source):.1f} cm/s where they stand",
            "",
            *_table("toe slide, cm/s"),
        ]
        for name, method in METHODS.items():
            result = method(source, target)
            slide = f"{toe_slide(result, source):.1f}" if name.startswith("kinestitch") else "–"
            lines.append(_row(name, direction_errors(result, source), slide))
        lines.append("")
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path)
    parser.add_argument("-o", "--output", type=Path, required=True)
    options = parser.parse_args(arguments)
    lines = [
        "# Retargeting, measured",
        "",
        "Written by `python -m kinestitch.experiments.retargeting`. Every figure is the mean angle in degrees between",
        "the directions of a limb's bones in the world, over all frames and both sides. How it works stands in",
        "[rigs.md](rigs.md).",
        "",
        "## Where the truth is known",
        "",
        "The same clip on two rigs, both made by Mixamo, whose joints have alike axes: there a copy of local rotations",
        "is what Mixamo itself did above the legs. *The two clips themselves* says by how much its legs, trunk and",
        "hands differ from the clip they were made from. `readyplayerme_Punching` and `Punching_Right` prove to be two",
        "different takes (30° apart however they are shifted); the former is the take of `fbx7400_Punching`.",
        "",
        *known_table(options.folder),
        "## From one family to another",
        "",
        "No truth is known, but the limbs should point where the source's do. Foot IK bends legs on purpose, where",
        "thighs, shins and hips have other proportions. Directions of trunk and foot depend on where a rig puts its",
        "joints: feet that stand flat count as alike, whatever the angle from ankle to toe.",
        "",
        *crossing_table(options.folder),
    ]
    options.output.write_text("\n".join(lines).rstrip() + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
