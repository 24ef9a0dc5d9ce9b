"""A clip as one cycle: its last frames go over into its first ones, and the next cycle starts where this one has ended.

    minimise  ‖c‖² + λ ‖L c − e‖² ,  L periodic                                                        (Eq. 20)

Where the body is on the ground and where it looks is no part of the loop condition: a cycle travels and turns, and the
next one is placed by that. Rotations are told in a frame that turns along evenly (Eq. 21); the ground path is solved
on its displacements, height and other translations as positions.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_about_axis, quat_conjugate, quat_multiply, quat_normalize
from kinestitch.edit.timeline import FrameRange, Seam
from kinestitch.errors import ParameterError, RangeError
from kinestitch.rig.carrier import carrier_joint, with_local_carrier, with_world_carrier, world_of
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.chart import Charted, centred_chart, mid_tangent, solve_rotations
from kinestitch.solve.contacts import Contacts
from kinestitch.solve.periodic import loop_curves, loop_interval_curves
from kinestitch.solve.root import GROUND, Placement, chain_rotation, residual_rows
from kinestitch.solve.seam import Cluster, SeamPlace, stiffness_at
from kinestitch.solve.weld import Welded, turned, weld

SHORTEST = 3
"""Frames that a clip must have to be looped."""

_NEAR = 0.05  # m; hips that end no further from where they began against a joint above them do not travel by themselves
_SHEET = 1e-9  # of a gap; where less is left of the curves, it does not matter on which sheet a joint is


@dataclass(frozen=True, eq=False, slots=True)
class Looped:
    """A cycle; made by :func:`solve_loop` only.

    motion : N + 1 frames, the last of which shows the first one's pose again, one cycle on
    cut : the same before it was solved, N + 1 frames
    span : the N frames of the clip that the cycle is made of
    carrier : the joint that carries the travel; stiffness : λ
    contacts : where feet were locked, the contacts that the cycle keeps
    """

    motion: Motion
    cut: Motion
    span: FrameRange
    carrier: int
    stiffness: float
    contacts: Contacts | None = None


def loop(
    motion: Motion,
    start: int = 0,
    stop: int | None = None,
    *,
    stiffness: float | None = None,
    smoothing: float | None = None,
    closed: bool = True,
) -> Motion:
    """The frames start:stop as a cycle that can follow itself for ever; its travel and its turn stay.

    |  start … stop  |   →   |  start … stop  |  start … stop  |  start … stop  | …

    start, stop : all frames when left out, but for a last one that shows the first pose again, which is the next
    cycle's; :func:`kinestitch.search.cycle.best_cycle` finds the frames that fit best
    stiffness, smoothing : λ or τ in s, as of any seam
    closed : with one more frame, which repeats the first pose where the next cycle starts

    Raises RangeError for fewer than three frames and ranges outside the clip, ParameterError.

    >>> from kinestitch.samples import sample
    >>> cycle = loop(sample("walk"), 20, 84)
    >>> cycle.frames, repeated(cycle, 3).frames
    (65, 193)
    """
    result = solve_loop(motion, start, stop, stiffness=stiffness, smoothing=smoothing).motion
    return result if closed else opened(result)


def solve_loop(
    motion: Motion,
    start: int = 0,
    stop: int | None = None,
    *,
    stiffness: float | None = None,
    smoothing: float | None = None,
) -> Looped:
    """Like :func:`loop`, with the cycle before it was solved beside the result, for those who measure."""
    span = _span(motion, start, stop)
    value = stiffness_at(Seam(stiffness, smoothing), motion.fps)
    carrier = loop_carrier(_part(motion, slice(span.start, span.stop)))
    told = with_world_carrier(motion, carrier)
    welded = weld(told, span, carrier)
    base = _part(told, slice(span.start, span.stop))
    cut = _closed(base, welded, carrier, base.rotations, base.translations, welded.steps[-1])
    if value == 0.0:
        return Looped(cut, cut, span, carrier, value)
    rotations = _solved_rotations(welded, value)
    _hips_to_local(base, carrier, rotations)
    translations, seam_step = _solved_translations(base, welded, carrier, value)
    return Looped(_closed(base, welded, carrier, rotations, translations, seam_step), cut, span, carrier, value)


def loop_carrier(motion: Motion) -> int:
    """The joint that carries a cycle's travel: the first one from the root down to the hips that moves and gets most of
    the way that the hips get, from first frame to last.
    """
    first, chain = carrier_joint(motion), motion.skeleton.chain(hips_joint(motion.skeleton))
    joints = chain[chain.index(first) :]
    ends = _part(motion, slice(0, None, max(motion.frames - 1, 1)))
    ways = [np.diff(world_of(ends, joint)[0][[0, -1]][:, GROUND], axis=0)[0] for joint in joints]
    bound = max(float(np.linalg.norm(ways[-1])) / 2, _NEAR)
    return next(joint for joint, way in zip(joints, ways, strict=True) if np.linalg.norm(way - ways[-1]) <= bound)


def around_seam(motion: Motion, span: FrameRange) -> Motion:
    """The four frames around a loop's seam, each end where the clip has it: the one before the first, the first, the
    last, the one after the last (Eq. 22). What stands above the joint that carries the travel stands as in frame 0.
    """
    carrier = loop_carrier(_part(motion, slice(span.start, span.stop)))
    told = with_world_carrier(motion, carrier)
    welded = weld(told, span, carrier)
    count = welded.frames
    rows = [0, 1, count, count + 1]
    rotations, translations = welded.rotations[rows], welded.translations[rows]
    _hips_to_local(told, carrier, rotations)
    into, out = turned(welded.ends, welded.yaw * np.array([-0.5, count - 0.5]) / count)
    first, last = (told.translations[frame, carrier][list(GROUND)] for frame in (span.start, span.stop - 1))
    translations[:, carrier, GROUND] = np.stack([first - into, first, last, last + out])
    four = replace(told, rotations=quat_normalize(rotations), translations=translations)
    return with_local_carrier(four, carrier)


def _span(motion: Motion, start: int, stop: int | None) -> FrameRange:
    if motion.frames < SHORTEST:
        raise RangeError(f"Expected a clip of at least {SHORTEST} frames to loop, got {motion.frames}.")
    span = FrameRange(start, motion.frames if stop is None else stop)
    if stop is None and start == 0 and repeats_first_pose(motion):
        return FrameRange(0, motion.frames - 1)
    if span.stop > motion.frames or len(span) < 2:
        raise RangeError(f"Expected a cycle of at least 2 of the clip's {motion.frames} frames, got {span}.")
    return span


def repeats_first_pose(motion: Motion) -> bool:
    """Whether a clip's last frame shows the pose of its first again, wherever the body stands and looks."""
    carrier = loop_carrier(motion)
    return weld(with_world_carrier(motion, carrier), FrameRange(0, motion.frames - 1), carrier).repeats


def _solved_rotations(welded: Welded, stiffness: float) -> Array:
    """The cycle's rotations (N, J, 4), solved; hips in the world.

    The cycle is opened at its middle, so that the seam is one between its second half and its first.
    """
    count, half = welded.frames, welded.frames // 2
    even = quat_about_axis(1, -welded.yaw * np.arange(-1, count + 1) / count)[:, None]
    told, upright = welded.rotations.copy(), list(welded.upright)
    told[:, upright] = quat_multiply(even, told[:, upright])
    poses = told[[count, count + 1, 0, 1]][None]
    target = np.roll(told[1:-1], -half, axis=0)
    cluster = Cluster(0, count, (SeamPlace(0, count - half, stiffness),))
    curves = np.roll(loop_curves(stiffness, count), -half, axis=0)
    charted = centred_chart(target, poses, cluster.local_frames)
    solved = target.copy()
    odd = np.union1d(solve_rotations(charted, cluster, curves, solved), _on_two_sheets(charted, target, curves))
    if len(odd):
        solved[:, odd] = mid_tangent(target[:, odd], poses[:, :, odd], cluster, curves)
    out = np.roll(solved, half, axis=0)
    out[:, upright] = quat_multiply(quat_conjugate(even[1:-1]), out[:, upright])
    return out


def _on_two_sheets(charted: Charted, target: Array, curves: Array) -> NDArray[np.intp]:
    """Joints that turn all the way round in a cycle, so that its halves lie on different sheets where they meet in the
    middle, if the window reaches so far.
    """
    if np.abs(curves[[0, -1]]).max() < _SHEET:
        return np.empty(0, dtype=np.intp)
    agree = np.einsum("ji,ji->j", target[-1], target[0])
    if charted.sign is not None:
        agree = agree * charted.sign[-1] * charted.sign[0]
    return np.flatnonzero(agree < 0)


def _hips_to_local(base: Motion, carrier: int, rotations: Array) -> None:
    chain = base.skeleton.chain(hips_joint(base.skeleton))
    way = chain[chain.index(carrier) :]
    if len(way) > 1:
        above = chain_rotation(way[:-1], rotations)
        rotations[:, way[-1]] = quat_multiply(quat_conjugate(above), rotations[:, way[-1]])


def _solved_translations(base: Motion, welded: Welded, carrier: int, stiffness: float) -> tuple[Array, Array]:
    """The cycle's translations (N, J, 3) m, solved, and its step (2,) over the seam in the frame that turns along.

    The path is held where the cycle is half over, half a cycle from the seam on either side.
    """
    count, beyond = welded.frames, welded.translations
    gaps = np.stack([beyond[0] - beyond[-2], beyond[1] - beyond[-1]])
    out = base.translations + np.einsum("nk,kjc->njc", loop_curves(stiffness, count), gaps)
    change = loop_interval_curves(stiffness, count) @ residual_rows(welded.path_gaps)
    moved = np.zeros((count, 2))
    np.cumsum(turned(change, welded.yaw * (np.arange(count) + 0.5) / count)[:-1], axis=0, out=moved[1:])
    moved -= (moved[(count - 1) // 2] + moved[count // 2]) / 2
    out[:, carrier, GROUND] += moved
    return out, welded.steps[-1] + change[-1]


def _closed(
    base: Motion, welded: Welded, carrier: int, rotations: Array, translations: Array, seam_step: Array
) -> Motion:
    """The cycle with one more frame, the first of the next cycle; the carrier told in its parent's frame again."""
    count = len(rotations)
    turn, place = rotations[:1].copy(), translations[:1].copy()
    turn[:, carrier] = quat_multiply(quat_about_axis(1, welded.yaw), turn[:, carrier])
    step = turned(seam_step[None], np.array([welded.yaw * (count - 0.5) / count]))
    place[:, carrier, GROUND] = translations[-1:, carrier, GROUND] + step
    closed = replace(
        base,
        rotations=quat_normalize(np.concatenate([rotations, turn])),
        translations=np.concatenate([translations, place]),
    )
    return with_local_carrier(closed, carrier)


def _part(motion: Motion, frames: slice) -> Motion:
    return replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])


def opened(cycle: Motion) -> Motion:
    """A cycle without its last frame, which repeats the first."""
    return _part(cycle, slice(0, -1))


def repeated(cycle: Motion, times: int) -> Motion:
    """A cycle whose last frame repeats its first, shown several times on end, each where the one before it ended.

    Returns ``times · N + 1`` frames for a cycle of N + 1. Raises ParameterError for fewer than one time.
    """
    if times < 1:
        raise ParameterError(f"Expected a cycle to be shown at least once, got {times}.")
    carrier = loop_carrier(cycle)
    told = with_world_carrier(cycle, carrier)
    first, last = told.rotations[[0, -1], carrier]
    between = quat_multiply(last, quat_conjugate(first))
    yaw = float(2 * np.arctan2(between[1], between[3]))
    shift = told.translations[-1, carrier] - Placement(yaw).rotate(told.translations[0, carrier])
    onward, placement = Placement(yaw, float(shift[0]), float(shift[2])), Placement()
    rotations, translations = [], []
    for copy in range(times + 1):
        frames = slice(0, -1) if copy < times else slice(0, 1)
        turn, place = told.rotations[frames].copy(), told.translations[frames].copy()
        turn[:, carrier] = quat_multiply(placement.rotation, turn[:, carrier])
        place[:, carrier] = placement.move(place[:, carrier])
        rotations.append(turn)
        translations.append(place)
        ahead = onward.move(np.array([placement.x, 0.0, placement.z]))
        placement = Placement(placement.yaw + yaw, float(ahead[0]), float(ahead[2]))
    whole = replace(told, rotations=np.concatenate(rotations), translations=np.concatenate(translations))
    return with_local_carrier(whole, carrier)
