"""Pins after the solve: the body as a whole first, then its feet, then single joints from the trunk outwards.

Everything the seams have decided is the target here; where pins and seams share their stiffness that is the same as
solving them together.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.pins import Pin
from kinestitch.errors import ParameterError
from kinestitch.rig.hips import bare_name
from kinestitch.solve.contacts import Contacts
from kinestitch.solve.ground import GROUND_KINDS, ground_move, moved
from kinestitch.solve.joint_pins import Turn, turned_joints
from kinestitch.solve.placed import Placed
from kinestitch.solve.reach import MET, limb_of, turns_to
from kinestitch.solve.replant import replanted


def pinned(motion: Motion, placed: Placed, contacts: Contacts | None = None) -> tuple[Motion, Contacts | None]:
    """A solved motion with its timeline's pins, and its contacts.

    contacts : when feet stand, so that they stand where the path has been taken too; None leaves legs as they are

    Raises ParameterError for pins that cannot be met, and for joints that the rig does not have.
    """
    pins = placed.timeline.pins
    whole = [pin for pin in pins if pin.kind in GROUND_KINDS]
    if whole:
        move = ground_move(motion, placed, whole)
        before, motion = motion, moved(motion, move, placed.writes)
        if contacts is not None:
            motion, contacts = replanted(before, motion, move, contacts)
    return pinned_joints(motion, [pin for pin in pins if pin.joint is not None]), contacts


def pinned_joints(motion: Motion, pins: Sequence[Pin]) -> Motion:
    """The motion with pins of single joints, positions and rotations; frames beyond their reach stay bit by bit.

    A position becomes rotations of the joints that lead there, on the pin's frame. Pins of the trunk come before those
    of hands and feet, which hang on it. Raises ParameterError as :func:`pinned`.
    """
    if not pins:
        return motion
    skeleton = motion.skeleton
    joints = {pin: joint_called(skeleton, pin) for pin in pins}
    turns = [Turn(joints[pin], np.array(pin.target), pin) for pin in pins if pin.kind == "rotation"]
    places = [pin for pin in pins if pin.kind == "position"]
    outer = [pin for pin in places if limb_of(skeleton, joints[pin]) is not None]
    out = _with_turns(motion, turns)
    for group in ([pin for pin in places if pin not in outer], outer):
        found = []
        for pin in group:
            taken = [turn.joint for turn in turns if turn.pin.frame == pin.frame]
            found += turns_to(out, pin, joints[pin], taken)
        turns += found
        out = _with_turns(motion, turns) if found else out
    _check_met(out, [(pin, joints[pin]) for pin in places if pin.exact])
    return out


def _with_turns(motion: Motion, turns: Sequence[Turn]) -> Motion:
    if not turns:
        return motion
    return replace(motion, rotations=turned_joints(motion.rotations, turns, motion.fps, motion.skeleton.names))


def _check_met(motion: Motion, places: Sequence[tuple[Pin, int]]) -> None:
    frames = sorted({pin.frame for pin, _ in places})
    if not frames:
        return
    part = replace(motion, rotations=motion.rotations[frames], translations=motion.translations[frames])
    positions = world_pose(part, [joint for _, joint in places]).positions
    for pin, joint in places:
        missed = float(np.linalg.norm(positions[frames.index(pin.frame), joint] - np.array(pin.target)))
        if missed > MET:
            raise ParameterError(
                f"Expected pins that can be met together, got {pin}, which is missed by {missed:.3g} m for the sake of "
                "others on its frame. Leave one out."
            )


def joint_called(skeleton: Skeleton, pin: Pin) -> int:
    """Index of a pin's joint, with or without its namespace; raises ParameterError with the nearest names."""
    names, name = skeleton.names, pin.joint or ""
    if name in names:
        return names.index(name)
    bare = [index for index, known in enumerate(names) if bare_name(known) == name]
    if len(bare) == 1:
        return bare[0]
    import difflib

    near = difflib.get_close_matches(name, [*names, *map(bare_name, names)], n=3, cutoff=0.4) or names[:3]
    raise ParameterError(f"Expected the name of a joint for {pin}, got {name!r}. Try {', '.join(near)}.")
