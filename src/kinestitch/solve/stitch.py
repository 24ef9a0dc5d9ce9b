"""The solve: every seam's window re-solved, everything else left as it was.

    minimise  ‖R − R_tar‖² + λ ‖L R − δ_tar‖²                                                       (Eq. 4)

R_tar is the hard cut, δ_tar the second differences of each source among its own neighbours, R the rotation vectors of
all joints in a chart; the ground path is solved on its displacements, height and other translations as positions.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from kinestitch.core.components import join, split
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply, quat_rotate, rotvec_to_quat
from kinestitch.edit.timeline import Timeline
from kinestitch.errors import ParameterError
from kinestitch.rig.carrier import lift_travel
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.chart import (
    Chart,
    Charted,
    centred_chart,
    check_chart,
    corrected,
    mid_tangent,
    principal_chart,
    solve_rotations,
)
from kinestitch.solve.laplacian import check_stiffness
from kinestitch.solve.placed import Placed, Straddling, place_timeline, straddling, target_window
from kinestitch.solve.root import GROUND, chain_rotation, displacement_residuals
from kinestitch.solve.seam import (
    Cluster,
    SeamPlace,
    clusters,
    correction,
    displacement_correction,
    shared_curves,
)

Method = Literal["laplacian", "cut"]
METHODS: tuple[Method, ...] = ("laplacian", "cut")


@dataclass(frozen=True, slots=True)
class Solved:
    """A stitched timeline; made by :func:`solve_timeline` only.

    motion : the result; cut : the hard cut with the root placed; placed : the timeline as it was solved
    seams : where something was solved, with each seam's frame and λ; chart, method : the choices made
    """

    motion: Motion
    cut: Motion
    placed: Placed
    seams: tuple[SeamPlace, ...]
    chart: Chart
    method: Method


@dataclass(frozen=True, eq=False, slots=True)
class SolvedWindow:
    """The frames [start, stop) of a result that a cluster of seams changes, carrier told in the world.

    rotations : (n, J, 4); translations : (n, J, 3) m
    """

    start: int
    stop: int
    rotations: Array
    translations: Array


def stitch(
    timeline: Timeline, clips: Mapping[str, Motion], *, chart: Chart = "centred", method: Method = "laplacian"
) -> Motion:
    """The timeline as one motion whose seams are solved.

    clips : a motion for every key the timeline uses; chart : ``centred`` or ``principal`` (as published)
    method : ``laplacian``, or ``cut`` for the hard cut with the root placed

    Frames further than a seam's window (Eq. 8) from every seam are exactly those of their sources, rigidly placed.

    Raises MissingClipError, SkeletonMismatchError, RangeError, ParameterError.
    """
    _check(chart, method)
    placed = place_timeline(timeline, clips)
    rotations, translations = target_window(placed, 0, placed.frames)
    if method == "laplacian":
        _solve_into(placed, rotations, translations, chart)
    return as_motion(placed, rotations, translations)


def solve_timeline(
    timeline: Timeline, clips: Mapping[str, Motion], *, chart: Chart = "centred", method: Method = "laplacian"
) -> Solved:
    """Like :func:`stitch`, with the hard cut and the seams beside the result, for those who measure."""
    _check(chart, method)
    placed = place_timeline(timeline, clips)
    rotations, translations = target_window(placed, 0, placed.frames)
    cut = as_motion(placed, rotations.copy(), translations.copy())
    if method == "cut":
        return Solved(cut, cut, placed, placed.seams, chart, method)
    _solve_into(placed, rotations, translations, chart)
    return Solved(as_motion(placed, rotations, translations), cut, placed, placed.seams, chart, method)


def solve_seam(placed: Placed, index: int, *, chart: Chart = "centred") -> SolvedWindow:
    """Only the window around seam `index` of the timeline, at a cost that does not depend on the length of the clip.

    Raises ParameterError if the timeline has no such seam or nothing to solve there.
    """
    check_chart(chart)
    for cluster in clusters(placed.seams, placed.frames):
        if any(seam.index == index for seam in cluster.seams):
            rotations, translations = target_window(placed, cluster.start, cluster.stop)
            _solve_cluster(placed, cluster, rotations, translations, chart)
            return SolvedWindow(cluster.start, cluster.stop, rotations, translations)
    raise ParameterError(
        "Expected a seam between segments that has something to solve "
        f"(0 to {len(placed.timeline.seams) - 1}), got {index}."
    )


def _check(chart: str, method: str) -> None:
    check_chart(chart)
    if method not in METHODS:
        raise ParameterError(f"Expected a method out of {', '.join(METHODS)}, got {method!r}.")


def _solve_into(placed: Placed, rotations: Array, translations: Array, chart: Chart) -> None:
    for cluster in clusters(placed.seams, placed.frames):
        here = slice(cluster.start, cluster.stop)
        _solve_cluster(placed, cluster, rotations[here], translations[here], chart)


def _solve_cluster(placed: Placed, cluster: Cluster, rotations: Array, translations: Array, chart: Chart) -> None:
    """Turn a window of the hard cut, (n, J, 4) and (n, J, 3), into the result in place."""
    around = [straddling(placed, seam) for seam in cluster.seams]
    poses = np.stack([seam.rotations for seam in around])
    way = way_to_hips(placed) if chart == "centred" else ()
    hips_to_world(way, rotations)
    hips_to_world(way, poses)
    charted = chart_window(placed, cluster, rotations, poses, chart)
    curves = shared_curves(cluster)
    overturned = solve_rotations(charted, cluster, curves, rotations)
    if len(overturned):
        target = target_window(placed, cluster.start, cluster.stop)[0]
        hips_to_world(way, target)
        rotations[:, overturned] = mid_tangent(target[:, overturned], poses[:, :, overturned], cluster, curves)
    if way:
        above = chain_rotation(way[:-1], rotations)
        rotations[:, way[-1]] = quat_multiply(quat_conjugate(above), rotations[:, way[-1]])
    solve_translations(placed.carrier, cluster, curves, translations, around)


def way_to_hips(placed: Placed) -> tuple[int, ...]:
    """The joints from the carrier down to the hips; empty where they are one.

    Hips below a carrier are solved as the world sees them: told in a root that takes the placement's yaw, a turn of
    almost π could be closed one way by the root and the other way by the hips, and the body would spin.
    """
    chain = placed.skeleton.chain(hips_joint(placed.skeleton))
    way = chain[chain.index(placed.carrier) :] if placed.carrier in chain else ()
    return way if len(way) > 1 else ()


def hips_to_world(way: Sequence[int], rotations: Array) -> None:
    """Tell the hips' rotation in the world, in place; way : from :func:`way_to_hips`; rotations : (..., J, 4)."""
    if way:
        rotations[..., way[-1], :] = chain_rotation(way, rotations)


def chart_window(placed: Placed, cluster: Cluster, rotations: Array, poses: Array, chart: Chart) -> Charted:
    """A cluster's window as vectors. rotations : (n, J, 4); poses : (S, 4, J, 4) straddling the seams; carrier in
    the world.
    """
    if chart == "centred":
        return centred_chart(rotations, poses, cluster.local_frames)
    rest = placed.skeleton.rest.copy()
    rest[placed.carrier] = quat_multiply(_frame_above(placed)[1], rest[placed.carrier])
    return principal_chart(poses, rest)


def solve_translations(
    carrier: int, cluster: Cluster, curves: Array | None, translations: Array, around: Sequence[Straddling]
) -> None:
    """Height and joints' translations as positions (Eq. 7), the ground path by displacements (Eq. 16), in place: (n,
    J, 3) m.
    """
    gaps = np.stack([seam.translations[2:] - seam.translations[:2] for seam in around])
    gaps[..., carrier, GROUND] = 0.0
    if np.any(gaps):
        joints = np.flatnonzero(np.any(gaps, axis=(0, 1, 3)))
        offsets = gaps[:, :, joints].reshape(2 * len(around), -1)
        change = correction(cluster, offsets) if curves is None else curves @ offsets
        translations[:, joints] += change.reshape(len(translations), len(joints), 3)
    residuals = np.concatenate([displacement_residuals(seam.left_path, seam.right_path) for seam in around])
    translations[:, carrier, GROUND] += displacement_correction(cluster, residuals)


def _frame_above(placed: Placed) -> tuple[Array, Array]:
    """World position (3,) and rotation (4,) of the frame the carrier hangs in; the same in every frame of the
    result.
    """
    first = placed.sources[next(iter(placed.sources))]
    position, rotation = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])
    for joint in placed.skeleton.chain(placed.carrier)[:-1]:
        position = position + quat_rotate(rotation, first.translations[0, joint])
        rotation = quat_multiply(rotation, first.rotations[0, joint])
    return position, rotation


def as_motion(placed: Placed, rotations: Array, translations: Array) -> Motion:
    """The result with its carrier told in its parent's frame again; the joints above it stand as in the original."""
    carrier = placed.carrier
    if carrier != 0:
        position, rotation = _frame_above(placed)
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
    motion = Motion(placed.skeleton, translations, rotations, placed.timeline.fps, name=name)
    return motion if placed.writes == carrier else lift_travel(motion, placed.writes, carrier)


def stitch_rotvecs(pieces: Sequence[Array], stiffness: float | Sequence[float], *, chart: Chart = "centred") -> Array:
    """Join bare rotation vectors: the solver's own door, for research on the vectors themselves.

    pieces : (n_i + 2, J, 3) rad each, n_i frames with the source's own neighbour at both ends
    stiffness : λ for all seams, or one for each

    Returns quaternions (Σ n_i, J, 4). In the ``principal`` chart the vectors are taken as they are, branch and all;
    ``centred`` looks at the rotations they stand for, so that ``r`` and ``(2π − θ)(−u)`` give the same result (Eq.
    13).

    Raises ParameterError for a stiffness out of its domain, a wrong number of them, or pieces without frames.
    """
    check_chart(chart)
    if not pieces or any(np.ndim(piece) != 3 or len(piece) < 3 for piece in pieces):
        raise ParameterError("Expected pieces of shape (n + 2, J, 3) with n ≥ 1, got none or a shorter one.")
    lambdas = _stiffnesses(stiffness, len(pieces) - 1)
    ends = np.cumsum([len(piece) - 2 for piece in pieces])
    vectors = np.concatenate([piece[1:-1] for piece in pieces])
    rotations = rotvec_to_quat(vectors)
    places = [SeamPlace(i, int(ends[i]), value) for i, value in enumerate(lambdas)]
    for cluster in clusters(places, len(vectors)):
        here = slice(cluster.start, cluster.stop)
        around = np.stack([np.stack([*pieces[seam.index][-2:], *pieces[seam.index + 1][:2]]) for seam in cluster.seams])
        if chart == "centred":
            poses = rotvec_to_quat(around)
            charted = centred_chart(rotations[here], poses, cluster.local_frames)
            curves = shared_curves(cluster)
            target = rotations[here].copy()
            joints = solve_rotations(charted, cluster, curves, rotations[here])
            rotations[here, joints] = mid_tangent(target[:, joints], poses[:, :, joints], cluster, curves)
        else:
            gaps = (around[:, 2:] - around[:, :2]).reshape(-1, *vectors.shape[1:])
            rotations[here] = rotvec_to_quat(join(corrected(split(vectors[here]), split(gaps), cluster)))
    return rotations


def _stiffnesses(stiffness: float | Sequence[float], seams: int) -> list[float]:
    values = np.asarray(stiffness, dtype=np.float64)
    if values.ndim and values.shape != (seams,):
        raise ParameterError(f"Expected one stiffness λ, or {seams} (one for each seam), got {values.size}.")
    check_stiffness(values)
    return [float(value) for value in np.broadcast_to(values, (seams,))]
