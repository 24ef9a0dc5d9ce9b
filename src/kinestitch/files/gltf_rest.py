"""The rest pose of a glTF skeleton: as its skin was bound."""

from __future__ import annotations

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError
from kinestitch.files.gltf_document import GltfDocument, whole, wholes
from kinestitch.files.gltf_scene import World, proper_rotations, rigid_poses, worlds

_VOTERS = 200
_MESHES = 8
_ALIKE = 1e-3


def inverse_bind_matrices(document: GltfDocument, nodes: int) -> dict[int, Array]:
    """Inverse bind matrix (4, 4) of each joint that has one; the first skin that names a joint decides."""
    found: dict[int, Array] = {}
    for skin in document.objects("skins"):
        joints = wholes(skin, "joints", below=nodes)
        if "inverseBindMatrices" not in skin:
            continue
        index = whole(skin, "inverseBindMatrices", below=len(document.objects("accessors")))
        matrices = document.accessor(index, "MAT4").reshape(-1, 4, 4).transpose(0, 2, 1)
        matrices[:, 3] = 0.0, 0.0, 0.0, 1.0  # which damaged files may not say
        if len(matrices) < len(joints):
            raise FormatError(f"Expected {len(joints)} inverse bind matrices, got {len(matrices)}.")
        for joint, matrix in zip(joints, matrices, strict=False):
            size = abs(float(np.linalg.det(matrix[:3, :3])))
            if size > 1e-12 * max(float(np.abs(matrix[:3, :3]).max()), 1e-9) ** 3:
                found.setdefault(joint, matrix)
    return found


def rest_pose_of(document: GltfDocument, parents: list[int], joints: list[int]) -> tuple[Array, Array]:
    """World positions (J, 3) m and rotations (J, 4) of the bind pose; of the nodes' own pose where a joint has none.

    A skin tells its bind pose in the space of the mesh; the way from there to the world is the mesh's own place or the
    identity, whichever more joints agree with: each joint that still stands as bound shows the way. Where none agrees,
    the way that most joints show is taken.
    """
    places = worlds(document, parents, joints, None, times=np.zeros(1), frame=1.0)
    own = rigid_poses(places, joints, 1)
    positions, rotations = own[0][0], own[1][0]
    inverse = inverse_bind_matrices(document, len(parents))
    bound = [place for place, joint in enumerate(joints) if joint in inverse]
    if not bound:
        return positions, rotations
    way = bind_way(document, parents, joints, inverse)
    world = way @ np.linalg.inv(np.array([inverse[joints[place]] for place in bound]))
    positions[bound] = world[:, :3, 3]
    rotations[bound] = proper_rotations(world[:, :3, :3], rotations[bound])
    return positions, rotations


def bind_way(document: GltfDocument, parents: list[int], joints: list[int], inverse: dict[int, Array]) -> Array:
    """The way (4, 4) from the space in which skins were bound to the world of the bind pose.

    inverse : matrices as :func:`inverse_bind_matrices` finds them; without any the way is the identity
    """
    bound = [joint for joint in joints if joint in inverse]
    if not bound:
        return np.eye(4)
    places = worlds(document, parents, joints, None, times=np.zeros(1), frame=1.0)
    size = float(np.ptp(rigid_poses(places, joints, 1)[0][0], axis=0).max()) + 1e-3
    shown = np.array([_matrix(places[joint]) @ inverse[joint] for joint in bound])
    ways = [*_mesh_places(document, parents), np.eye(4)]
    votes = [_alike(shown, way, size) for way in ways]
    if max(votes) == 0:
        ways = list(shown[:_VOTERS])
        votes = [_alike(shown, way, size) for way in ways]
    return ways[int(np.argmax(votes))]


def _mesh_places(document: GltfDocument, parents: list[int]) -> list[Array]:
    """World matrices (4, 4) of the first nodes that carry a skinned mesh."""
    meshes = [index for index, node in enumerate(document.objects("nodes")) if "skin" in node][:_MESHES]
    places = worlds(document, parents, meshes, None, times=np.zeros(1), frame=1.0)
    return [_matrix(places[mesh]) for mesh in meshes]


def _matrix(place: World) -> Array:
    matrix = np.eye(4)
    matrix[:3, :3] = place.linear[0]
    matrix[:3, 3] = place.position[0]
    return matrix


def _alike(ways: Array, way: Array, size: float) -> int:
    """How many of the ways (N, 4, 4) are the same as `way`."""
    off = np.abs(ways - way)
    turned = off[:, :3, :3].max(axis=(1, 2)) < _ALIKE * np.abs(way[:3, :3]).max()
    return int((turned & (off[:, :3, 3].max(axis=1) < _ALIKE * size)).sum())
