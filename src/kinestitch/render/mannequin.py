"""A skeleton with a body on: which shapes stand for its bones, how thick they are and which side they belong to."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.mirror import mirror_pairs
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_identity, quat_rotate
from kinestitch.core.skeleton import Skeleton

LEGS = ((0.044, 0.030), (0.030, 0.018), (0.018, 0.015), (0.014, 0.010))
ARMS = ((0.027, 0.021), (0.021, 0.014), (0.015, 0.013), (0.008, 0.006))
"""Radii at both ends of each bone down a limb, as shares of the body's height."""
ROD, DOT = (0.006, 0.006), 0.0095
"""Radii of a bare skeleton's bones and joints."""
_LEG = re.compile(r"(?i)leg|foot|toe|ankle|knee|thigh|calf|shin")
_GIRDLE = re.compile(r"(?i)shoulder|clav|collar")
_CIRCLE = np.stack([np.cos(np.arange(32) * np.pi / 16), np.sin(np.arange(32) * np.pi / 16)], axis=1)


@dataclass(frozen=True, slots=True)
class Part:
    """One shape of the mannequin: the convex hull of discs around joints.

    joints : indices; radii : of each disc, as shares of the body's height; side : ``left``, ``right`` or ``torso``
    """

    joints: tuple[int, ...]
    radii: tuple[float, ...]
    side: str


def with_tips(skeleton: Skeleton) -> Skeleton:
    """The skeleton with a joint of its own at every leaf's tip: hands, toes and heads of a BVH file get their ends."""
    leaves = [j for j in range(skeleton.joint_count) if np.isfinite(skeleton.tips[j]).all()]
    return Skeleton(
        (*skeleton.names, *(f"{skeleton.names[j]}_tip" for j in leaves)),
        (*skeleton.parents, *leaves),
        np.concatenate([skeleton.offsets, skeleton.tips[leaves]]),
        np.concatenate([skeleton.rest, quat_identity((len(leaves),))]),
    )


def joint_positions(motion: Motion) -> Array:
    """World positions (F, J + T, 3) m of the joints and then of the T tips, in the order of :func:`with_tips`."""
    world = world_pose(motion)
    leaves = np.flatnonzero(np.isfinite(motion.skeleton.tips).all(axis=1))
    ends = world.positions[:, leaves] + quat_rotate(world.rotations[:, leaves], motion.skeleton.tips[leaves])
    return np.concatenate([world.positions, ends], axis=1)


def left_joints(skeleton: Skeleton) -> list[int]:
    """Indices of the joints that are named as the left one of a pair."""
    pairs = mirror_pairs(skeleton)
    return [j for j, other in enumerate(pairs) if j != other and _is_left(skeleton.names[j], skeleton.names[other])]


def _is_left(name: str, other: str) -> bool:
    return next(a for a, b in zip(name, other, strict=False) if a != b).lower() == "l"


def anchor(skeleton: Skeleton) -> int:
    """The joint that the figure hangs on: where the legs meet, not a dummy above it; the root if there are no legs."""
    lower = _limb_tops(skeleton)[1]
    return _common(skeleton, lower) if len(lower) > 1 else 0


def feet(skeleton: Skeleton) -> list[tuple[int, str]]:
    """The joint of each foot that is nearest the ground, three bones down the leg at most, and its side."""
    left = set(left_joints(skeleton))
    found = []
    for top in _limb_tops(skeleton)[1]:
        joint = top
        for _ in range(3):
            joint = max(skeleton.children(joint), key=lambda child: _depth(skeleton, child), default=joint)
        found.append((joint, "left" if top in left else "right"))
    return found


def body_height(positions: Array) -> float:
    """Height in m of a body of (F, J, 3) m: the 90th percentile of its frames' heights, or half its width if larger."""
    extent = np.percentile(np.ptp(positions, axis=1), 90, axis=0)
    height = max(float(extent[1]), 0.5 * float(extent.max()))
    return height if height > 1e-6 else 1.0


def _depth(skeleton: Skeleton, joint: int) -> int:
    return 1 + max((_depth(skeleton, child) for child in skeleton.children(joint)), default=0)


def _limb(
    skeleton: Skeleton, joint: int, side: str, radii: tuple[tuple[float, float], ...], level: int = 0
) -> list[Part]:
    parts = []
    for child in skeleton.children(joint):
        ends = radii[min(level, len(radii) - 1)]
        parts.append(Part((joint, child), ends, side))
        parts += _limb(skeleton, child, side, radii, level + 1)
    return parts


def _limb_tops(skeleton: Skeleton) -> tuple[list[int], list[int]]:
    """Where arms and legs begin: sided joints on a parent without side, past a collar bone, two bones long or more."""
    pairs = mirror_pairs(skeleton)
    arms: list[int] = []
    legs: list[int] = []
    for joint, parent in enumerate(skeleton.parents):
        sided = pairs[joint] != joint and (parent < 0 or pairs[parent] == parent)
        if not sided or _depth(skeleton, joint) < 3:
            continue
        named = _GIRDLE.search(skeleton.names[joint]) and _depth(skeleton, joint) >= 4
        collar = named or not np.linalg.norm(skeleton.offsets[joint]) > 0
        children = [c for c in skeleton.children(joint) if _depth(skeleton, c) >= 3]
        top = children[0] if collar and children else joint
        (legs if any(_LEG.search(skeleton.names[j]) for j in _below(skeleton, top)) else arms).append(top)
    return arms, legs


def _below(skeleton: Skeleton, joint: int) -> list[int]:
    return [j for j in range(skeleton.joint_count) if joint in skeleton.chain(j)]


@lru_cache(maxsize=16)
def mannequin(skeleton: Skeleton) -> tuple[Part, ...]:
    """The parts of a skeleton's body; bones that belong to no limb, head or trunk are thin."""
    left = set(left_joints(skeleton))
    pairs = mirror_pairs(skeleton)
    side_of = {j: ("left" if j in left else "right") for j in range(skeleton.joint_count) if pairs[j] != j}
    upper, lower = _limb_tops(skeleton)
    limbs = [part for top in upper for part in _limb(skeleton, top, side_of[top], ARMS)]
    limbs += [part for top in lower for part in _limb(skeleton, top, side_of[top], LEGS)]
    trunk = _trunk(skeleton, upper, lower)
    covered = {part.joints[-1] for part in limbs} | {joint for part in trunk for joint in part.joints}
    covered |= {joint for top in (*upper, *lower) for joint in skeleton.chain(top)} if trunk else set()
    covered |= set(skeleton.chain(anchor(skeleton)))
    bones = [(parent, joint) for joint, parent in enumerate(skeleton.parents) if parent >= 0 and joint not in covered]
    loose = [part for parent, joint in bones for part in _loose(skeleton, parent, joint, side_of.get(joint, "torso"))]
    heads = [j for j, name in enumerate(skeleton.names) if _is_head(name) and not skeleton.children(j)]
    parts = limbs + trunk + loose + [Part((j,), (-1.0,), "torso") for j in heads]
    return tuple(parts) if parts else (Part((0,), (0.03,), "torso"),)


@lru_cache(maxsize=16)
def bones(skeleton: Skeleton) -> tuple[Part, ...]:
    """The parts of a bare skeleton: a rod for each bone, a dot for each joint; none above where the legs meet."""
    left = set(left_joints(skeleton))
    pairs = mirror_pairs(skeleton)
    side = ["torso" if pairs[j] == j else "left" if j in left else "right" for j in range(skeleton.joint_count)]
    above = set(skeleton.chain(anchor(skeleton))[:-1])
    shown = [j for j in range(skeleton.joint_count) if j not in above]
    rods = [Part((skeleton.parents[j], j), ROD, side[j]) for j in shown if skeleton.parents[j] in shown]
    return (*rods, *(Part((j,), (DOT,), side[j]) for j in shown))


def soles(parts: tuple[Part, ...], joint: int) -> list[int]:
    """Numbers of the parts that show whether a joint of a foot stands: those that begin there, else that end there."""
    begin = [number for number, part in enumerate(parts) if part.joints[0] == joint]
    if any(len(parts[number].joints) > 1 for number in begin):
        return begin
    return [number for number, part in enumerate(parts) if joint in (part.joints[0], part.joints[-1])]


def _is_head(name: str) -> bool:
    return name.lower().endswith("head")


def _trunk(skeleton: Skeleton, upper: list[int], lower: list[int]) -> list[Part]:
    if len(upper) < 2 or len(lower) < 2:
        return []
    low = _common(skeleton, lower)
    spine = [j for j in skeleton.chain(_common(skeleton, upper)) if j >= low]
    waist = spine[(len(spine) - 1) // 2]
    chest = spine[spine.index(waist) :]
    chest_radii = (0.056, *(0.05,) * (len(chest) - 1))
    return [
        Part((*lower, low, waist), (*(0.045,) * len(lower), 0.05, 0.056), "torso"),
        Part((*upper, *chest), (*(0.028,) * len(upper), *chest_radii), "torso"),
    ]


def _common(skeleton: Skeleton, joints: list[int]) -> int:
    shared = set(skeleton.chain(joints[0])).intersection(*(skeleton.chain(j) for j in joints[1:]))
    return max(shared)


def _loose(skeleton: Skeleton, parent: int, joint: int, side: str) -> list[Part]:
    name = skeleton.names[parent].lower()
    if _is_head(name):
        return [Part((parent, joint), (-1.0, -1.0), side)] if side == "torso" else []  # a ball between both; no eyes
    radius = 0.022 if "neck" in name or "spine" in name else 0.014
    return [Part((parent, joint), (radius, radius), side)]


def outlines(parts: tuple[Part, ...], points: Array, height: float) -> Array:
    """Outlines (P, 32, 2), counter-clockwise, of parts on paper from one pose's projected joints (J, 2 or 3).

    height : of the body, in the unit of `points`

    In each of 32 directions the outline is where the disc that reaches furthest ends.
    """
    joints, radii, balls, ends = _discs(parts)
    centres = points[joints, :2]
    reach = radii * height
    if balls.any():
        a, b = points[ends[:, 0], :2], points[ends[:, 1], :2]
        size = np.clip(0.52 * np.linalg.norm(b - a, axis=-1), 0.055 * height, 0.075 * height)
        centres = np.where(balls[:, None, None], ((a + b) / 2)[:, None], centres)
        reach = np.where(balls[:, None], size[:, None], reach)
    furthest = np.argmax(centres @ _CIRCLE.T + reach[..., None], axis=1)  # (P, 32)
    rows = np.arange(len(parts))[:, None]
    return np.asarray(centres[rows, furthest] + reach[rows, furthest][..., None] * _CIRCLE)


@lru_cache(maxsize=64)
def _discs(parts: tuple[Part, ...]) -> tuple[np.ndarray, Array, np.ndarray, np.ndarray]:
    """Joints and radii (P, D) of each part's discs, short lists filled up with their first; which parts are balls, and
    the joints (P, 2) between which they lie.
    """
    most = max(len(part.joints) for part in parts)
    joints = np.array([part.joints + part.joints[:1] * (most - len(part.joints)) for part in parts])
    radii = np.array([part.radii + part.radii[:1] * (most - len(part.radii)) for part in parts])
    ends = np.array([(part.joints[0], part.joints[-1]) for part in parts])
    return joints, radii, radii[:, 0] < 0, ends


def hull(points: Array) -> Array:
    """Convex hull (K, 2), counter-clockwise, of points (N, 2): Andrew's monotone chain."""
    order = sorted(set(map(tuple, points.tolist())))

    def half(path: list[tuple[float, ...]]) -> list[tuple[float, ...]]:
        chain: list[tuple[float, ...]] = []
        for p in path:
            while len(chain) > 1 and _turn(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return np.array(half(order) + half(order[::-1]) or order[:1])


def _turn(o: tuple[float, ...], a: tuple[float, ...], b: tuple[float, ...]) -> float:
    return (a[0] - o[0]) * (b[1] - o[1]) - (a[1] - o[1]) * (b[0] - o[0])
