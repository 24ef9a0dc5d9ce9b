"""Takes: which curves move which model, layer upon layer."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.files.fbx.curves import Curve, Ticks, read_curve, sample
from kinestitch.files.fbx.nodes import Node
from kinestitch.files.fbx.scene import Key, Properties, Scene, object_name, read_properties

Target = tuple[Key, str]  # model and property name
LOCAL = ("Lcl Translation", "Lcl Rotation", "Lcl Scaling")


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """What one layer says about one property of three numbers: a curve or a constant (3,) per component."""

    curves: tuple[Curve | None, Curve | None, Curve | None]
    constants: Array

    def sample(self, ticks: Ticks) -> Array:
        """Values (N, 3) at `ticks` (N,)."""
        out = np.empty((len(ticks), 3))
        for axis, curve in enumerate(self.curves):
            out[:, axis] = self.constants[axis] if curve is None else sample(curve, ticks)
        return out


@dataclass(frozen=True, slots=True, eq=False)
class Layer:
    """One sheet of animation.

    tracks : by model and property
    properties : weight, mute, solo, blend mode and the like
    weight : curve of the layer's weight in percent, if it moves
    """

    name: str
    tracks: dict[Target, Track]
    properties: Properties = field(default_factory=dict)
    weight: Curve | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Take:
    """One clip in the file: a name and its layers, the base first."""

    name: str
    layers: tuple[Layer, ...]

    def curves(self) -> Iterator[tuple[Target, Curve]]:
        """Every curve of every layer with what it drives."""
        for layer in self.layers:
            for target, track in layer.tracks.items():
                yield from ((target, curve) for curve in track.curves if curve is not None)

    def key_count(self) -> int:
        """Number of keys in all."""
        return sum(len(curve.times) for _, curve in self.curves())


def read_takes(scene: Scene) -> tuple[Take, ...]:
    """All takes of a 7.x file, in file order."""
    cache: dict[Key, Curve | None] = {}
    return tuple(
        Take(object_name(node), tuple(_layers(scene, key, cache)))
        for key, node in scene.objects.items()
        if node.name == "AnimationStack"
    )


def _layers(scene: Scene, stack: Key, cache: dict[Key, Curve | None]) -> Iterator[Layer]:
    for link in scene.children.get(stack, []):
        node = scene.objects.get(link.child)
        if node is None or node.name != "AnimationLayer":
            continue
        tracks = {}
        weight = None
        for part in scene.children.get(link.child, []):
            inner = scene.objects.get(part.child)
            if inner is None or inner.name != "AnimationCurveNode":
                continue
            if part.name == "Weight":
                weight = next(iter(_curves(scene, part.child, cache).values()), None)
            for target in scene.driven.get(part.child, []):
                if target[1] in LOCAL:
                    tracks[target] = _track(scene, part.child, inner, target, cache)
        yield Layer(
            object_name(node), tracks, {**scene.templates.get("AnimationLayer", {}), **read_properties(node)}, weight
        )


def _curves(scene: Scene, key: Key, cache: dict[Key, Curve | None]) -> dict[str, Curve]:
    found = {}
    for link in scene.children.get(key, []):
        node = scene.objects.get(link.child)
        if node is not None and node.name == "AnimationCurve":
            if link.child not in cache:
                cache[link.child] = read_curve(node)
            curve = cache[link.child]
            if curve is not None:
                found[link.name] = curve
    return found


def _track(scene: Scene, key: Key, node: Node, target: Target, cache: dict[Key, Curve | None]) -> Track:
    curves = _curves(scene, key, cache)
    properties = read_properties(node)
    usual = scene.models[target[0]].vector(target[1], 1.0 if target[1] == LOCAL[2] else 0.0)
    constants = [
        next((v for v in properties.get(name, ()) if isinstance(v, int | float) and np.isfinite(v)), usual[axis])
        for axis, name in enumerate(("d|X", "d|Y", "d|Z"))
    ]
    x, y, z = (curves.get(name) for name in ("d|X", "d|Y", "d|Z"))
    return Track((x, y, z), np.array(constants, dtype=np.float64))
