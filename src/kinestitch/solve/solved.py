"""What a solve gives back: the motion, the hard cut it came from, and the choices made."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from kinestitch.core.motion import Motion, motion_of_units
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_rotate
from kinestitch.rig.carrier import lift_travel
from kinestitch.solve.chart import Chart
from kinestitch.solve.placed import Placed, frame_above
from kinestitch.solve.seam import SeamPlace

if TYPE_CHECKING:
    from kinestitch.solve.contacts import Contacts

Method = Literal["laplacian", "cut"]
METHODS: tuple[Method, ...] = ("laplacian", "cut")


@dataclass(frozen=True, slots=True)
class Solved:
    """A stitched timeline; made by :func:`solve_timeline` only.

    motion : the result; cut : the hard cut with the root placed; placed : the timeline as it was solved
    seams : where something was solved, with each seam's frame and λ; chart, method : the choices made
    unlocked, contacts : where feet were locked, the motion before that and the contacts that the result keeps
    unpinned : where the timeline has pins, the motion before they were met
    """

    motion: Motion
    cut: Motion
    placed: Placed
    seams: tuple[SeamPlace, ...]
    chart: Chart
    method: Method
    unlocked: Motion | None = None
    contacts: Contacts | None = None
    unpinned: Motion | None = None


@dataclass(frozen=True, eq=False, slots=True)
class SolvedWindow:
    """The frames [start, stop) of a result that a cluster of seams changes, carrier told in the world.

    rotations : (n, J, 4); translations : (n, J, 3) m
    """

    start: int
    stop: int
    rotations: Array
    translations: Array


def as_motion(placed: Placed, rotations: Array, translations: Array) -> Motion:
    """The result with its carrier told in its parent's frame again; the joints above it stand as in the original."""
    carrier = placed.carrier
    if carrier != 0:
        position, rotation = frame_above(placed)
        undo = quat_conjugate(rotation)
        translations[:, carrier] = quat_rotate(undo, translations[:, carrier] - position)
        rotations[:, carrier] = quat_multiply(undo, rotations[:, carrier])
        first = placed.sources[next(iter(placed.sources))]
        for joint in placed.skeleton.chain(carrier)[:-1]:
            translations[:, joint] = first.translations[0, joint]
            rotations[:, joint] = first.rotations[0, joint]
    rotations.setflags(write=False)
    translations.setflags(write=False)
    name = placed.timeline.segments[0].clip
    motion = motion_of_units(placed.skeleton, translations, rotations, placed.timeline.fps, name)
    return motion if placed.writes == carrier else lift_travel(motion, placed.writes, carrier)
