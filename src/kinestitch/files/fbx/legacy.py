"""FBX 5 and 6: takes that name their models, keys told one by one, and (5) models that list their children."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from kinestitch.errors import FormatError
from kinestitch.files.fbx.animation import LOCAL, Layer, Take, Target, Track
from kinestitch.files.fbx.curves import Curve, make_curve
from kinestitch.files.fbx.extrapolation import read_beyond
from kinestitch.files.fbx.nodes import Node, Property
from kinestitch.files.fbx.scene import Scene

_CONSTANT, _CONSTANT_NEXT, _LINEAR, _CUBIC, _AUTO = 0x2, 0x102, 0x4, 0x408, 0x6108
_THIRD = 1 / 3
# how many numbers follow the letter that says how a cubic key's slopes are told
_SLOPES = {"s": 2, "b": 2, "a": 0, "p": 2, "t": 3}
_WEIGHTS = {"n": 0, "a": 2, "l": 1, "r": 1, "c": 0}


def read_old_takes(scene: Scene) -> tuple[Take, ...]:
    """All takes of a file before 7.0, in file order."""
    home = scene.document.child("Takes")
    return tuple(_take(scene, node) for node in home.all("Take")) if home is not None else ()


def _take(scene: Scene, node: Node) -> Take:
    tracks: dict[Target, Track] = {}
    for entry in node.all("Model"):
        key = entry.text()
        for transform in entry.all("Channel") if key in scene.models else ():
            if transform.text() == "Transform":
                for channel in transform.all("Channel"):
                    name = {"T": LOCAL[0], "R": LOCAL[1], "S": LOCAL[2]}.get(channel.text())
                    if name is not None:
                        usual = scene.models[key].vector(name, 1.0 if name == LOCAL[2] else 0.0)
                        tracks[key, name] = _track(channel, usual)
    return Take(node.text(), (Layer("", tracks),))


def _track(channel: Node, usual: np.ndarray) -> Track:
    axes = {part.text(): part for part in channel.all("Channel")}
    curves: list[Curve | None] = [None, None, None]
    constants = usual.copy()
    for i, letter in enumerate("XYZ"):
        part = axes.get(letter)
        if part is None:
            continue
        curves[i] = read_old_curve(part)
        default = part.child("Default")
        if default is not None and np.isfinite(default.number()):
            constants[i] = default.number()
    return Track((curves[0], curves[1], curves[2]), constants)


def read_old_curve(channel: Node) -> Curve | None:
    """The keys of a channel: time, value, a letter for the interpolation, and what that letter asks for."""
    node = channel.child("Key")
    if node is None:
        return None
    count = channel.child("KeyCount")
    expected = count.integer() if count is not None else -1
    rows = list(_keys(node.properties))
    if expected >= 0 and len(rows) != expected:
        raise FormatError(f"Expected {expected} keys, got {len(rows)}. The file is damaged; export it again.")
    times = np.array([row[0] for row in rows], dtype=np.int64)
    values, flags, slopes, weights = ([row[i] for row in rows] for i in range(1, 5))
    curve = make_curve(
        times,
        np.array(values, dtype=np.float64),
        np.array(flags, dtype=np.int64),
        np.array(slopes, dtype=np.float64).reshape(-1, 3),
        np.array(weights, dtype=np.float64).reshape(-1, 2),
    )
    return None if curve is None else replace(curve, beyond=read_beyond(channel))


_Row = tuple[int, float, int, tuple[float, float, float], tuple[float, float]]


def _keys(values: tuple[Property, ...]) -> Iterator[_Row]:
    queue = _Queue(values)
    while queue.at < len(values):
        time, value = queue.number(), queue.number()
        mode = queue.letter()
        flags, slopes, weights = _LINEAR, (0.0, 0.0, 0.0), (_THIRD, _THIRD)
        if mode == "C":
            flags = _CONSTANT_NEXT if queue.letter() == "n" else _CONSTANT
        elif mode == "U":
            flags, slopes, weights = _cubic(queue)
        elif mode != "L":
            raise FormatError(
                f"Expected an interpolation out of C, L, U in a key, got {mode!r}. Export the file again."
            )
        yield int(time) if abs(time) < 2**62 else 0, value, flags, slopes, weights


def _cubic(queue: _Queue) -> tuple[int, tuple[float, float, float], tuple[float, float]]:
    kind = queue.letter()
    if kind not in _SLOPES:
        raise FormatError(
            f"Expected a kind of tangent out of {', '.join(_SLOPES)}, got {kind!r}. Export the file again."
        )
    given = [queue.number() for _ in range(_SLOPES[kind])]
    weight = queue.letter()
    if weight not in _WEIGHTS:
        raise FormatError(
            f"Expected a kind of weight out of {', '.join(_WEIGHTS)}, got {weight!r}. Export the file again."
        )
    shares = [queue.number() for _ in range(_WEIGHTS[weight])]
    leave, arrive = _THIRD, _THIRD
    if weight == "a":
        leave, arrive = shares
    elif weight == "l":
        arrive = shares[0]
    elif weight == "r":
        leave = shares[0]
    if kind in "sb":
        return _CUBIC, (given[0], given[1], 0.0), (leave, arrive)
    return _AUTO, (0.0, 0.0, 0.0), (leave, arrive)


class _Queue:
    """The loose values of a Key node, taken off one by one."""

    def __init__(self, values: tuple[Property, ...]) -> None:
        self.values = values
        self.at = 0

    def _next(self) -> Property:
        if self.at >= len(self.values):
            raise FormatError("Expected a whole key, got the end of the curve. The file is damaged; export it again.")
        self.at += 1
        return self.values[self.at - 1]

    def number(self) -> float | int:
        value = self._next()
        if isinstance(value, int | float):
            return value
        raise FormatError(f"Expected a number in a key, got {str(value)[:20]!r}. The file is damaged; export it again.")

    def letter(self) -> str:
        value = self._next()
        if isinstance(value, int | float) and 0 < value < 128:
            return chr(int(value))
        return value if isinstance(value, str) else "?"
