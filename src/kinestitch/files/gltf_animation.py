"""glTF animations: which one, at which rate, and the value of each animated channel at any time."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from kinestitch.core.rotation import Array, quat_normalize, quat_slerp
from kinestitch.errors import FormatError, ParameterError
from kinestitch.files.gltf_document import GltfDocument, Json, child, objects, text, whole
from kinestitch.files.rates import snap_rate

PATHS = {"translation": "VEC3", "rotation": "VEC4", "scale": "VEC3"}
_ON_KEY = 1e-3
"""Share of a frame within which a time is a key's own."""
_ON_GRID = 0.02
MARK = ("kinestitch", "newest")
"""Extra of the animation that was written last into a file with several: it is the one to read."""
_GUESSES = (24.0, 25.0, 30.0, 48.0, 50.0, 60.0, 90.0, 100.0, 120.0)


def _coarseness(time: float) -> float:
    """Distance of neighbouring float32 numbers at `time`: no key time is truer."""
    return float(np.spacing(np.float32(abs(time))))


@dataclass(frozen=True, slots=True)
class Track:
    """The keys of one channel: times (K,) s; values (K, n), or (K, 3, n) with tangents for CUBICSPLINE."""

    times: Array
    values: Array
    interpolation: str

    def at(self, times: Array, frame: float) -> Array:
        """Values (N, n) at `times` (N,) s; before the first and after the last key that key's own.

        frame : seconds of a frame; a time that float32 cannot tell from a key's, or nearer to it than a thousandth of
            a frame, is the key's
        """
        right = np.clip(np.searchsorted(self.times, times, side="right"), 1, max(len(self.times) - 1, 1))
        left = right - 1
        right = np.minimum(right, len(self.times) - 1)
        span = self.times[right] - self.times[left]
        inside = times - self.times[left]
        share = np.clip(inside / np.where(span > 0, span, 1.0), 0.0, 1.0)
        near = min(_ON_KEY * frame + _coarseness(self.times[-1]), 0.3 * frame)
        share = np.where(np.abs(inside) < near, 0.0, share)
        share = np.where(np.abs(inside - span) < near, np.where(span > 0, 1.0, 0.0), share)
        if self.interpolation == "CUBICSPLINE":
            return self._cubic(left, right, share, span)
        if self.interpolation == "STEP":
            return self.values[np.where(share == 1, right, left)]
        if self.values.shape[-1] == 4:
            between = quat_slerp(self.values[left], self.values[right], share)
            between[share == 0] = self.values[left[share == 0]]
            between[share == 1] = self.values[right[share == 1]]
            return between
        weight = share[:, None]
        return self.values[left] * (1 - weight) + self.values[right] * weight

    def _cubic(self, left: np.ndarray, right: np.ndarray, share: Array, span: Array) -> Array:
        s, t = share[:, None], span[:, None]
        start, stop = self.values[left, 1], self.values[right, 1]
        leave, arrive = t * self.values[left, 2], t * self.values[right, 0]
        value = (2 * s**3 - 3 * s**2 + 1) * start + (s**3 - 2 * s**2 + s) * leave
        value += (3 * s**2 - 2 * s**3) * stop + (s**3 - s**2) * arrive
        return quat_normalize(value) if value.shape[-1] == 4 else value


@dataclass(frozen=True, slots=True)
class Take:
    """One animation: its name, its tracks by (node, path), the rate its writer noted, if any, its place in the file."""

    name: str
    tracks: dict[tuple[int, str], Track]
    noted_fps: float | None = None
    index: int = 0


def targets(document: GltfDocument, animation: Json) -> list[tuple[int, str, int]]:
    """Node, path and sampler of each channel that moves a node."""
    samplers = objects(animation, "samplers")
    nodes = document.objects("nodes")
    result = []
    for channel in objects(animation, "channels"):
        target = child(channel, "target")
        path = text(target, "path", "")
        if path in PATHS and "node" in target:
            node = whole(target, "node", below=len(nodes))
            result.append((node, path, whole(channel, "sampler", below=len(samplers))))
    return result


def animation_name(animation: Json, index: int) -> str:
    """The animation's name, or its number where it has none."""
    return text(animation, "name", f"animation {index}")


def choose_take(document: GltfDocument, name: str | None, nodes: Collection[int] | None) -> Take | None:
    """The animation called `name`; without a name the one that kinestitch wrote last into the file, else the one with
    the most channels on `nodes`, the longest of several.

    nodes : the nodes that count, None for all. Returns None if no animation moves any of them and no name was given;
    raises ParameterError for an unknown name.
    """
    animations = document.objects("animations")
    moving = []
    for index, animation in enumerate(animations):
        channels = [t for t in targets(document, animation) if nodes is None or t[0] in nodes]
        moving.append((animation_name(animation, index), animation, channels))
    if name is not None:
        chosen = [entry for entry in moving if entry[0] == name]
        if not chosen:
            known = ", ".join(repr(entry[0]) for entry in moving[:12]) or "none"
            raise ParameterError(f"Expected the name of an animation ({known}), got {name!r}.")
    else:
        most = max((len(channels) for _, _, channels in moving), default=0)
        newest = [entry for entry in moving if entry[2] and _extras(entry[1]).get(MARK[0]) == MARK[1]]
        chosen = newest or [entry for entry in moving if len(entry[2]) == most > 0]
    times: dict[int, Array] = {}
    longest = max(chosen, key=lambda entry: _duration(document, entry[1], entry[2], times), default=None)
    return None if longest is None else _load(document, *longest, times)


def _duration(
    document: GltfDocument, animation: Json, channels: list[tuple[int, str, int]], times: dict[int, Array]
) -> float:
    samplers = objects(animation, "samplers")
    return max((float(_times_of(document, samplers[s], times)[-1]) for _, _, s in channels), default=0.0)


def _load(
    document: GltfDocument,
    name: str,
    animation: Json,
    channels: list[tuple[int, str, int]],
    times: dict[int, Array],
) -> Take:
    samplers = objects(animation, "samplers")
    tracks = {(node, path): _track(document, samplers[s], path, times) for node, path, s in channels}
    noted = _extras(animation).get("fps")
    good = isinstance(noted, int | float) and not isinstance(noted, bool) and 1e-3 < noted < 1e4
    index = next(i for i, entry in enumerate(document.objects("animations")) if entry is animation)
    return Take(name, tracks, float(noted) if good and noted is not None else None, index)


def _extras(animation: Json) -> Json:
    extras = animation.get("extras")
    return extras if isinstance(extras, dict) else {}


def _track(document: GltfDocument, sampler: Json, path: str, times: dict[int, Array]) -> Track:
    accessors = len(document.objects("accessors"))
    keys = _times_of(document, sampler, times)
    interpolation = text(sampler, "interpolation", "LINEAR")
    if interpolation not in ("LINEAR", "STEP", "CUBICSPLINE"):
        raise FormatError(f"Expected interpolation LINEAR, STEP or CUBICSPLINE, got {interpolation[:20]!r}.")
    values = document.accessor(whole(sampler, "output", below=accessors), PATHS[path])
    each = 3 if interpolation == "CUBICSPLINE" else 1
    if len(values) != each * len(keys):
        raise FormatError(f"Expected {each * len(keys)} values for {len(keys)} keys, got {len(values)}.")
    if each == 3:
        return Track(keys, values.reshape(len(keys), 3, -1), interpolation)
    return Track(keys, quat_normalize(values) if path == "rotation" else values, interpolation)


def _times_of(document: GltfDocument, sampler: Json, times: dict[int, Array]) -> Array:
    index = whole(sampler, "input", below=len(document.objects("accessors")))
    if index not in times:
        keys = document.accessor(index, "SCALAR")[:, 0]
        if len(keys) == 0 or (np.diff(keys) < 0).any():
            raise FormatError(f"Expected key times that grow, got {len(keys)} that do not (accessor {index}).")
        times[index] = keys
    return times[index]


def frame_times(take: Take | None, joints: int) -> tuple[Array, float]:
    """Times (F,) s of the frames from the first key to the last, and their rate.

    Keys on a regular grid are the frames, whatever their rate. Otherwise the slowest usual rate on whose grid all keys
    lie; failing that, the usual rate that the smallest distance of two keys asks for, from 30 to 120. Splines
    and steps slower than 24 a second are sampled at the multiple of their rate that reaches it.

    Raises FormatError if the keys are so far apart that the frames between them would be out of all proportion.
    """
    tracks = [] if take is None else list(take.tracks.values())
    fallback = 30.0 if take is None or take.noted_fps is None else take.noted_fps
    if not tracks:
        return np.zeros(1), fallback
    unique = {id(track.times): track.times for track in tracks}
    keys = np.unique(np.concatenate(list(unique.values())))
    start, length = keys[0], keys[-1] - keys[0]
    if length <= 1e-4:
        return np.array([start]), fallback
    fps = _rate(keys - start, any(track.interpolation != "LINEAR" for track in tracks))
    if take is not None and take.noted_fps is not None and abs(take.noted_fps / fps - 1) < 1e-4:
        fps = take.noted_fps
    frames = int(min(length * fps + _ON_GRID, 2.0**40)) + 1
    if frames * joints > 10 * len(keys) * joints + 5_000_000:
        raise FormatError(f"Expected keys that follow each other, got {len(keys)} keys over {length:g} s.")
    return start + np.arange(frames) / fps, fps


def _rate(keys: Array, curved: bool) -> float:
    steps = np.diff(keys)
    smallest = float(steps[steps > 1e-4].min(initial=keys[-1]))
    regular = (len(keys) - 1) / keys[-1], round(keys[-1] / smallest) / keys[-1]
    fps = next((rate for rate in regular if rate <= 1000 and _fits(keys, rate, apart=True)), 0.0)
    if fps > 0:
        fps = snap_rate(fps) if _fits(keys, snap_rate(fps)) else fps
    else:
        usual = next((rate for rate in _GUESSES if rate >= max(30.0, 0.999 / smallest)), _GUESSES[-1])
        fps = next((rate for rate in _GUESSES if _fits(keys, rate)), usual)
    return fps * max(1, int(np.ceil(24.0 / fps - 1e-9))) if curved else fps


def _fits(keys: Array, fps: float, *, apart: bool = False) -> bool:
    """Whether all keys lie on the grid of a rate; `apart`: no two on one place."""
    place = keys * fps
    if apart and not np.diff(np.rint(place)).all():
        return False
    return bool((np.abs(place - np.rint(place)) < _ON_GRID + 2 * fps * _coarseness(keys[-1])).all())
