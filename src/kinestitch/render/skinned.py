"""A character in its skin: linear blend skinning, light from one side, far triangles first; no graphics card needed."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.kinematics import WorldPose, rest_pose, world_pose
from kinestitch.core.mesh import Mesh
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_rotate, quat_to_matrix
from kinestitch.errors import SkeletonMismatchError
from kinestitch.render.canvas import Canvas
from kinestitch.render.stage import CAST, INK, ToPixels

LIGHT, AMBIENT = (0.4, 0.6, 0.75), 0.45
"""Where the light comes from, told to the right, up and towards the eye; and what is left of it in the shade."""
_KEPT = 8


@dataclass(frozen=True, eq=False, slots=True)
class Character:
    """A mesh that can stand on a stage, in any pose of a motion on its skeleton."""

    mesh: Mesh
    _poses: list[tuple[Motion, WorldPose]] = field(default_factory=list)

    def draw(self, canvas: Canvas, motion: Motion, frame: int, *, to_pixels: ToPixels) -> None:
        """Draw one pose and its shadow. Raises SkeletonMismatchError for a motion of another rig."""
        vertices, normals = self.posed(motion, frame)
        triangles = self.mesh.triangles
        grounded = to_pixels(vertices * [1.0, 0.0, 1.0] + [0.0, to_pixels.centre[1], 0.0])[triangles][..., :2]
        canvas.shapes(grounded[_ahead(grounded)], INK, alpha=CAST)  # seen from above: the other half would undo it
        corners = to_pixels(vertices)[triangles]
        front = np.flatnonzero(_ahead(corners))
        order = front[np.argsort(corners[front, :, 2].sum(axis=1), kind="stable")]
        camera = to_pixels.camera
        light = np.stack([camera.right, camera.up, camera.toward], axis=1) @ np.array(LIGHT)
        bright = AMBIENT + (1 - AMBIENT) * np.clip(normals @ (light / np.linalg.norm(light)), 0.0, 1.0)
        shade = bright[triangles[order]][..., None] * self.mesh.colours[order][:, None]
        canvas.triangles(corners[order][..., :2], shade)

    def posed(self, motion: Motion, frame: int) -> tuple[Array, Array]:
        """Vertices (V, 3) m and unit normals (V, 3) of one frame, in the world."""
        mesh = self.mesh
        pose = self._pose(motion)
        places, turns = rest_pose(mesh.skeleton)
        turned = quat_multiply(pose.rotations[frame], quat_conjugate(turns))
        moved = pose.positions[frame] - quat_rotate(turned, places)
        blended = mesh.weights @ np.concatenate([quat_to_matrix(turned).reshape(-1, 9), moved], axis=1)
        linear = blended[:, :9].reshape(-1, 3, 3)
        vertices = np.einsum("vij,vj->vi", linear, mesh.vertices) + blended[:, 9:]
        normals = np.einsum("vij,vj->vi", linear, mesh.normals)
        return vertices, normals / np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)

    def _pose(self, motion: Motion) -> WorldPose:
        """Forward kinematics of a motion; kept for the last few, which are shown side by side."""
        for known, pose in self._poses:
            if known is motion:
                return pose
        _check(self.mesh, motion)
        self._poses[_KEPT - 1 :] = []
        self._poses.insert(0, (motion, world_pose(motion)))
        return self._poses[0][1]


def _ahead(corners: Array) -> NDArray[np.bool_]:
    """Which triangles (T, 3, 2 or 3) on paper turn their outside to us."""
    a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] > 0


def _check(mesh: Mesh, motion: Motion) -> None:
    if motion.skeleton.names != mesh.skeleton.names:
        raise SkeletonMismatchError(
            f"Expected a motion of the character's {mesh.skeleton.joint_count} joints, "
            f"got one of {motion.skeleton.joint_count}. Match or retarget it first. ({motion.name})"
        )
