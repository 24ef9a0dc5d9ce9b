"""Sheets of animation laid over each other: what a property is worth when every layer has spoken."""

from __future__ import annotations

import numpy as np

from kinestitch.core.rotation import Array, quat_identity, quat_multiply, quat_slerp
from kinestitch.files.fbx.animation import LOCAL, Layer, Take
from kinestitch.files.fbx.curves import Ticks, sample
from kinestitch.files.fbx.scene import Model
from kinestitch.files.fbx.transform import euler_quat, quat_degrees, rotation_order

_ADDITIVE, _OVERRIDE = 0, 1


def property_values(take: Take | None, model: Model, name: str, ticks: Ticks) -> Array:
    """Values (N, 3) of one of the model's three local properties, degrees for rotation.

    The first layer that names the property replaces the default; later ones add to it or replace it by their weight.
    """
    value = np.broadcast_to(model.vector(name, 1.0 if name == LOCAL[2] else 0.0), (len(ticks), 3))
    for index, layer in enumerate(take.layers if take is not None else ()):
        track = layer.tracks.get((model.key, name))
        if track is None or _number(layer, "Mute", 0):
            continue
        shown = track.sample(ticks)
        value = shown if index == 0 else _blend((value, shown), layer, model, name, _weight(layer, ticks))
    return value


def _blend(values: tuple[Array, Array], layer: Layer, model: Model, name: str, weight: Array) -> Array:
    """What lies below and one layer over it, as one; weight (N, 1)."""
    below, above = values
    mode = _number(layer, "BlendMode", 0)
    additive = mode == _ADDITIVE
    if mode == _OVERRIDE or (not additive and (weight >= 0.99999).all()):
        return above
    if name == LOCAL[2] and not _number(layer, "ScaleAccumulationMode", 0):
        scaled = np.abs(above) ** weight * np.where(above < 0, -1.0, 1.0)
        return below * scaled if additive else np.abs(below) ** (1 - weight) * np.sign(below) * scaled
    if name == LOCAL[1] and not _number(layer, "RotationAccumulationMode", 0):
        order = rotation_order(model)
        first, second = euler_quat(below, order), euler_quat(above, order)
        if additive:
            mixed = quat_multiply(first, quat_slerp(quat_identity(), second, weight[:, 0]))
        else:
            mixed = quat_slerp(first, second, weight[:, 0])
        return quat_degrees(mixed, order)
    return below + above * weight if additive else below * (1 - weight) + above * weight


def _weight(layer: Layer, ticks: Ticks) -> Array:
    if layer.weight is not None:
        return np.clip(sample(layer.weight, ticks) / 100, 0, 1)[:, None]
    return np.full((len(ticks), 1), np.clip(_number(layer, "Weight", 100.0) / 100, 0, 1))


def _number(layer: Layer, name: str, default: float) -> float:
    value = next(iter(layer.properties.get(name, ())), default)
    return float(value) if isinstance(value, int | float) and np.isfinite(value) else default
