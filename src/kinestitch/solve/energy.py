"""What seams cost: the least energy E* in rad², known without solving for the motion itself.

A price counts the rotations of all joints from the hips down, unweighted, λ included. What stands above the hips only
carries them: its own turn is what placement is free to choose.
"""

from __future__ import annotations

import numpy as np

from kinestitch.core.components import join
from kinestitch.core.rotation import Array
from kinestitch.core.skeleton import Skeleton
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.chart import centred_chart, offsets_as_solved
from kinestitch.solve.laplacian import solve_bands
from kinestitch.solve.placed import Placed, straddling, target_window
from kinestitch.solve.seam import Cluster, SeamPlace, cluster_rows, clusters, seam_energy
from kinestitch.solve.window import chart_window, hips_to_world, parts, way_to_hips


def priced_joints(skeleton: Skeleton) -> tuple[int, ...]:
    """The joints whose rotations a price counts: all but those above the hips."""
    above = skeleton.chain(hips_joint(skeleton))[:-1]
    return tuple(joint for joint in range(skeleton.joint_count) if joint not in above)


def seam_price(placed: Placed, seam: SeamPlace) -> float:
    """E* in rad² of one seam as if it were the only one, charted around itself (Eq. 10)."""
    poses = straddling(placed, seam).rotations
    hips_to_world(way_to_hips(placed), poses)
    offsets = centred_chart(poses[[0, 3]], poses[None], [1]).offsets
    return sum(
        seam_energy(part.seams[0], placed.frames, join(offsets[:, :, joints]).reshape(2, -1))
        for joints, part in _priced_parts(placed, Cluster(0, placed.frames, (seam,)))
    )


def _priced_parts(placed: Placed, cluster: Cluster) -> list[tuple[list[int], Cluster]]:
    """The priced joints by the λ of their seams."""
    priced = set(priced_joints(placed.skeleton))
    everyone = np.arange(placed.skeleton.joint_count)
    return [([j for j in everyone[joints].tolist() if j in priced], part) for joints, part in parts(placed, cluster)]


def joint_price(placed: Placed) -> float:
    """E* in rad² of all seams together: what neighbours share and where the clip ends counts (Eq. 17)."""
    return float(joint_shares(placed).sum())


def joint_shares(placed: Placed) -> Array:
    """What each joint has of :func:`joint_price`: (J,) rad², nothing above the hips.

    Joints whose gap a cluster's chart would tell the long way round are told as they are solved, one seam at a time.
    """
    shares = np.zeros(placed.skeleton.joint_count)
    way = way_to_hips(placed)
    for cluster in clusters(placed.seams, placed.frames):
        rotations, _ = target_window(placed, cluster.start, cluster.stop)
        poses = np.stack([straddling(placed, seam).rotations for seam in cluster.seams])
        hips_to_world(way, rotations)
        hips_to_world(way, poses)
        offsets = join(offsets_as_solved(chart_window(placed, cluster, rotations, poses, "centred"), poses))
        for joints, part in _priced_parts(placed, cluster):
            energies = channel_energies(part, offsets[:, joints].reshape(len(offsets), -1))
            shares[joints] += energies.reshape(-1, 3).sum(axis=1)
    return shares


def cluster_energy(cluster: Cluster, offsets: Array) -> float:
    """The least energy of a cluster's seams solved together, summed over channels; offsets as below (Eq. 17)."""
    return float(channel_energies(cluster, offsets).sum())


def channel_energies(cluster: Cluster, offsets: Array) -> Array:
    """The least energy (C,) of a cluster's seams solved together: ``eᵀ (Λ⁻¹ + LLᵀ)⁻¹ e`` of each channel (Eq. 17).

    offsets : (2S, C) rad or m, rows d_{m−1} and d_m of each seam
    """
    inner = cluster_rows(cluster)[1:-1]
    residual = np.zeros((cluster.frames, offsets.shape[1]))
    for seam, m in enumerate(cluster.local_frames):
        if m > 1:
            residual[m - 1] -= offsets[2 * seam + 1]
        residual[m] += offsets[2 * seam]
    free = inner < 1e-300  # a hard cut's rows are not there
    error = np.where(free[:, None], 0.0, residual[1:-1])
    there = (~free).astype(np.float64)
    bands = np.zeros((3, len(inner)), order="F")
    bands[2] = np.where(free, 1.0, 6.0 + 1.0 / np.where(free, 1.0, inner))
    bands[1, 1:] = -4.0 * there[1:] * there[:-1]
    bands[0, 2:] = there[2:] * there[:-2]
    return np.asarray(np.einsum("tc,tc->c", error, solve_bands(bands, error.copy(order="F"))))
