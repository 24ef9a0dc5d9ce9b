"""UsdSkel animations: the frames of one, and where every joint stands on each."""

from __future__ import annotations

from typing import Any

import numpy as np

from kinestitch.core.rotation import Array, quat_normalize, quat_to_matrix
from kinestitch.errors import FormatError
from kinestitch.files.extras import optional
from kinestitch.files.gltf_scene import World, below, proper_rotations
from kinestitch.files.rates import snap_rate
from kinestitch.files.usd_rig import Rig, Take, placed, world_of

_MOST_JOINT_FRAMES = 8_000_000
_SLOWEST, _FASTEST = 8.0, 240.0
_FINEST = 8


def frame_times(stage: Any, rig: Rig, take: Take | None) -> tuple[Array, float]:
    """Time codes (F,) of the frames, and frames a second; see :func:`kinestitch.files.usd.read_usd`."""
    codes = float(stage.GetTimeCodesPerSecond())
    if not (np.isfinite(codes) and 1e-3 <= codes <= 1e6):
        raise FormatError(f"Expected timeCodesPerSecond between 1e-3 and 1e6, got {codes}.")
    samples = np.unique(np.array(_samples(rig, take), dtype=np.float64))
    if not np.isfinite(samples).all():
        raise FormatError("Expected finite times of samples, got others.")
    slow = codes if codes <= _FASTEST else float(stage.GetFramesPerSecond())
    slow = slow if _SLOWEST <= slow <= _FASTEST else 24.0
    if len(samples) < 2:
        return (samples if len(samples) else np.zeros(1)), snap_rate(slow)
    gaps = np.diff(samples)
    step, rate = codes / slow, slow
    own = codes / float(gaps.mean())
    regular = np.ptp(gaps) < 1e-3 * gaps.mean() and _SLOWEST <= own <= 1000.0
    if regular and (own > slow or codes > _FASTEST):
        step, rate = codes / own, own
    else:
        finer = next((k for k in range(1, _FINEST + 1) if _on_grid(samples, step / k)), 1)
        step, rate = step / finer, rate * finer
    most = _MOST_JOINT_FRAMES // len(rig.names)
    count = np.floor((samples[-1] - samples[0]) / step + 1e-3) + 1
    if count > most:
        raise FormatError(f"Expected up to {most} frames, got {count:.0f}.")
    before, after = _held(stage, rig, samples, step)
    if count + before + after > most:
        before = after = 0
    return samples[0] + step * np.arange(-before, int(count) + after), snap_rate(rate)


def _held(stage: Any, rig: Rig, samples: Array, step: float) -> tuple[int, int]:
    """Frames before the first sample and after the last one: writers leave out values that do not change.

    Only the stage tells of them, which speaks for one animation, not for several.
    """
    if not stage.HasAuthoredTimeCodeRange() or len(rig.takes) > 1:
        return 0, 0
    before = (samples[0] - float(stage.GetStartTimeCode())) / step
    after = (float(stage.GetEndTimeCode()) - samples[-1]) / step
    return _whole(before), _whole(after)


def _whole(count: float) -> int:
    return int(min(np.floor(count + 1e-3), _MOST_JOINT_FRAMES)) if np.isfinite(count) and count > 0 else 0


def _on_grid(samples: Array, step: float) -> bool:
    steps = (samples - samples[0]) / step
    return bool(np.abs(steps - np.round(steps)).max() < 1e-3)


def _samples(rig: Rig, take: Take | None) -> list[float]:
    """All times at which the animation, or a transform above the skeleton, has a value of its own."""
    geom = optional("pxr.UsdGeom", "usd")
    times: list[float] = []
    if take is not None:
        for attribute in _attributes(take):
            times += attribute.GetTimeSamples()
    prim = rig.prim
    while prim and not prim.IsPseudoRoot():
        if prim.IsA(geom.Xformable):
            times += geom.Xformable(prim).GetTimeSamples()
        prim = prim.GetParent()
    return times


def _attributes(take: Take) -> tuple[Any, Any, Any]:
    animation = take.animation
    return animation.GetTranslationsAttr(), animation.GetRotationsAttr(), animation.GetScalesAttr()


def joint_worlds(rig: Rig, take: Take | None, times: Array, frame: World) -> tuple[Array, Array]:
    """World positions (F, J, 3) m and rotations (F, J, 4) of the joints at the time codes (F,)."""
    geom = optional("pxr.UsdGeom", "usd")
    above = below(frame, world_of(np.array([placed(geom, rig.prim, time) for time in times.tolist()])))
    tracks = _tracks(take, times) if take is not None else {}
    positions = np.empty((len(times), len(rig.names), 3))
    rotations = np.empty((len(times), len(rig.names), 4))
    worlds: list[World] = []
    for joint, parent in enumerate(rig.parents):
        local = (
            _local(rig.rest[joint], take.joints.index(rig.paths[joint]), tracks)
            if take is not None and (rig.paths[joint] in take.joints)
            else world_of(rig.rest[joint][None])
        )
        world = below(worlds[parent] if parent >= 0 else above, local)
        if not (np.isfinite(world.linear).all() and np.isfinite(world.position).all()):
            raise FormatError(f"Expected finite transforms above joint {rig.names[joint]!r}, got an overflow.")
        worlds.append(world)
        positions[:, joint] = world.position
        rotations[:, joint] = proper_rotations(world.linear, world.turn)
    return positions, rotations


def _local(rest: Array, column: int, tracks: dict[str, Array]) -> World:
    """A joint's transform in its parent's frame; what the animation leaves out is the rest pose's."""
    still = world_of(rest[None])
    position = tracks["translation"][:, column] if "translation" in tracks else still.position
    turn = tracks["rotation"][:, column] if "rotation" in tracks else still.turn
    scale = tracks["scale"][:, column] if "scale" in tracks else np.linalg.norm(rest[None, :3, :3], axis=1)
    return World(quat_to_matrix(turn) * scale[:, None, :], position, turn)


def _tracks(take: Take, times: Array) -> dict[str, Array]:
    """Values (F or 1, n, 3 or 4) of the animation at the time codes, for each of its attributes that has any."""
    tracks = {}
    for attribute, name, width in zip(_attributes(take), ("translation", "rotation", "scale"), (3, 4, 3), strict=True):
        moving = attribute.ValueMightBeTimeVarying()
        values = [attribute.Get(time) for time in (times if moving else times[:1]).tolist()]
        try:
            if values[0] is None or not len(values[0]):
                continue
            track = np.array([np.array(value, dtype=np.float64) for value in values])
        except (TypeError, ValueError) as error:
            raise FormatError(f"Expected as many {name}s on every frame of {take.name!r}, got others.") from error
        if track.shape[1:] != (len(take.joints), width):
            raise FormatError(
                f"Expected {len(take.joints)} {name}s of {width} numbers in {take.name!r}, got {track.shape[1:]}."
            )
        if not (np.abs(track) < 1e9).all():
            raise FormatError(f"Expected finite {name}s in {take.name!r}, got others.")
        tracks[name] = quat_normalize(track) if width == 4 else track
    return tracks
