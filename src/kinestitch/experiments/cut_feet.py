"""What it does to feet that a search prefers stances: cuts sought with ever dearer contacts, then solved and locked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from kinestitch.analysis.feet import foot_joints, standing_heights, weighted_skate
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.edit.timeline import FrameRange, Seam, Timeline
from kinestitch.experiments.seams import random_cut
from kinestitch.search.price import PriceMap, price_map, squared_distances
from kinestitch.search.standing import CONTACT, both_standing, standing_columns
from kinestitch.solve.contacts import legs_of
from kinestitch.solve.energy import joint_price
from kinestitch.solve.footlock import locked, placed_contacts
from kinestitch.solve.seam import visible_reach
from kinestitch.solve.stitch import solve_timeline

DEARNESS = (0.0, 0.5, 1.0, 2.0)
"""c of Eq. 23 in rad, the first for a search that knows no feet."""


@dataclass(frozen=True, slots=True)
class FeetAtSeam:
    """What a cut did, with both feet together, within a visible reach of its seam.

    price : E* in rad²; same, shared : whether the same feet stand on both sides of the cut; whether one does
    slide : m, way over the ground of toes that stand in their clips, after the solve
    skate, skate_locked : m, way over the ground weighed by height, after the solve and after locking
    moved : m, the farthest that locking takes a toe off its solved place
    """

    price: float
    same: bool
    shared: bool
    slide: float
    skate: float
    skate_locked: float
    moved: float


@dataclass(frozen=True, eq=False, slots=True)
class Pair:
    """Two clips: the map of all cuts without feet, and what feet add to it for c = 1 rad."""

    prices: PriceMap
    feet: Array
    ground: Array


def compare_dearness(
    clips: Mapping[str, Motion], *, seams: int, seconds: float | None, seed: int = 0
) -> dict[float | None, list[FeetAtSeam]]:
    """Random cuts, under None, and in their place the cheapest within `seconds` (or anywhere) for each of `DEARNESS`.

    Pairs of which one clip never stands are not drawn.
    """
    rng = np.random.default_rng(seed)
    pairs = cache(lambda left, right: pair_of(clips[left], clips[right]))
    found: dict[float | None, list[FeetAtSeam]] = {size: [] for size in (None, *DEARNESS)}
    while len(found[None]) < seams:
        line = random_cut(dict(clips), rng, Seam())
        pair = pairs(*(segment.clip for segment in line.segments))
        if pair is None:
            continue
        measured = cache(lambda line, pair=pair: measure_feet(line, clips, pair.ground))
        found[None].append(measured(line))
        for size in DEARNESS:
            found[size].append(measured(cheapest_cut(pair, line, seconds, size)))
    return found


def pair_of(a: Motion, b: Motion) -> Pair | None:
    """Two clips made ready; None where one of them never stands."""
    prices, held = price_map(a, b, contacts=False), both_standing(a, b)
    if held is None:
        return None
    feet = squared_distances(*standing_columns(*held, prices.stiffness)) / CONTACT**2
    toes = foot_joints(a.skeleton)
    return Pair(prices, feet, np.minimum(standing_heights(a, toes), standing_heights(b, toes)))


def cheapest_cut(pair: Pair, line: Timeline, seconds: float | None, size: float) -> Timeline:
    """The cut of least cost within `seconds` of a line's own (None: anywhere), feet counting with c = `size` rad."""
    left, right = line.segments
    frames, others = pair.prices.a.frames, pair.prices.b.frames
    reach = max(frames, others) if seconds is None else round(seconds * line.fps)
    first = min(pair.prices.kept(frames), left.range.stop), max(left.range.stop - reach, 1)
    last = max(others - pair.prices.kept(others), right.range.start), right.range.start + reach
    outs, intos = (
        slice(max(first), left.range.stop + reach + 1),
        slice(max(right.range.start - reach, 0), min(last) + 1),
    )
    costs = pair.prices.costs[outs, intos] + size**2 * pair.feet[outs, intos]
    i, j = (int(k) for k in np.unravel_index(np.argmin(costs), costs.shape))
    left = replace(left, range=FrameRange(0, outs.start + i))
    return replace(line, segments=(left, replace(right, range=FrameRange(intos.start + j, others))))


def measure_feet(line: Timeline, clips: Mapping[str, Motion], ground: Array) -> FeetAtSeam:
    """Solve a line of one seam, lock its feet, and look at them; ground : m, height of each toe while it stands."""
    solved = solve_timeline(line, clips)
    contacts = placed_contacts(solved.placed)
    (seam,) = solved.seams
    reach = visible_reach(seam.stiffness)
    near = slice(max(seam.frame - reach, 0), min(seam.frame + reach, solved.motion.frames))
    before, after = (
        replace(motion, rotations=motion.rotations[near], translations=motion.translations[near])
        for motion in (solved.motion, locked(solved, contacts).motion)
    )
    legs, feet = legs_of(before.skeleton), foot_joints(before.skeleton)
    held = np.stack([contacts.of(leg.foot, leg.toe) for leg in legs], axis=1)
    stands = held[near][1:] & held[near][:-1]
    toes, locked_toes = (world_pose(motion, feet).positions[:, list(feet)] for motion in (before, after))
    way = np.linalg.norm(np.diff(toes[..., (0, 2)], axis=0), axis=-1)
    sides = held[seam.frame - 1], held[seam.frame]
    return FeetAtSeam(
        price=joint_price(solved.placed),
        same=bool((sides[0] == sides[1]).all()),
        shared=bool((sides[0] & sides[1]).any()),
        slide=float(way[stands].sum()),
        skate=float(weighted_skate(before, feet, ground).sum()),
        skate_locked=float(weighted_skate(after, feet, ground).sum()),
        moved=float(np.linalg.norm(locked_toes - toes, axis=-1).max()),
    )
