"""Where in its steps a body is: the phase of its gait, frame by frame, told by when the feet strike the ground.

The left foot strikes at phase 0, the right one at π, the left one again at 2π; in between the phase rises evenly
(Eq. 38). Who stands, jumps or lands on both feet makes no steps, and has no phase.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike

from kinestitch.core.motion import Motion
from kinestitch.core.retime import time_map
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import ClipInfo, Timeline
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.solve.contacts import Contacts, Mask, find_contacts, legs_of, runs

SHORTEST_STEP, LONGEST_STEP = 0.2, 1.2
"""s from one foot's strike to the other's; closer ones are a landing on both feet, and end the steps."""

_LIFT = 0.15  # s; a foot that is off the ground for less has made no step
_ON_FRAME = 1e-6  # frames

Strike = tuple[int, int]
"""The frame in which a foot begins to stand, and which foot: 0 the left one, 1 the right one."""


def step_phase(motion: Motion, contacts: Contacts | None = None) -> Array:
    """The phase of the gait (F,) in rad, rising through each stretch of steps, NaN where there are none (Eq. 38).

    contacts : of the motion's feet, :func:`find_contacts` when left out

    0 is a strike of the left foot and π one of the right foot, both up to whole turns; the phase is clear from one step
    on. Before the first strike and after the last it goes on for as long as the next step took, at most.

    Raises ParameterError for a clip in which no foot ever stands, SkeletonMismatchError for a rig without feet.

    >>> from kinestitch.samples import sample
    >>> phase = step_phase(sample("walk"))  # 54 strides a minute
    >>> bool(abs((phase[100] - phase[40]) / (2 * np.pi) - 54 / 60) < 0.02)
    True
    """
    found = strikes(motion, contacts)
    phase = np.full(motion.frames, np.nan)
    walks = list(_walks(found, motion.fps))
    for number, walk in enumerate(walks):
        frames = np.array([frame for frame, _ in walk])
        first, last = 2 * frames[0] - frames[1], 2 * frames[-1] - frames[-2]
        if number > 0:
            first = max(first, (walks[number - 1][-1][0] + frames[0] + 1) // 2)
        if number < len(walks) - 1:
            last = min(last, (frames[-1] + walks[number + 1][0][0] - 1) // 2)
        here = np.arange(max(first, 0), min(last, motion.frames - 1) + 1)
        phase[here] = np.pi * (walk[0][1] + _counted(frames, here))
    return phase


def strikes(motion: Motion, contacts: Contacts | None = None) -> list[Strike]:
    """When the feet strike the ground, in the order of time; who stands from the clip's start on has struck before.

    Raises as :func:`step_phase`.
    """
    contacts = find_contacts(motion) if contacts is None else contacts
    if len(contacts.held) != motion.frames:
        raise ParameterError(f"Expected contacts for {motion.frames} frames, got {len(contacts.held)}.")
    if not contacts.held.any():
        raise ParameterError(
            f"Expected a clip in which a foot stands, got no contact in {motion.frames} frames of {motion.name!r}. "
            "On a treadmill, and in the air, there are no steps to find."
        )
    found: list[Strike] = []
    for side, leg in enumerate(legs_of(motion.skeleton)):
        stands = _without_flicker(contacts.of(leg.foot, leg.toe), round(_LIFT * motion.fps))
        found += [(start, side) for start, _ in runs(stands) if start > 0]
    return sorted(found)


def _without_flicker(stands: Mask, shortest: int) -> Mask:
    out = stands.copy()
    for start, stop in runs(~stands):
        if start > 0 and stop < len(out) and stop - start < shortest:
            out[start:stop] = True
    return out


def _walks(found: list[Strike], fps: float) -> list[list[Strike]]:
    """The strikes that follow each other as steps do: foot after foot, neither too soon nor too late."""
    shortest, longest = SHORTEST_STEP * fps, LONGEST_STEP * fps
    both = {
        strike
        for here, there in pairwise(found)
        for strike in (here, there)
        if there[1] != here[1] and there[0] - here[0] < shortest
    }
    walks: list[list[Strike]] = [[]]
    for strike in found:
        before = walks[-1][-1] if walks[-1] else None
        if strike in both:
            walks.append([])
            continue
        if before is not None and (strike[1] == before[1] or strike[0] - before[0] > longest):
            walks.append([])
        walks[-1].append(strike)
    return [walk for walk in walks if len(walk) > 1]


def _counted(frames: np.ndarray, here: np.ndarray) -> Array:
    """How many steps after the first strike each of these frames lies, evenly between strikes and beyond them."""
    count = np.interp(here, frames, np.arange(len(frames)))
    before, after = here < frames[0], here > frames[-1]
    count[before] = (here[before] - frames[0]) / (frames[1] - frames[0])
    count[after] = len(frames) - 1 + (here[after] - frames[-1]) / (frames[-1] - frames[-2])
    return np.asarray(count)


@dataclass(frozen=True, eq=False, slots=True)
class Steps:
    """The steps of a timeline's clips; made by :func:`find_steps` only.

    phases : key of a source → the phase (F,) in rad of its frames, at its own rate
    missing : key of a source without contacts → why it has none, in words
    """

    phases: Mapping[str, Array]
    missing: Mapping[str, str]

    def at(self, info: ClipInfo, times: ArrayLike, frame: float = 0.0) -> Array:
        """The phase in rad at these times in s of a clip, NaN where it makes no steps; up to a frame beyond the ends of
        its source the phase goes on.

        frame : s, how long a frame lasts where the clip is shown, if that is longer than its own
        """
        times = np.asarray(times, dtype=np.float64)
        if info.source not in self.phases:
            return np.full(np.shape(times), np.nan)
        if info.retiming is not None:
            end = info.retiming.knots[-1][0]
            shown = time_map(info.retiming.knots, [-frame, 0.0, end, end + frame])
            frame = max(shown[1] - shown[0], shown[3] - shown[2])
            times = time_map(info.retiming.knots, times)
        return _between_frames(self.phases[info.source], times * info.fps, max(1.0, frame * info.fps))


def find_steps(timeline: Timeline, clips: Mapping[str, Motion]) -> Steps:
    """The steps of all clips that a timeline shows.

    Phases are told by the clips as they are, at their own pace, where contacts are told best; a retimed clip has those
    of its source.
    """
    phases: dict[str, Array] = {}
    missing: dict[str, str] = {}
    for key in dict.fromkeys(timeline.clip(segment.clip).source for segment in timeline.segments):
        try:
            phases[key] = step_phase(clips[key])
        except SkeletonMismatchError:
            missing[key] = "has no feet that its joints' names tell"
        except ParameterError:
            missing[key] = "has no contact of a foot"
    return Steps(phases, missing)


def _between_frames(phases: Array, positions: Array, beyond: float) -> Array:
    """Phases at places that may lie between two frames, and up to so many frames beyond the first and the last."""
    if len(phases) < 2:
        return np.full(np.shape(positions), np.nan)
    last = len(phases) - 1
    early, late = np.minimum(positions, 0.0), np.maximum(positions - last, 0.0)
    found = np.interp(positions, np.arange(len(phases)), phases)
    found = np.where(early < 0.0, phases[0] + early * (phases[1] - phases[0]), found)
    found = np.where(late > 0.0, phases[-1] + late * (phases[-1] - phases[-2]), found)
    return np.where(late - early <= beyond + _ON_FRAME, found, np.nan)
