"""Numbers that say whether a seam is good, before and after it was solved.

Before is the hard cut after the root has been placed, after is the result as it would be written. All steps are
geodesic and local (each joint against its parent), so that a pop in the shoulder is not counted again in every
finger.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, replace
from time import perf_counter
from typing import Any

import numpy as np

from kinestitch.core.components import join, split
from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import (
    Array,
    quat_conjugate,
    quat_continuous,
    quat_distance,
    quat_log,
    quat_mean,
    quat_multiply,
    quat_to_rotvec,
)
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.chart import chart_vectors, corrected
from kinestitch.solve.energy import seam_price
from kinestitch.solve.placed import Placed, straddling, target_window
from kinestitch.solve.seam import SeamPlace, clusters, shared_curves, visible_reach
from kinestitch.solve.solved import Solved
from kinestitch.solve.sources import own_triples
from kinestitch.solve.window import chart_window, hips_to_world, parts, solve_translations, way_to_hips


@dataclass(frozen=True, slots=True)
class SeamQuality:
    """One seam in numbers.

    frame : first frame after the seam in the result
    price : least energy E* of this seam alone in rad², λ included, unweighted, rotations from the hips down (Eq. 10)
    rotation_step_deg : largest joint's turn from frame−1 to frame
    angular_velocity_step_deg_s : largest joint's change from the last interval before the seam to the first after it
    deviation_mean_deg, deviation_max_deg : distance of the result from the hard cut within the visible reach (Eq.
    9), all joints
    dynamics_kept : ‖L R‖ over ‖δ_tar‖ there, joints other than the hips; a crossfade averages it away
    root_step_m : distance the hips move in the world from frame−1 to frame
    """

    frame: int
    stiffness: float
    price: float
    rotation_step_deg_before: float
    rotation_step_deg_after: float
    angular_velocity_step_deg_s_before: float
    angular_velocity_step_deg_s_after: float
    deviation_mean_deg: float
    deviation_max_deg: float
    dynamics_kept: float
    root_step_m_before: float
    root_step_m_after: float


def rotation_step(motion: Motion, frame: int) -> float:
    """Largest joint's turn in rad between frames `frame` − 1 and `frame`."""
    return float(quat_distance(motion.rotations[frame - 1], motion.rotations[frame]).max())


def angular_velocity_step(motion: Motion, frame: int) -> float:
    """Largest joint's change of angular velocity in rad/s, in its own axes, over the seam before `frame`.

    It compares the interval that ends at `frame` − 1 with the one that starts at `frame`; the step between the two
    frames is the rotation step and not counted again. Where the motion ends there, the seam's own interval stands in.
    """

    def velocity(first: int) -> Array:
        pair = motion.rotations[first : first + 2]
        return quat_to_rotvec(quat_multiply(quat_conjugate(pair[0]), pair[1])) * motion.fps

    before = velocity(max(frame - 2, 0))
    after = velocity(min(frame, motion.frames - 2))
    return float(np.linalg.norm(after - before, axis=-1).max())


def deviation(motion: Motion, cut: Motion, frame: int, reach: int) -> tuple[float, float]:
    """Mean and largest distance in rad of a result from its hard cut, all joints, frames [frame − reach, frame +
    reach).
    """
    near = slice(max(0, frame - reach), frame + reach)
    gap = quat_distance(motion.rotations[near], cut.rotations[near])
    return float(gap.mean()), float(gap.max())


def root_step(motion: Motion, frame: int) -> float:
    """Distance in m that the hips move in the world between frames `frame` − 1 and `frame`."""
    pair = replace(
        motion,
        rotations=motion.rotations[frame - 1 : frame + 1],
        translations=motion.translations[frame - 1 : frame + 1],
    )
    joint = hips_joint(motion.skeleton)
    hips = world_pose(pair, [joint]).positions[:, joint]
    return float(np.linalg.norm(hips[1] - hips[0]))


def dynamics_kept(motion: Motion, placed: Placed, seam: SeamPlace) -> float:
    """``‖L R‖ / ‖δ_tar‖`` within the visible reach of a seam, joints other than the hips: 1 where the sources'
    dynamics survive.

    R are the motion's vectors in the chart centred on the seam, followed through it on one branch, whichever method
    made it; δ_tar the second differences of both sources, each among its own neighbours, on the same branch. 1.0 where
    the sources do not move at all.
    """
    reach = visible_reach(seam.stiffness)
    start, stop = max(1, seam.frame - reach), min(placed.frames - 1, seam.frame + reach)
    if stop <= start:
        return 1.0
    joints = [j for j in range(placed.skeleton.joint_count) if j not in {placed.carrier, hips_joint(placed.skeleton)}]
    if not joints:
        return 1.0
    own = own_triples(placed, start, stop)[:, :, joints]
    base = quat_mean(straddling(placed, seam).rotations[:, joints])
    result = motion.rotations[start - 1 : stop + 1, joints]
    path = quat_continuous(quat_multiply(quat_conjugate(base), result))
    at_seam = path[seam.frame - start : seam.frame - start + 2, :, 3].sum(axis=0)
    path *= np.where(at_seam < 0, -1.0, 1.0)[:, None]
    vectors = quat_log(path)
    kept = vectors[:-2] - 2 * vectors[1:-1] + vectors[2:]
    sign = _signs(path, quat_multiply(quat_conjugate(base), result))
    base = split(base)[:, None]
    sheet = sign[1:-1] * _signs(result[1:-1], own[1])
    flips = np.stack([sheet * _signs(own[1], own[0]), sheet, sheet * _signs(own[1], own[2])])
    triples = join(chart_vectors(base[:, None], split(own), flips)[0])
    wanted = triples[0] - 2 * triples[1] + triples[2]
    size = float(np.linalg.norm(wanted))
    return float(np.linalg.norm(kept)) / size if size > 1e-12 else 1.0


def _signs(p: Array, q: Array) -> Array:
    return np.where(np.einsum("...i,...i->...", p, q) < 0, -1.0, 1.0)


def seam_quality(solved: Solved, seam: SeamPlace) -> SeamQuality:
    """All numbers of one seam of a solved timeline."""
    frame, motion, cut = seam.frame, solved.motion, solved.cut
    mean, largest = deviation(motion, cut, frame, visible_reach(seam.stiffness))
    return SeamQuality(
        frame=frame,
        stiffness=seam.stiffness,
        price=seam_price(replace(solved.placed, groups=()), seam),
        rotation_step_deg_before=float(np.degrees(rotation_step(cut, frame))),
        rotation_step_deg_after=float(np.degrees(rotation_step(motion, frame))),
        angular_velocity_step_deg_s_before=float(np.degrees(angular_velocity_step(cut, frame))),
        angular_velocity_step_deg_s_after=float(np.degrees(angular_velocity_step(motion, frame))),
        deviation_mean_deg=float(np.degrees(mean)),
        deviation_max_deg=float(np.degrees(largest)),
        dynamics_kept=dynamics_kept(motion, solved.placed, seam),
        root_step_m_before=root_step(cut, frame),
        root_step_m_after=root_step(motion, frame),
    )


def solve_proper(solved: Solved) -> Callable[[], None]:
    """The linear solve of all seams as one call: curves, offsets, product and sum over all channels; charts are made
    before.
    """
    work = []
    for cluster in clusters(solved.seams, solved.placed.frames):
        rotations, translations = target_window(solved.placed, cluster.start, cluster.stop)
        around = [straddling(solved.placed, seam) for seam in cluster.seams]
        poses = np.stack([seam.rotations for seam in around])
        way = way_to_hips(solved.placed) if solved.chart == "centred" else ()
        hips_to_world(way, rotations)
        hips_to_world(way, poses)
        charted = chart_window(solved.placed, cluster, rotations, poses, solved.chart)
        vectors, _ = chart_vectors(
            split(charted.base)[:, None], split(rotations), charted.sign, principal=charted.principal
        )
        for joints, part in parts(solved.placed, cluster):
            travels = isinstance(joints, slice) or solved.placed.carrier in joints
            work.append((part, charted.of(joints), vectors[..., joints], translations, around if travels else None))

    def run() -> None:
        for part, charted, vectors, translations, around in work:
            curves = shared_curves(part)
            corrected(vectors, charted.offsets, part, curves)
            if around is not None:
                solve_translations(solved.placed.carrier, part, curves, translations, around)

    return run


def solve_milliseconds(solved: Solved, repeats: int = 5) -> float:
    """Least time in ms of `repeats` runs of :func:`solve_proper`."""
    run = solve_proper(solved)

    def once() -> float:
        start = perf_counter()
        run()
        return (perf_counter() - start) * 1e3

    return min(once() for _ in range(repeats))


def _automatic(placed: Placed, seam: SeamPlace) -> dict[str, Any]:
    """What was chosen for an automatic seam: its smoothing time in s, and each part's of the body."""

    def chosen(stiffness: float) -> float:
        return float(stiffness**0.25 / placed.timeline.fps)

    number = [other.index for other in placed.seams].index(seam.index)
    groups = {group.name: group.stiffness[number] for group in placed.groups}
    return {
        "automatic": True,
        "smoothing_s": chosen(seam.stiffness),
        "groups": {name: {"lambda": value, "smoothing_s": chosen(value)} for name, value in groups.items()},
    }


def report(solved: Solved) -> Mapping[str, Any]:
    """The numbers of a stitch as one JSON object: ``frames``, ``fps``, ``joints``, ``solve_ms`` and a list of
    ``seams``. A seam's ``lambda`` is as solved; where it was chosen by itself, the largest of its ``groups``. Where the
    timeline has pins, seams are measured before these were met.
    """
    if solved.unpinned is not None:
        solved = replace(solved, motion=solved.unpinned)
    motion = solved.motion
    seams = []
    for seam in solved.seams:
        numbers = asdict(seam_quality(solved, seam))
        numbers["lambda"] = numbers.pop("stiffness")
        if solved.placed.timeline.seams[seam.index].automatic:
            numbers |= _automatic(solved.placed, seam)
        seams.append(numbers)
    return {
        "frames": motion.frames,
        "fps": motion.fps,
        "joints": motion.skeleton.joint_count,
        "chart": solved.chart,
        "method": solved.method,
        "solve_ms": solve_milliseconds(solved) if solved.method == "laplacian" else 0.0,
        "seams": seams,
    }
