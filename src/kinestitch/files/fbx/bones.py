"""Which models are joints, and what their rest pose is."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.errors import FormatError
from kinestitch.files.fbx.animation import Take
from kinestitch.files.fbx.nodes import Node
from kinestitch.files.fbx.scene import Key, Scene

SCENE: Key = "\x00scene"  # stands for the scene itself, where several trees of joints have nothing else above them


def choose_joints(scene: Scene, take: Take | None) -> tuple[Key, ...]:
    """Keys of the models that become joints, parents first: bones; else the animated models and their ancestors.

    Several bones without a bone above them get their nearest common ancestor as root, or ``SCENE`` if there is none.
    Raises FormatError where a file has neither bones nor animation.
    """
    chosen = {key for key, model in scene.models.items() if model.is_bone}
    if not chosen and take is not None:
        for (key, _), _ in take.curves():
            chosen.update(ancestry(scene, key))
        chosen = {key for key in chosen if scene.models[key].kind not in {"Camera", "CameraSwitcher", "Light"}}
    if not chosen:
        raise FormatError("Expected bones or animated objects, got neither. Export the file with its skeleton.")
    roots = [key for key in chosen if nearest_above(scene, key, chosen) is None]
    if len(roots) > 1:
        shared = set.intersection(*(set(ancestry(scene, key)) for key in roots))
        if not shared:
            return (SCENE, *(key for key in scene.models if key in chosen))
        chosen.add(max(shared, key=lambda key: len(ancestry(scene, key))))
    return tuple(key for key in scene.models if key in chosen)


def ancestry(scene: Scene, key: Key) -> list[Key]:
    """The model and its ancestors, from itself upwards."""
    path = [key]
    while path[-1] in scene.parents:
        path.append(scene.parents[path[-1]])
    return path


def nearest_above(scene: Scene, key: Key, chosen: Iterable[Key]) -> Key | None:
    """The nearest ancestor of `key` among `chosen`."""
    above = next((above for above in ancestry(scene, key)[1:] if above in chosen), None)
    return SCENE if above is None and key != SCENE and SCENE in chosen else above


def bind_matrices(scene: Scene) -> dict[Key, Array]:
    """World matrices (4, 4) of the bind pose by model: from Pose objects, else from the skin clusters."""
    found: dict[Key, Array] = {}
    for node in scene.objects.values():
        if node.name == "Pose" and (node.text(len(node.properties) - 1) == "BindPose" or _says_bind(node)):
            for entry in node.all("PoseNode"):
                target, matrix = entry.child("Node"), entry.child("Matrix")
                if target is not None and target.properties and matrix is not None:
                    _keep(found, target.properties[0], matrix.array())
    if found:
        return found
    for key, node in scene.objects.items():
        if node.name == "Deformer" and node.child("TransformLink") is not None:
            matrix = node.child("TransformLink")
            for link in scene.children.get(key, []):
                if link.child in scene.models and matrix is not None:
                    _keep(found, link.child, matrix.array())
    return found


def _says_bind(node: Node) -> bool:
    child = node.child("Type")
    return child is not None and child.text() == "BindPose"


def _keep(found: dict[Key, Array], key: object, values: Array) -> None:
    if isinstance(key, int | str) and values.shape == (16,) and np.isfinite(values).all():
        found.setdefault(key, values.reshape(4, 4).T)
