"""What locking the feet has done to a stitch: how far feet slide before it, after it, and in the sources."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from kinestitch.analysis.feet import foot_joints, skating_share, standing_heights, weighted_skate
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.errors import SkeletonMismatchError
from kinestitch.solve.contacts import Contacts, Mask, runs
from kinestitch.solve.footlock import placed_contacts
from kinestitch.solve.seam import visible_reach
from kinestitch.solve.solved import Solved


def slide_in_contact(motion: Motion, contacts: Contacts, *, leave_out: Sequence[int] = ()) -> float:
    """Mean speed in m/s along the ground of the joints that stand, over the intervals both of whose frames are contact.

    leave_out : frames whose interval from the one before does not count. 0.0 where nothing stands.
    """
    held = contacts.held[1:] & contacts.held[:-1]
    held[[frame - 1 for frame in leave_out]] = False
    found = slides(motion, contacts.joints)[held]
    return float(found.mean() * motion.fps) if found.size else 0.0


def slides(motion: Motion, joints: Sequence[int]) -> Array:
    """How far each of K joints moves over the ground from frame to frame: (F − 1, K) m."""
    places = world_pose(motion, joints).positions[:, list(joints)][..., (0, 2)]
    return np.asarray(np.linalg.norm(np.diff(places, axis=0), axis=-1))


def feet_report(solved: Solved) -> Mapping[str, Any] | None:
    """The feet of a stitch as one JSON object, None on a rig without: whether they were ``locked``, and
    :func:`skating_report`.
    """
    before = solved.motion if solved.unlocked is None else solved.unlocked
    try:
        contacts = placed_contacts(solved.placed) if solved.contacts is None else solved.contacts
    except SkeletonMismatchError:
        return None
    numbers = skating_report(replace(solved, motion=before), solved.motion, contacts)
    return {"locked": solved.motion is not before, **numbers}


def skating_report(solved: Solved, result: Motion, contacts: Contacts) -> Mapping[str, Any]:
    """The feet of a stitch as one JSON object.

    solved : before its feet were locked; result : as written; contacts : those that the result keeps

    ``contacts`` are for each joint its stretches [start, stop). Three measures, each ``_before`` and ``_after`` locking
    and of the ``_sources`` (the hard cut without its seams): ``slide_in_contact_m_s``; ``skate_near_seams_m_s``,
    weighed by height, within the visible reach of the seams; and ``skating_share`` of all frames.
    """
    joints = foot_joints(result.skeleton)
    ground = np.min([standing_heights(source, joints) for source in solved.placed.sources.values()], axis=0)
    seams = [seam.frame for seam in solved.seams]
    near = _near(solved)
    out: dict[str, Any] = {
        "contacts": {
            result.skeleton.names[joint]: [list(run) for run in runs(column)]
            for joint, column in zip(contacts.joints, contacts.held.T, strict=True)
        }
    }
    for label, motion, without in (
        ("before", solved.motion, ()),
        ("after", result, ()),
        ("sources", solved.cut, seams),
    ):
        counted = near.copy()
        counted[[frame - 1 for frame in without]] = False
        skate = weighted_skate(motion, joints, ground)[counted]
        out[f"slide_in_contact_m_s_{label}"] = slide_in_contact(motion, contacts, leave_out=without)
        out[f"skate_near_seams_m_s_{label}"] = float(skate.mean() * motion.fps) if skate.size else 0.0
        out[f"skating_share_{label}"] = skating_share(motion, joints, ground)
    return out


def _near(solved: Solved) -> Mask:
    """The intervals (F − 1,) within the visible reach of a seam."""
    near = np.zeros(solved.motion.frames, dtype=bool)
    for seam in solved.seams:
        reach = visible_reach(seam.stiffness)
        near[max(0, seam.frame - reach) : seam.frame + reach] = True
    return near[1:]
