"""One window of a placed timeline, from the hard cut to the result: charts, curves, the path on the ground."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from kinestitch.core.rotation import Array, quat_conjugate, quat_multiply
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.chart import (
    Chart,
    Charted,
    Joints,
    centred_chart,
    mid_tangent,
    principal_chart,
    solve_rotations,
)
from kinestitch.solve.placed import Placed, Straddling, frame_above, straddling, target_window
from kinestitch.solve.root import GROUND, chain_rotation, displacement_residuals
from kinestitch.solve.seam import Cluster, SeamPlace, correction, displacement_correction, shared_curves


def solve_window(placed: Placed, cluster: Cluster, rotations: Array, translations: Array, chart: Chart) -> None:
    """Turn a window of the hard cut, (n, J, 4) and (n, J, 3), into the result in place."""
    around = [straddling(placed, seam) for seam in cluster.seams]
    poses = np.stack([seam.rotations for seam in around])
    way = way_to_hips(placed) if chart == "centred" else ()
    hips_to_world(way, rotations)
    hips_to_world(way, poses)
    charted = chart_window(placed, cluster, rotations, poses, chart)
    for joints, part in parts(placed, cluster):
        curves = shared_curves(part)
        own = rotations if isinstance(joints, slice) else rotations.take(joints, axis=1)  # in C order
        overturned = solve_rotations(charted.of(joints), part, curves, own)
        if not isinstance(joints, slice):
            rotations[:, joints] = own
        if len(overturned):
            overturned = np.arange(rotations.shape[1])[joints][overturned]
            target = target_window(placed, cluster.start, cluster.stop)[0]
            hips_to_world(way, target)
            rotations[:, overturned] = mid_tangent(target[:, overturned], poses[:, :, overturned], part, curves)
        if isinstance(joints, slice) or placed.carrier in joints:
            solve_translations(placed.carrier, part, curves, translations, around)
    if way:
        above = chain_rotation(way[:-1], rotations)
        rotations[:, way[-1]] = quat_multiply(quat_conjugate(above), rotations[:, way[-1]])


def parts(placed: Placed, cluster: Cluster) -> list[tuple[Joints, Cluster]]:
    """The joints of a window by the λ that their seams have, all at once where it is one; each with the cluster that
    has these λ.
    """
    if not placed.groups:
        return [(slice(None), cluster)]
    number = {seam.index: k for k, seam in enumerate(placed.seams)}
    found: dict[tuple[float, ...], list[int]] = {}
    for group in placed.groups:
        found.setdefault(tuple(group.stiffness[number[s.index]] for s in cluster.seams), []).extend(group.joints)
    return [
        (np.sort(joints) if len(found) > 1 else slice(None), replace(cluster, seams=_with(cluster.seams, stiffness)))
        for stiffness, joints in found.items()
    ]


def _with(seams: Sequence[SeamPlace], stiffness: Sequence[float]) -> tuple[SeamPlace, ...]:
    return tuple(replace(seam, stiffness=value) for seam, value in zip(seams, stiffness, strict=True))


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
    rest[placed.carrier] = quat_multiply(frame_above(placed)[1], rest[placed.carrier])
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
