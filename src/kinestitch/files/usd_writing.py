"""A motion as a USD stage."""

from __future__ import annotations

import re
from typing import Any

import numpy as np

from kinestitch.core.kinematics import rest_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_continuous, quat_to_matrix
from kinestitch.core.skeleton import Skeleton
from kinestitch.files.extras import optional
from kinestitch.files.naming import unique_names

UNITS = {"m": 1.0, "cm": 0.01}
"""metersPerUnit of the units that may be written."""


def legal_name(name: str, default: str) -> str:
    """The name as an identifier of ASCII letters, digits and ``_``, which every USD reader takes."""
    legal = re.sub(r"[^A-Za-z0-9_]", "_", name) or default
    return f"_{legal}" if legal[0].isdigit() else legal


def joint_paths(skeleton: Skeleton) -> list[str]:
    """Tokens of the joints: legal names joined by ``/`` from the root down."""
    legal, _ = unique_names([legal_name(name, "joint") for name in skeleton.names])
    paths: list[str] = []
    for name, parent in zip(legal, skeleton.parents, strict=True):
        paths.append(f"{paths[parent]}/{name}" if parent >= 0 else name)
    return paths


def build_stage(motion: Motion, unit: float) -> Any:
    """A stage in memory with SkelRoot, Skeleton and SkelAnimation; lengths in units of `unit` metres."""
    usd, geom, skel = (optional(f"pxr.{name}", "usd") for name in ("Usd", "UsdGeom", "UsdSkel"))
    vt = optional("pxr.Vt", "usd")
    stage = usd.Stage.CreateInMemory()
    geom.SetStageUpAxis(stage, geom.Tokens.y)
    geom.SetStageMetersPerUnit(stage, unit)
    stage.SetTimeCodesPerSecond(motion.fps)
    stage.SetFramesPerSecond(motion.fps)
    stage.SetStartTimeCode(0)
    stage.SetEndTimeCode(motion.frames - 1)
    root = skel.Root.Define(stage, "/Character")
    stage.SetDefaultPrim(root.GetPrim())
    skeleton = skel.Skeleton.Define(stage, "/Character/Skeleton")
    paths = vt.TokenArray(joint_paths(motion.skeleton))
    skeleton.CreateJointsAttr(paths)
    skeleton.CreateJointNamesAttr(vt.TokenArray(list(motion.skeleton.names)))
    local = _matrices(motion.skeleton.offsets / unit, motion.skeleton.rest)
    positions, rotations = rest_pose(motion.skeleton)
    skeleton.CreateRestTransformsAttr(vt.Matrix4dArray.FromNumpy(local))
    skeleton.CreateBindTransformsAttr(vt.Matrix4dArray.FromNumpy(_matrices(positions / unit, rotations)))
    animation = skel.Animation.Define(stage, f"/Character/Skeleton/{legal_name(motion.name, 'Animation')}")
    animation.CreateJointsAttr(paths)
    _animate(animation, motion, unit)
    for prim in (root.GetPrim(), skeleton.GetPrim()):
        binding = skel.BindingAPI.Apply(prim)
        binding.CreateSkeletonRel().SetTargets([skeleton.GetPath()])
        binding.CreateAnimationSourceRel().SetTargets([animation.GetPath()])
    return stage


def _matrices(positions: Array, rotations: Array) -> Array:
    """(J, 4, 4) for row vectors, as USD has them."""
    matrices = np.tile(np.eye(4), (len(positions), 1, 1))
    matrices[:, :3, :3] = np.swapaxes(quat_to_matrix(rotations), 1, 2)
    matrices[:, 3, :3] = positions
    return matrices


def _animate(animation: Any, motion: Motion, unit: float) -> None:
    vt = optional("pxr.Vt", "usd")
    translations = (motion.translations / unit).astype(np.float32)
    rotations = quat_continuous(motion.rotations).astype(np.float32)
    scales = vt.Vec3hArray.FromNumpy(np.ones((motion.skeleton.joint_count, 3), dtype=np.float16))
    animation.CreateScalesAttr(scales)
    placed, turned = animation.CreateTranslationsAttr(), animation.CreateRotationsAttr()
    if (translations == translations[:1]).all():
        placed.Set(vt.Vec3fArray.FromNumpy(translations[0]))
    else:
        for frame, row in enumerate(translations):
            placed.Set(vt.Vec3fArray.FromNumpy(row), frame)
    for frame, row in enumerate(rotations):
        turned.Set(vt.QuatfArray.FromNumpy(row), frame)
