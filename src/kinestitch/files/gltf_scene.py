"""glTF nodes: their tree, which of them are joints, and where they stand in the world at any time."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array, matrix_to_quat, quat_multiply, quat_normalize, quat_to_matrix
from kinestitch.errors import FormatError, KinestitchWarning
from kinestitch.files.gltf_animation import Take
from kinestitch.files.gltf_document import GltfDocument, numbers, wholes


@dataclass(frozen=True, slots=True)
class World:
    """Where a node stands at N times, or at all times where N is 1.

    linear : (N, 3, 3) rotation and scale
    position : (N, 3) m
    turn : (N, 4) product of the rotations alone
    """

    linear: Array
    position: Array
    turn: Array


def parents_of(document: GltfDocument) -> list[int]:
    """Parent of each node, -1 for those at the top; raises FormatError if the nodes are no forest."""
    nodes = document.objects("nodes")
    parents = [-1] * len(nodes)
    for index, node in enumerate(nodes):
        for below in wholes(node, "children", below=len(nodes)):
            if parents[below] >= 0:
                raise FormatError(f"Expected one parent for node {below}, got {parents[below]} and {index}.")
            parents[below] = index
    reached = [index for index, parent in enumerate(parents) if parent < 0]
    for index in reached:  # grows while it is walked through
        reached.extend(wholes(nodes[index], "children", below=len(nodes)))
    if len(reached) < len(nodes):
        cyclic = min(set(range(len(nodes))) - set(reached))
        raise FormatError(f"Expected a tree of nodes, got a cycle through or above node {cyclic}.")
    return parents


def chain(parents: list[int], node: int) -> list[int]:
    """The node and all above it, from the top down."""
    path = [node]
    while parents[path[-1]] >= 0:
        path.append(parents[path[-1]])
    return path[::-1]


def choose_joints(document: GltfDocument, parents: list[int], animated: set[int]) -> tuple[list[int], list[int]]:
    """Nodes that are joints, parents first, and for each the place of its parent joint, -1 for the one root.

    Joints are those of the skins; in a file without skins the animated nodes and all above them. Where they have
    several roots, the nearest node above them all becomes a joint too; of figures that have none in common the one with
    the most joints is read, with a warning that counts the others' joints. Raises FormatError if there are no joints.
    """
    count = len(parents)
    listed = [joint for skin in document.objects("skins") for joint in wholes(skin, "joints", below=count)]
    if not listed:
        listed = [above for node in sorted(animated) for above in chain(parents, node)]
    if not listed:
        raise FormatError("Expected a skin or animated nodes, got neither. There is no motion in this file.")
    chains = {joint: chain(parents, joint) for joint in dict.fromkeys(listed)}
    figures: dict[int, list[int]] = {}
    for joint, path in chains.items():
        figures.setdefault(path[0], []).append(joint)
    joints = max(figures.values(), key=len)
    if len(joints) < len(chains):
        warnings.warn(
            KinestitchWarning(f"{len(chains) - len(joints)} joint(s) of other figures in the file left out."),
            stacklevel=4,
        )
    members = set(joints)
    tops = [joint for joint in joints if not members.intersection(chains[joint][:-1])]
    if len(tops) > 1:
        shared = [level for level in zip(*(chains[top] for top in tops), strict=False) if len(set(level)) == 1]
        joints.insert(0, shared[-1][0])
        chains[joints[0]] = chain(parents, joints[0])
        members.add(joints[0])
    order: dict[int, int] = {}
    for joint in joints:
        for above in chains[joint]:
            if above in members:
                order.setdefault(above, len(order))
    nearest = [[order[node] for node in chain(parents, joint)[:-1] if node in members] for joint in order]
    return list(order), [places[-1] if places else -1 for places in nearest]


def local_pose(document: GltfDocument, node: int, take: Take | None, times: Array, frame: float) -> World:
    """A node's transform in its parent's frame at `times` (N,) s; one row where it does not move."""
    entry = document.objects("nodes")[node]
    if "matrix" in entry:
        matrix = numbers(entry, "matrix", (0.0,) * 16).reshape(4, 4).T
        linear = matrix[None, :3, :3]
        return World(linear, matrix[None, :3, 3], proper_rotations(linear, np.array([[0.0, 0.0, 0.0, 1.0]])))
    values = {
        "translation": numbers(entry, "translation", (0.0, 0.0, 0.0))[None],
        "rotation": quat_normalize(numbers(entry, "rotation", (0.0, 0.0, 0.0, 1.0)))[None],
        "scale": numbers(entry, "scale", (1.0, 1.0, 1.0))[None],
    }
    for path in values:
        track = None if take is None else take.tracks.get((node, path))
        if track is not None:
            values[path] = track.at(times, frame)
    linear = quat_to_matrix(values["rotation"]) * values["scale"][:, None, :]
    return World(linear, values["translation"], values["rotation"])


def below(above: World, local: World) -> World:
    """A child's transform in the frame of its grandparent."""
    position = above.position + (above.linear @ local.position[..., None])[..., 0]
    return World(above.linear @ local.linear, position, quat_multiply(above.turn, local.turn))


def worlds(
    document: GltfDocument, parents: list[int], joints: list[int], take: Take | None, *, times: Array, frame: float
) -> dict[int, World]:
    """Where the joints and all nodes above them stand at `times` (N,) s."""
    done: dict[int, World] = {}
    for joint in joints:
        for node in chain(parents, joint):
            if node not in done:
                local = local_pose(document, node, take, times, frame)
                done[node] = below(done[parents[node]], local) if parents[node] >= 0 else local
    return done


def rigid_poses(places: dict[int, World], joints: list[int], count: int) -> tuple[Array, Array]:
    """World positions (N, J, 3) m and rotations (N, J, 4) of the joints.

    A joint's rotation is that of its frame without scale and shear, and where a frame is mirrored, with its x axis
    turned back. Raises FormatError where scales upon scales overflow.
    """
    positions = np.empty((count, len(joints), 3))
    rotations = np.empty((count, len(joints), 4))
    for place, joint in enumerate(joints):
        if not (np.isfinite(places[joint].linear).all() and np.isfinite(places[joint].position).all()):
            raise FormatError(f"Expected finite transforms above node {joint}, got an overflow.")
        positions[:, place] = places[joint].position
        rotations[:, place] = proper_rotations(places[joint].linear, places[joint].turn)
    return positions, rotations


def proper_rotations(linear: Array, turn: Array) -> Array:
    """Quaternions (N, 4) of frames (N, 3, 3) without their scale and shear; `turn` (N, 4) where a frame is flat."""
    mirrored = np.linalg.det(linear) < 0
    frames = np.where(mirrored[:, None, None] & np.array([True, False, False]), -linear, linear)
    lengths = np.linalg.norm(frames, axis=-2, keepdims=True)
    flat = lengths.min(axis=(1, 2)) <= 1e-9 * np.maximum(lengths.max(axis=(1, 2)), 1e-9)
    frames = frames / np.where(lengths > 0, lengths, 1.0)
    skew = np.abs(np.swapaxes(frames, -1, -2) @ frames - np.eye(3)).max(axis=(1, 2)) > 1e-6
    if skew.any():
        u, _, v = np.linalg.svd(frames[skew])
        u[..., -1] *= np.where(np.linalg.det(u @ v) < 0, -1.0, 1.0)[:, None]
        frames[skew] = u @ v
    quaternions = matrix_to_quat(frames)
    return np.where(flat[:, None], quat_normalize(np.broadcast_to(turn, quaternions.shape)), quaternions)
