"""Feet that stand still through the seam of a loop.

The cycle is shown three times on end, each copy where the one before it has ended; feet are locked there as in any
stitch (:mod:`kinestitch.solve.footlock`), and the copy in the middle, which has a seam at either end, is the cycle.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance
from kinestitch.edit.timeline import ClipInfo, Seam, Segment, Timeline
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.contacts import Contacts, find_contacts, legs_of
from kinestitch.solve.footlock import locked
from kinestitch.solve.loop import Looped, repeated
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.seam import SeamPlace
from kinestitch.solve.solved import Solved

_COPIES = 3
_CLOSED = 1e-3  # rad by which a leg may miss its own beginning; less is not seen, and taken away


def loop_contacts(motion: Motion, looped: Looped) -> Contacts:
    """When the feet stand, on the N frames of a cycle: told from the whole clip that it is made of, or, once they are
    locked, those that the lock keeps.

    Raises SkeletonMismatchError for a rig without feet.
    """
    if looped.contacts is not None:
        return looped.contacts
    found = find_contacts(motion)
    return Contacts(found.joints, found.held[looped.span.start : looped.span.stop])


def lock_loop(motion: Motion, looped: Looped) -> Looped:
    """The loop with its feet held near the seam where they stand in the clip `motion` that it is made of.

    Only legs and the height of the hips change. A leg whose foot stands all the time has nowhere to make up for what
    the cycle travels; it is left as it is, and then the hips are too.

    Raises SkeletonMismatchError for a rig without feet.
    """
    contacts, frames = loop_contacts(motion, looped), len(looped.span)
    held = np.concatenate([contacts.held] * _COPIES + [contacts.held[:1]])
    copies = _copies(motion, looped)
    found, here = locked(copies, Contacts(contacts.joints, held)), slice(frames, 2 * frames + 1)
    whole, kept = found.motion, Contacts(contacts.joints, found.contacts.held[here][:-1])
    turned, hips = whole.rotations[here], hips_joint(motion.skeleton)
    down = (whole.translations - copies.motion.translations)[here, hips]
    legs = [[j for j in (leg.thigh, leg.shin, leg.foot, leg.toe) if j is not None] for leg in legs_of(motion.skeleton)]
    closed = [leg for leg in legs if quat_distance(turned[0, leg], turned[-1, leg]).max() < _CLOSED]
    if np.abs(down).max() > 0 and len(closed) < len(legs):
        return looped
    rotations, translations = looped.motion.rotations.copy(), looped.motion.translations.copy()
    for leg in closed:
        if quat_distance(turned[:, leg], rotations[:, leg]).max() > _CLOSED:
            rotations[:-1, leg], rotations[-1, leg] = turned[:-1, leg], turned[0, leg]
    translations[:-1, hips] += down[:-1]
    translations[-1, hips] += down[0]
    result = replace(looped.motion, rotations=rotations, translations=translations)
    return replace(looped, motion=result, contacts=kept)


def _copies(motion: Motion, looped: Looped) -> Solved:
    """The cycle three times on end, as if it had been stitched."""
    clip, count = ClipInfo("cycle", motion.frames, motion.fps), len(looped.span)
    parts, seams = (Segment("cycle", looped.span),) * _COPIES, (Seam(looped.stiffness),) * (_COPIES - 1)
    placed = place_timeline(Timeline((clip,), parts, seams, motion.fps), {"cycle": motion})
    places = tuple(SeamPlace(copy, (copy + 1) * count, looped.stiffness) for copy in range(_COPIES - 1))
    shown, cut = (repeated(cycle, _COPIES) for cycle in (looped.motion, looped.cut))
    return Solved(shown, cut, placed, places, "centred", "laplacian")
