"""Numbers that say whether a loop is good: what happens between a cycle's last frame and the next one's first.

Every step is held against the cycle's own, measured before it was solved, at all places but the seam. A loop whose seam
cannot be told from the rest of it passes, however fast the clip is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from kinestitch.analysis.skating import slides
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_distance, quat_multiply, quat_to_rotvec
from kinestitch.errors import SkeletonMismatchError
from kinestitch.rig.carrier import world_of
from kinestitch.solve.contacts import Contacts
from kinestitch.solve.loop import Looped, opened, repeated
from kinestitch.solve.loop_feet import lock_loop, loop_contacts
from kinestitch.solve.root import GROUND
from kinestitch.solve.seam import visible_reach

GATES: Mapping[str, float] = {
    "seam_ratio": 1.5,
    "position_step_m": 0.01,
    "rotation_step_deg": 1.0,
    "velocity_step_m_s": 0.1,
    "angular_velocity_step_deg_s": 5.0,
    "foot_slide_m_s": 0.3,
}
"""What a good loop does not exceed."""

_DECIMALS = dict(zip(GATES, (2, 4, 2, 3, 1, 2), strict=True))

_TYPICAL = 95.0  # percent of a cycle's frames that turn no joint further than is typical


@dataclass(frozen=True, slots=True)
class LoopQuality:
    """A loop's seam in numbers.

    seam_ratio : largest joint's turn over the seam, divided by the 95th percentile of the largest joint's turn from
    frame to frame within the cycle
    position_step_m, rotation_step_deg : how far a joint goes in the world, and turns against its parent, over the
    seam, less the most that it does between two other frames; of the worst joint, negative where none does more
    velocity_step_m_s, angular_velocity_step_deg_s : by how much its velocity changes at the last or the first frame,
    less the most by which it changes at another; of the worst joint
    foot_slide_m_s : largest speed over the ground of an ankle or toe in the midst of a contact, within the visible
    reach of the seam (Eq. 9); NaN on a rig without feet
    """

    seam_ratio: float
    position_step_m: float
    rotation_step_deg: float
    velocity_step_m_s: float
    angular_velocity_step_deg_s: float
    foot_slide_m_s: float

    def keeps(self, gate: str) -> bool:
        """Whether one of the ``GATES`` is not exceeded; what could not be measured does not exceed."""
        return not getattr(self, gate) > GATES[gate]

    @property
    def missed(self) -> tuple[str, ...]:
        """The ``GATES`` that are exceeded."""
        return tuple(gate for gate in GATES if not self.keeps(gate))


def gate_text(gate: str, value: float) -> str:
    """A gate's value with as many decimals as matter."""
    decimals = _DECIMALS[gate]
    return f"{round(value, decimals) + 0.0:.{decimals}f}"


def loop_quality(looped: Looped, contacts: Contacts | None, *, before: bool = False) -> LoopQuality:
    """The numbers of a loop, or of the same frames before they were solved.

    contacts : of the N frames of the cycle, by :func:`feet_of`
    """
    cycle = looped.cut if before else looped.motion
    last = cycle.frames - 1
    twice = repeated(cycle, 2)
    turns, ways, spins, pushes = _steps(twice)
    own = _steps(opened(looped.cut))
    typical = np.percentile(own[0].max(axis=1), _TYPICAL)
    reach = visible_reach(looped.stiffness)
    return LoopQuality(
        seam_ratio=float(turns[last - 1].max() / max(typical, 1e-9)),
        position_step_m=_over(ways[last - 1 : last], own[1]),
        rotation_step_deg=float(np.degrees(_over(turns[last - 1 : last], own[0]))),
        velocity_step_m_s=_over(pushes[last - 2 : last], own[3]),
        angular_velocity_step_deg_s=float(np.degrees(_over(spins[last - 2 : last], own[2]))),
        foot_slide_m_s=np.nan if contacts is None else _slide(twice, contacts, reach),
    )


def _steps(motion: Motion) -> tuple[Array, Array, Array, Array]:
    """From frame to frame (F − 1, J): turns in rad and ways in m; at each inner frame (F − 2, J): changes of angular
    velocity in rad/s and of velocity in m/s.
    """
    turns = quat_to_rotvec(quat_multiply(quat_conjugate(motion.rotations[:-1]), motion.rotations[1:]))
    ways = np.diff(world_pose(motion).positions, axis=0)
    sizes = [np.linalg.norm(values, axis=-1) for values in (turns, ways)]
    changes = [np.linalg.norm(np.diff(values, axis=0), axis=-1) * motion.fps for values in (turns, ways)]
    return sizes[0], sizes[1], changes[0], changes[1]


def _over(here: Array, own: Array) -> float:
    """The largest value here (n, J) less the same joint's largest own (m, J), of the worst joint."""
    return float((here.max(axis=0) - own.max(axis=0, initial=0.0)).max())


def _slide(twice: Motion, contacts: Contacts, reach: int) -> float:
    """Largest speed in m/s near the seam in the middle of two cycles, a frame's width away from the contacts' ends."""
    held = np.concatenate([contacts.held, contacts.held, contacts.held[:1]])
    stands = held[1:] & held[:-1]
    stands[1:-1] &= stands[2:] & stands[:-2]
    seam = len(contacts.held)
    near = slice(max(0, seam - reach), seam + reach)
    return float(slides(twice, contacts.joints)[near][stands[near]].max(initial=0.0) * twice.fps)


def feet_of(motion: Motion, looped: Looped) -> Contacts | None:
    """When the feet stand in a cycle of the clip `motion`; None on a rig without feet."""
    try:
        return loop_contacts(motion, looped)
    except SkeletonMismatchError:
        return None


def with_feet_locked(motion: Motion, looped: Looped) -> Looped:
    """The loop of the clip `motion` with its feet locked, where they slide over the seam and locking them leaves fewer
    of the ``GATES`` exceeded; else the loop as it is.
    """
    contacts = feet_of(motion, looped)
    own = loop_quality(looped, contacts)
    if contacts is None or own.keeps("foot_slide_m_s"):
        return looped
    other = lock_loop(motion, looped)
    return other if len(loop_quality(other, feet_of(motion, other)).missed) < len(own.missed) else looped


def loop_report(motion: Motion, looped: Looped) -> Mapping[str, Any]:
    """A loop as one JSON object: its frames in the clip `motion`, how far it goes and turns in a cycle, by how much it
    was moved at most, and under ``gates`` each of the ``GATES`` before and after.
    """
    contacts = feet_of(motion, looped)
    before, after = loop_quality(looped, contacts, before=True), loop_quality(looped, contacts)
    place, turn = world_of(looped.motion, looped.carrier)
    between = quat_multiply(turn[-1], quat_conjugate(turn[0]))
    yaw = 2 * np.arctan2(between[1], between[3])
    return {
        "start": looped.span.start,
        "stop": looped.span.stop,
        "frames": len(looped.span),
        "fps": motion.fps,
        "lambda": looped.stiffness,
        "travel_m": float(np.linalg.norm((place[-1] - place[0])[list(GROUND)])),
        "turn_deg": float(np.degrees(np.pi - (np.pi - yaw) % (2 * np.pi))),
        "deviation_max_deg": float(np.degrees(quat_distance(looped.motion.rotations, looped.cut.rotations).max())),
        "gates": {
            gate: {
                "before": getattr(before, gate),
                "after": getattr(after, gate),
                "bound": bound,
                "kept": after.keeps(gate),
            }
            for gate, bound in GATES.items()
        },
    }
