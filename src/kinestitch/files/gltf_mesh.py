"""The surface of a glTF character: its triangles in the rest pose, and the joints they hang on."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.mesh import Mesh
from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError
from kinestitch.files.gltf_document import GltfDocument, Json, child, load_document, numbers, objects, whole, wholes
from kinestitch.files.gltf_figure import Figure, open_figure
from kinestitch.files.gltf_rest import bind_way, inverse_bind_matrices
from kinestitch.files.naming import naming

_TRIANGLES = 4
_GREY = (0.84, 0.85, 0.87)
_Piece = tuple[Array, Array, NDArray[np.intp], Array, Array]


def read_mesh(path: str | os.PathLike[str]) -> Mesh:
    """Read the skinned meshes of a .glb or .gltf file, on the skeleton that :func:`read_gltf` reads.

    Colours are those of the materials, textures do not count. Morph targets, and meshes that hang on a
    node without a skin, are left out.

    Raises FormatError for damaged files and files without a skinned mesh, FileNotFoundError.
    """
    with naming(path), np.errstate(all="ignore"):
        document = load_document(Path(path))
        figure = open_figure(document, None)
        pieces = [piece for node in document.objects("nodes") for piece in _pieces(figure, node)]
        if not pieces:
            raise FormatError("Expected a mesh with a skin, got none. Only a character can be shown.")
        first = np.cumsum([0, *(len(piece[0]) for piece in pieces)])
        triangles = [piece[2] + start for piece, start in zip(pieces, first[:-1], strict=True)]
        vertices, normals, weights, colours = (np.concatenate([piece[i] for piece in pieces]) for i in (0, 1, 3, 4))
        if not np.isfinite(vertices).all():
            raise FormatError("Expected finite vertices, got an overflow.")
        return Mesh(figure.skeleton, vertices, normals, np.concatenate(triangles), weights, colours)


def _pieces(figure: Figure, node: Json) -> list[_Piece]:
    document = figure.document
    if "mesh" not in node or "skin" not in node:
        return []
    mesh = document.objects("meshes")[whole(node, "mesh", below=len(document.objects("meshes")))]
    skin = document.objects("skins")[whole(node, "skin", below=len(document.objects("skins")))]
    joints = wholes(skin, "joints", below=len(document.objects("nodes")))
    if not set(joints) <= set(figure.joints):
        return []  # another figure's
    places = np.array([figure.joints.index(joint) for joint in joints])
    found = objects(mesh, "primitives")
    return [
        _piece(figure, primitive, places)
        for primitive in found
        if whole(primitive, "mode", below=7, default=_TRIANGLES) == _TRIANGLES
        and {"POSITION", "JOINTS_0", "WEIGHTS_0"} <= set(child(primitive, "attributes"))
    ]


def _piece(figure: Figure, primitive: Json, places: NDArray[np.intp]) -> _Piece:
    document = figure.document
    attributes = child(primitive, "attributes")
    way = _way(figure)
    vertices = _values(document, attributes, "POSITION", "VEC3")
    count = len(vertices)
    if "indices" in primitive:
        index = whole(primitive, "indices", below=len(document.objects("accessors")))
        order = document.accessor(index, "SCALAR")[:, 0].astype(np.intp)
    else:
        order = np.arange(count)
    triangles = order[: len(order) // 3 * 3].reshape(-1, 3)
    if len(triangles) and triangles.max() >= count:
        raise FormatError(f"Expected indices from 0 to {count - 1}, got {triangles.max()}.")
    vertices = vertices @ way[:3, :3].T + way[:3, 3]
    if np.linalg.det(way[:3, :3]) < 0:
        triangles = triangles[:, ::-1]
    colours = np.broadcast_to(_colour(document, primitive), (len(triangles), 3))
    return (
        vertices,
        _normals(vertices, triangles),
        triangles,
        _weights(document, attributes, places, count, len(figure.joints)),
        colours,
    )


def _values(document: GltfDocument, attributes: Json, name: str, kind: str) -> Array:
    return document.accessor(whole(attributes, name, below=len(document.objects("accessors"))), kind)


def _way(figure: Figure) -> Array:
    """From the space of the mesh to the world of the rest pose (4, 4)."""
    inverse = inverse_bind_matrices(figure.document, len(figure.parents))
    return bind_way(figure.document, figure.parents, figure.joints, inverse)


def _weights(document: GltfDocument, attributes: Json, places: NDArray[np.intp], count: int, joint_count: int) -> Array:
    """Share (V, J) of each joint of the figure."""
    total = np.zeros((count, joint_count))
    level = 0
    while f"JOINTS_{level}" in attributes and f"WEIGHTS_{level}" in attributes:
        joints = _values(document, attributes, f"JOINTS_{level}", "VEC4").astype(np.intp)
        shares = _values(document, attributes, f"WEIGHTS_{level}", "VEC4")
        if joints.shape != shares.shape or len(joints) != count:
            raise FormatError(f"Expected joints and weights for {count} vertices, got {len(joints)} and {len(shares)}.")
        if joints.max(initial=0) >= len(places) or joints.min(initial=0) < 0:
            raise FormatError(f"Expected joints from 0 to {len(places) - 1}, got {joints.max()}.")
        np.add.at(total, (np.arange(count)[:, None], places[joints]), shares)
        level += 1
    size = total.sum(axis=1, keepdims=True)
    total[size[:, 0] <= 0, places[0]] = 1.0
    return total / np.where(size > 0, size, 1.0)


def _colour(document: GltfDocument, primitive: Json) -> Array:
    materials = document.objects("materials")
    if "material" not in primitive:
        return np.array(_GREY)
    material = materials[whole(primitive, "material", below=len(materials))]
    surface = material.get("pbrMetallicRoughness")
    if not isinstance(surface, dict) or "baseColorTexture" in surface:
        return np.array(_GREY)
    linear = np.clip(numbers(surface, "baseColorFactor", (1.0, 1.0, 1.0, 1.0))[:3], 0.0, 1.0)
    return np.where(linear <= 0.0031308, 12.92 * linear, 1.055 * linear ** (1 / 2.4) - 0.055)


def _normals(vertices: Array, triangles: NDArray[np.intp]) -> Array:
    """Unit normals (V, 3): the mean of the triangles around a place, seams of the texture included."""
    corners = vertices[triangles]
    faces = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    _, place = np.unique(np.round(vertices, 6), axis=0, return_inverse=True)
    place = place.reshape(-1)
    summed = np.stack(
        [
            np.bincount(place[triangles].ravel(), np.repeat(faces[:, axis], 3), minlength=len(vertices))
            for axis in range(3)
        ],
        axis=1,
    )[place]
    return summed / np.maximum(np.linalg.norm(summed, axis=1, keepdims=True), 1e-30)
