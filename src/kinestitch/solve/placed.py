"""A timeline made ready to solve: its clips on one rig and at one rate, and every segment placed on the ground.

Nothing here is as long as the result: a placed timeline answers for any window of frames, so that the cost of an edit
does not depend on the length of the clip.
"""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.resample import resample, same_rate
from kinestitch.core.retime import retime
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, Timeline
from kinestitch.errors import MissingClipError, RangeError
from kinestitch.rig.carrier import carrier_joint, with_world_carrier
from kinestitch.rig.fit import fit_motion
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.root import Placement, continue_placement
from kinestitch.solve.seam import SeamPlace, stiffness_at


@dataclass(frozen=True, eq=False, slots=True)
class Straddling:
    """Both sources around a seam at m, placed: the left source's own frames and the right source's own.

    rotations : (4, J, 4) of a(m−1), a(m), b(m−1), b(m); translations : (4, J, 3) m of the same
    left_path, right_path : (4, 3) m, the carrier's positions at each source's own frames m−2, m−1, m, m+1
    """

    rotations: Array
    translations: Array
    left_path: Array
    right_path: Array


@dataclass(frozen=True, slots=True)
class JointGroup:
    """Joints that are solved with a λ of their own at each seam. stiffness : one for each of ``Placed.seams``"""

    name: str
    joints: tuple[int, ...]
    stiffness: tuple[float, ...]


@dataclass(frozen=True, eq=False, slots=True)
class Placed:
    """A timeline with its sources on one skeleton and at one rate; made by :func:`place_timeline` only.

    carrier : the lowest joint that carries the travel in one of the clips; everything above it is folded into it
    writes : the joint that carried it in the original, to which the result's travel is given back
    sources : per clip key a motion whose `carrier` joint is told in the world
    placements : (S,) one per segment; seams : the places where something has to be solved
    groups : every joint once, where they do not all take a seam's λ; a seam then has the largest of its groups'
    """

    timeline: Timeline
    skeleton: Skeleton
    carrier: int
    writes: int
    sources: Mapping[str, Motion]
    placements: tuple[Placement, ...]
    seams: tuple[SeamPlace, ...]
    starts: tuple[int, ...]
    groups: tuple[JointGroup, ...] = ()

    @property
    def frames(self) -> int:
        """Number of frames of the result."""
        return self.starts[-1]

    @property
    def firm(self) -> tuple[int, ...]:
        """The frames from which on the body is back on its own clip's path, so that no seam before them reaches on."""
        return tuple(pin.frame for pin in self.timeline.pins if pin.kind == "return")


def place_timeline(timeline: Timeline, clips: Mapping[str, Motion]) -> Placed:
    """Match rigs, resample, and give each segment the yaw and ground shift by which it continues its predecessor
    (Eq. 14).

    A clip of another rig is retargeted where its joints' names leave no doubt, and a KinestitchWarning says so. The
    motion of a retimed clip is made from its source's, which is the one that has to be among the clips.

    Raises MissingClipError, RangeError (a clip shorter than the timeline says), SkeletonMismatchError.
    """
    pasted = [segment.clip for segment in timeline.segments]
    lead = timeline.original
    first = next(key for key in pasted if timeline.clip(key).source == lead)
    used = dict.fromkeys([first, *pasted])  # the original leads: what stands above its carrier is taken from it
    for key in dict.fromkeys(timeline.clip(key).source for key in used):
        _check_clip(timeline.clip(key), clips)
    original = clips[lead]
    chain = original.skeleton.chain(hips_joint(original.skeleton))
    matched = {key: _matched(timeline, timeline.clip(key), clips, original) for key in used}
    writes = carrier_joint(original)
    others = [motion for motion in matched.values() if motion is not original]
    carrier = max([writes, *map(carrier_joint, others)], key=chain.index)
    sources = {key: with_world_carrier(motion, carrier) for key, motion in matched.items()}
    starts = timeline.starts
    placed = Placed(
        timeline, original.skeleton, carrier, writes, sources, (Placement(),), _places(timeline, starts), starts
    )
    placements = [Placement()]
    for seam in range(len(timeline.segments) - 1):
        if _continuous(timeline, seam):
            placements.append(placements[-1])
        else:
            around = _own_frames(placed, seam)
            placements.append(continue_placement(original.skeleton, carrier, placements[-1], around))
    return replace(placed, placements=tuple(placements))


def _check_clip(info: ClipInfo, clips: Mapping[str, Motion]) -> None:
    key = info.key
    if key not in clips:
        known = ", ".join(map(repr, clips)) or "none"
        raise MissingClipError(f"Expected a motion for clip {key!r}, got {known}. Pass it in `clips`.")
    if not same_rate(info.fps, clips[key].fps):
        raise RangeError(f"Expected {info.fps:g} fps in clip {key!r}, as its timeline says, got {clips[key].fps:g}.")
    if info.frames != clips[key].frames:
        raise RangeError(
            f"Expected {info.frames} frames in clip {key!r}, as its timeline says, got {clips[key].frames}."
        )


def _matched(timeline: Timeline, info: ClipInfo, clips: Mapping[str, Motion], original: Motion) -> Motion:
    """A clip on the original's rig and at the timeline's rate, retimed if it is a retimed one."""
    fitted = fit_motion(clips[info.source], original, info.source)
    if info.retiming is None:
        return resample(fitted, timeline.fps)
    return retime(fitted, info.retiming.knots, info.frames_at(timeline.fps), timeline.fps)


def _continuous(timeline: Timeline, seam: int) -> bool:
    """Whether the segments around a seam are adjacent frames of one clip, so that nothing has to be solved."""
    left, right = timeline.segments[seam], timeline.segments[seam + 1]
    return left.clip == right.clip and left.range.stop == right.range.start


def _places(timeline: Timeline, starts: tuple[int, ...]) -> tuple[SeamPlace, ...]:
    places = []
    for index, seam in enumerate(timeline.seams):
        if not _continuous(timeline, index):
            places.append(SeamPlace(index, starts[index + 1], stiffness_at(seam, timeline.fps)))
    return tuple(places)


def _extended(values: Array, frame: int, *, rotation: bool) -> Array:
    """A clip's frame, or the one beyond its ends at constant velocity (on the group, for rotations)."""
    last = len(values) - 1
    if 0 <= frame <= last:
        return values[frame]
    edge, inner = (0, min(1, last)) if frame < 0 else (last, max(last - 1, 0))
    steps = -frame if frame < 0 else frame - last
    out = values[edge]
    for _ in range(steps):
        if rotation:
            out, inner_value = (
                quat_multiply(quat_multiply(out, quat_conjugate(values[inner])), values[edge]),
                values[edge],
            )
            if steps > 1:
                values, edge, inner = np.stack([inner_value, out]), 1, 0
        else:
            out = out + (values[edge] - values[inner])
    return np.asarray(out)


def _own_frames(placed: Placed, seam: int, reach: int = 1) -> tuple[Array, Array]:
    """Unplaced rotations (4 · reach, J, 4) and translations (4 · reach, J, 3) of a(m − reach) … a(m + reach − 1), then
    b's of the same frames, at a seam of the timeline.
    """
    left, right = placed.timeline.segments[seam], placed.timeline.segments[seam + 1]
    a, b = placed.sources[left.clip], placed.sources[right.clip]
    around = range(-reach, reach)
    frames = [(a, left.range.stop + k) for k in around] + [(b, right.range.start + k) for k in around]
    rotations = np.stack([_extended(clip.rotations, frame, rotation=True) for clip, frame in frames])
    translations = np.stack([_extended(clip.translations, frame, rotation=False) for clip, frame in frames])
    return rotations, translations


def beside(placed: Placed, place: SeamPlace, reach: int = 1) -> tuple[Array, Array]:
    """Both sources on their own on `reach` frames each side of a seam, as the result sees them, carrier in the world:
    rotations (4 · reach, J, 4) and translations (4 · reach, J, 3) m of a(m − reach) … a(m + reach − 1), then b's.

    Beyond the ends of its clip a source goes on at constant velocity.
    """
    rotations, translations = _own_frames(placed, place.index, reach)
    joint, rows = placed.carrier, (slice(0, 2 * reach), slice(2 * reach, None))
    for here, placement in zip(rows, placed.placements[place.index : place.index + 2], strict=True):
        rotations[here, joint] = quat_multiply(placement.rotation, rotations[here, joint])
        translations[here, joint] = placement.move(translations[here, joint])
    return rotations, translations


def straddling(placed: Placed, place: SeamPlace) -> Straddling:
    """Both sources around a seam, as the result sees them."""
    seam = place.index
    rotations, translations = beside(placed, place)
    left, right = placed.timeline.segments[seam], placed.timeline.segments[seam + 1]
    before, after = placed.placements[seam], placed.placements[seam + 1]
    a = placed.sources[left.clip].translations[:, placed.carrier]
    b = placed.sources[right.clip].translations[:, placed.carrier]
    own = range(-2, 2)
    left_path = np.stack([_extended(a, left.range.stop + k, rotation=False) for k in own])
    right_path = np.stack([_extended(b, right.range.start + k, rotation=False) for k in own])
    return Straddling(rotations, translations, before.move(left_path), after.move(right_path))


def target_window(placed: Placed, start: int, stop: int) -> tuple[Array, Array]:
    """Rotations (n, J, 4) and translations (n, J, 3) of the hard cut on frames [start, stop), placed, carrier in the
    world.
    """
    joints = placed.skeleton.joint_count
    rotations = np.empty((stop - start, joints, 4))
    translations = np.empty((stop - start, joints, 3))
    index = bisect_right(placed.starts, start) - 1
    while index < len(placed.placements) and placed.starts[index] < stop:
        first = max(start, placed.starts[index])
        last = min(stop, placed.starts[index + 1])
        segment, placement = placed.timeline.segments[index], placed.placements[index]
        source = placed.sources[segment.clip]
        shift = segment.range.start - placed.starts[index]
        here, there = slice(first - start, last - start), slice(first + shift, last + shift)
        rotations[here] = source.rotations[there]
        translations[here] = source.translations[there]
        if placement != Placement():
            joint = placed.carrier
            rotations[here, joint] = quat_multiply(placement.rotation, rotations[here, joint])
            translations[here, joint] = placement.move(translations[here, joint])
        index += 1
    return rotations, translations


def frame_above(placed: Placed) -> tuple[Array, Array]:
    """World position (3,) and rotation (4,) of the frame the carrier hangs in; the same in every frame of the
    result.
    """
    first = placed.sources[next(iter(placed.sources))]
    position, rotation = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    for joint in placed.skeleton.chain(placed.carrier)[:-1]:
        position = position + quat_rotate(rotation, first.translations[0, joint])
        rotation = quat_multiply(rotation, first.rotations[0, joint])
    return position, rotation
