"""A motion written into a glTF file that has a character: one animation is replaced, everything else is kept.

What is kept is kept byte for byte: buffers, bufferViews, accessors, meshes, skins, materials, textures, images,
cameras, the other animations, extras, extensions, unknown chunks. The new keys stand in one new bufferView behind the
old data of a GLB's binary chunk (in a .gltf: in one new buffer). The keys that they replace stay in the file, unused,
because nothing in a glTF file says that an extension does not point to them.

The new animation begins when the old one began and has its name, its extras, and its channels of everything that is no
part of the skeleton (morph weights, props), cut where they outlast the motion. Scale keys of joints and the keys of
nodes above the skeleton become one key, as the old animation began. A joint whose node has a matrix gets the same as
translation, rotation and scale, since a matrix cannot be animated.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_continuous
from kinestitch.errors import KinestitchWarning, SkeletonMismatchError
from kinestitch.files.gltf_animation import MARK, PATHS, animation_name
from kinestitch.files.gltf_document import WIDTHS, GltfDocument, Json, child, load_document, objects, text, whole
from kinestitch.files.gltf_enclosing import with_bytes
from kinestitch.files.gltf_figure import Figure, open_figure
from kinestitch.files.gltf_inverse import Held, held, joint_keys
from kinestitch.files.likeness import told_on
from kinestitch.files.naming import naming

FLOAT = 5126
_STILL = 2e-7
"""Values that float32 cannot tell apart are one key."""


def kept_file(motion: Motion, path: Path, like: Path, take: str | None) -> Iterator[bytes]:
    """The bytes of `like` with the motion in it, for a file `path` that ends in .glb or .gltf.

    take : the animation to replace; None takes the one of the motion's name, else the one that reading takes

    Raises SkeletonMismatchError, ParameterError, and what reading raises.
    """
    with naming(like), np.errstate(all="ignore"):
        document = load_document(like)
        names = [animation_name(entry, index) for index, entry in enumerate(document.objects("animations"))]
        with warnings.catch_warnings(action="ignore", category=KinestitchWarning):  # whoever read it has been told
            figure = open_figure(document, take or (motion.name if motion.name in names else None))
        try:
            told = told_on(motion, figure.skeleton)
        except SkeletonMismatchError as error:
            raise SkeletonMismatchError(f"{error} ({like})") from None
        builder = _Builder(document)
        _animate(builder, figure, told)
        lists = {"nodes": builder.nodes, "accessors": builder.accessors, "animations": builder.animations}
        return with_bytes(document, lists, b"".join(builder.pieces), path, like)


@dataclass(slots=True)
class _Builder:
    """The lists of a document that grow, and the pieces of the bufferView that is added."""

    document: GltfDocument
    nodes: list[Json] = field(init=False)
    accessors: list[Json] = field(init=False)
    animations: list[Json] = field(init=False)
    pieces: list[bytes] = field(default_factory=list)
    size: int = 0

    def __post_init__(self) -> None:
        self.nodes = list(self.document.objects("nodes"))
        self.accessors = list(self.document.objects("accessors"))
        self.animations = list(self.document.objects("animations"))

    def add(self, values: Array, kind: str) -> int:
        """Index of a new accessor of the values (count, …) as float32."""
        data = np.ascontiguousarray(values, dtype="<f4")
        entry: Json = {"bufferView": len(self.document.objects("bufferViews")), "byteOffset": self.size}
        entry |= {"componentType": FLOAT, "count": len(data), "type": kind}
        if kind == "SCALAR":
            entry |= {"min": [float(data.min())], "max": [float(data.max())]}
        self.pieces.append(data.tobytes())
        self.size += data.nbytes
        self.accessors.append(entry)
        return len(self.accessors) - 1


def _animate(builder: _Builder, figure: Figure, motion: Motion) -> None:
    """Put the motion in the place of the figure's take, or behind the animations where there is none."""
    start = float(figure.times[0])
    nodes = {node: held(figure.document, node, figure.take, start) for node in sorted(figure.moving)}
    _free_matrices(builder, figure, nodes)
    old: Json = figure.document.objects("animations")[figure.take.index] if figure.take else {}
    keys = _Keys(builder, start + np.arange(motion.frames) / motion.fps)
    translations, rotations = joint_keys(figure, motion, nodes)
    for place, joint in enumerate(figure.joints):
        keys.add(joint, "translation", translations[:, place], whole=place == 0)
        keys.add(joint, "rotation", quat_continuous(rotations[:, place]), whole=place == 0)
    for node, path in figure.take.tracks if figure.take else ():
        if "matrix" not in builder.nodes[node] and (path == "scale" or node not in figure.joints):
            keys.add(node, path, np.asarray(getattr(nodes[node], path))[None])
    _keep_others(builder, keys, old, figure)
    extras = old.get("extras", {})
    if isinstance(extras, dict):
        extras = {**extras, "fps": motion.fps, MARK[0]: MARK[1]}
    new = {"name": motion.name or "motion", **old, "samplers": keys.samplers, "channels": keys.channels}
    builder.animations = [_unmarked(entry) for entry in builder.animations]
    place = figure.take.index if figure.take else len(builder.animations)
    builder.animations[place : place + 1] = [new | {"extras": extras}]


class _Keys:
    """Samplers and channels of an animation while they gather."""

    def __init__(self, builder: _Builder, times: Array) -> None:
        self.builder = builder
        self.times = times
        self.samplers: list[Json] = []
        self.channels: list[Json] = []
        self._inputs: dict[int, int] = {}

    def add(self, node: int, path: str, values: Array, *, whole: bool = False) -> None:
        """A channel of values (F, n), one key where they do not change; `whole` keeps every key all the same."""
        single = values.astype(np.float32)
        if not whole and np.abs(single - single[0]).max() <= _STILL * np.abs(single).max():
            values = values[:1]
        if len(values) not in self._inputs:
            self._inputs[len(values)] = self.builder.add(self.times[: len(values)], "SCALAR")
        sampler = {
            "input": self._inputs[len(values)],
            "interpolation": "LINEAR",
            "output": self.builder.add(values, PATHS[path]),
        }
        self.channels.append({"sampler": len(self.samplers), "target": {"node": node, "path": path}})
        self.samplers.append(sampler)


def _free_matrices(builder: _Builder, figure: Figure, nodes: dict[int, Held]) -> None:
    for joint in figure.joints:
        if "matrix" in builder.nodes[joint]:
            parts = {path: getattr(nodes[joint], path).tolist() for path in PATHS}
            builder.nodes[joint] = {k: v for k, v in builder.nodes[joint].items() if k != "matrix"} | parts


def _unmarked(animation: Json) -> Json:
    extras = animation.get("extras")
    if not isinstance(extras, dict) or extras.get(MARK[0]) != MARK[1]:
        return animation
    left = {key: value for key, value in extras.items() if key != MARK[0]}
    return {key: value for key, value in animation.items() if key != "extras"} | ({"extras": left} if left else {})


def _keep_others(builder: _Builder, keys: _Keys, old: Json, figure: Figure) -> None:
    """The old animation's channels of what is no part of the skeleton, as far as the motion reaches."""
    samplers = objects(old, "samplers")
    kept: dict[int, int | None] = {}
    for channel in objects(old, "channels"):
        target = child(channel, "target")
        if target.get("path") in PATHS and target.get("node") in figure.moving:
            continue
        index = whole(channel, "sampler", below=len(samplers))
        if index not in kept:
            sampler = _cut(builder, samplers[index], float(keys.times[-1]))
            kept[index] = None if sampler is None else len(keys.samplers)
            keys.samplers += [] if sampler is None else [sampler]
        if kept[index] is not None:
            keys.channels.append({**channel, "sampler": kept[index]})


def _cut(builder: _Builder, sampler: Json, stop: float) -> Json | None:
    """A sampler without its keys after `stop` s; None if none can be left."""
    document = builder.document
    source, target = (whole(sampler, key, below=len(document.objects("accessors"))) for key in ("input", "output"))
    times = document.accessor(source, "SCALAR")[:, 0]
    left = int(np.searchsorted(times, stop + 1e-4, side="right"))
    if left == len(times):
        return sampler
    entry = document.objects("accessors")[target]
    kind = text(entry, "type", "")
    if left == 0 or kind not in WIDTHS or not (entry.get("componentType") == FLOAT or entry.get("normalized") is True):
        return None
    values = document.accessor(target, kind)
    shorter = values[: len(values) // len(times) * left]
    return {**sampler, "input": builder.add(times[:left], "SCALAR"), "output": builder.add(shorter, kind)}
