"""What the reader did, undone: the nodes' own keys from joints that stand in the world."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_distance,
    quat_identity,
    quat_multiply,
    quat_normalize,
    quat_to_matrix,
)
from kinestitch.files.gltf_animation import Take
from kinestitch.files.gltf_document import GltfDocument, numbers
from kinestitch.files.gltf_figure import Figure
from kinestitch.files.gltf_scene import World, below, chain, local_pose, proper_rotations

_FRAMES_AT_A_TIME = 1024
_CLOSE = 1e-9
_ROUNDS = 40


@dataclass(frozen=True, slots=True)
class Held:
    """What a node's transform is made of: translation (3,), rotation (4,), scale (3,), in its parent's frame."""

    translation: Array
    rotation: Array
    scale: Array


def held(document: GltfDocument, node: int, take: Take | None, time: float) -> Held:
    """A node's transform as the take has it at `time` s, else as the node has it; a matrix is taken apart.

    A scale that is zero in the take and not in the node is the node's, so that what hangs below can be reached.
    """
    entry = document.objects("nodes")[node]
    if "matrix" in entry:
        matrix = numbers(entry, "matrix", (0.0,) * 16).reshape(4, 4).T
        scale = np.linalg.norm(matrix[:3, :3], axis=0)
        scale[0] *= -1.0 if np.linalg.det(matrix[:3, :3]) < 0 else 1.0
        turn = proper_rotations(matrix[None, :3, :3], quat_identity((1,)))[0]
        return Held(matrix[:3, 3], turn, scale)
    own = {
        "translation": numbers(entry, "translation", (0.0, 0.0, 0.0)),
        "rotation": quat_normalize(numbers(entry, "rotation", (0.0, 0.0, 0.0, 1.0))),
        "scale": numbers(entry, "scale", (1.0, 1.0, 1.0)),
    }
    for path, value in own.items():
        track = None if take is None else take.tracks.get((node, path))
        if track is not None:
            at = track.at(np.array([time]), 1.0)[0]
            own[path] = value if path == "scale" and not at.all() else at
    return Held(**own)


def joint_keys(figure: Figure, motion: Motion, nodes: dict[int, Held]) -> tuple[Array, Array]:
    """Translations (F, J, 3) and rotations (F, J, 4) that the joints' nodes need to show the motion.

    nodes : what every node of ``figure.moving`` is held at; only joints leave it, and they keep its scale

    The motion is told on the figure's skeleton. Reading the keys gives its world poses back, whatever turns, scales
    and mirrors stand above the joints. A joint below a scale of zero keeps its place.
    """
    pose = world_pose(motion)
    translations = np.empty(pose.positions.shape)
    rotations = np.empty(pose.rotations.shape)
    place = {joint: index for index, joint in enumerate(figure.joints)}
    for start in range(0, motion.frames, _FRAMES_AT_A_TIME):
        frames = slice(start, start + _FRAMES_AT_A_TIME)
        done: dict[int, World] = {-1: World(np.eye(3)[None], np.zeros((1, 3)), quat_identity((1,)))}
        for node in (node for joint in figure.joints for node in chain(figure.parents, joint)):
            if node in done:
                continue
            above, own = done[figure.parents[node]], nodes[node]
            if node in place:
                j = place[node]
                translations[frames, j] = _local_place(above, pose.positions[frames, j], own.translation)
                rotations[frames, j] = _local_turn(above, own.scale, pose.rotations[frames, j])
                done[node] = below(above, _local(translations[frames, j], rotations[frames, j], own.scale))
            elif "matrix" in figure.document.objects("nodes")[node]:
                done[node] = below(above, local_pose(figure.document, node, None, np.zeros(1), 1.0))
            else:
                done[node] = below(above, _local(own.translation[None], own.rotation[None], own.scale))
    return translations, rotations


def _local(translation: Array, rotation: Array, scale: Array) -> World:
    return World(quat_to_matrix(rotation) * scale, translation, rotation)


def _local_place(above: World, wanted: Array, fallback: Array) -> Array:
    """Translations (N, 3) in the frames of `above` that lead to world positions (N, 3)."""
    linear = np.broadcast_to(above.linear, (len(wanted), 3, 3))
    size = np.abs(linear).max(axis=(1, 2))
    solvable = np.abs(np.linalg.det(linear)) > 1e-12 * np.maximum(size, 1e-30) ** 3
    places = np.broadcast_to(fallback, wanted.shape).copy()
    ways = (wanted - above.position)[solvable]
    places[solvable] = np.linalg.solve(linear[solvable], ways[..., None])[..., 0]
    return places


def _local_turn(above: World, scale: Array, wanted: Array) -> Array:
    """Rotations (N, 4) whose frames, scaled and put under `above`, are read as world rotations (N, 4).

    Under turns and even scale the first guess is right. Uneven scale above a turned joint shears its frame; then the
    guess is turned on by what is missing until nothing is. Mirrors change which way that is.
    """
    signs = np.sign(scale) if scale.all() else np.ones(3)
    mirrored = np.linalg.det(above.linear) * np.prod(signs) < 0
    signs = signs * np.where(mirrored[:, None], [-1.0, 1.0, 1.0], 1.0)
    flips = signs * np.prod(signs, axis=-1, keepdims=True)
    rotation = quat_multiply(quat_conjugate(above.turn), wanted)
    for _ in range(_ROUNDS):
        shown = proper_rotations(above.linear @ (quat_to_matrix(rotation) * scale), quat_multiply(above.turn, rotation))
        if quat_distance(shown, wanted).max() < _CLOSE:
            break
        missing = quat_multiply(quat_conjugate(shown), wanted)
        missing[:, :3] *= flips
        rotation = quat_normalize(quat_multiply(rotation, missing))
    return rotation
