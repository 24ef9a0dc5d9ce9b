"""How near a filled gap comes to what was really there: the three measures of the LAFAN1 benchmark.

Source: F. G. Harvey et al., *Robust Motion In-Betweening* (SIGGRAPH 2020), and A. Gopalakrishnan et al., *A Neural
Temporal Model for Human Motion Prediction* (CVPR 2019) for the power spectra. Numbers compare only between the same
skeleton, rate, gap length and, for positions, normalisation.
"""

from __future__ import annotations

import numpy as np

from kinestitch.core.kinematics import WorldPose, world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import Array
from kinestitch.errors import SkeletonMismatchError


def global_quaternion_error(motion: Motion, truth: Motion) -> float:
    """L2Q: mean over frames of the norm of ``Q − Q_truth`` over all joints' world quaternions, each pair in one
    hemisphere; no unit. Raises SkeletonMismatchError.
    """
    found, real = _pair(motion, truth)
    sheet = np.where(np.einsum("fji,fji->fj", found.rotations, real.rotations) < 0, -1.0, 1.0)
    apart = sheet[..., None] * found.rotations - real.rotations
    return float(np.sqrt((apart**2).sum(axis=(1, 2))).mean())


def global_position_error(motion: Motion, truth: Motion, mean: Array, deviation: Array) -> float:
    """L2P: mean over frames of the norm over all joints of the difference of normalised world positions; no unit.

    mean, deviation : (J, 3) m, of the data that both are normalised with: ``(p − mean) / deviation``; see
    :func:`normalisation`. Raises SkeletonMismatchError.
    """
    found, real = _pair(motion, truth)
    apart = ((found.positions - mean) - (real.positions - mean)) / deviation
    return float(np.sqrt((apart**2).sum(axis=(1, 2))).mean())


def normalisation(*motions: Motion) -> tuple[Array, Array]:
    """Mean and standard deviation (J, 3) m of all world positions, at least 1e-8 m, to z-score positions with."""
    positions = np.concatenate([world_pose(motion).positions for motion in motions])
    return positions.mean(axis=0), np.maximum(positions.std(axis=0), 1e-8)


def power_spectrum_distance(motion: Motion, truth: Motion) -> float:
    """NPSS: how far the distribution of power over frequencies is from the truth's, over all world quaternions.

    For every feature the earth mover's distance between both normalised spectra, 0 where they are alike; features
    count by the power they have in the truth. As in the benchmark, power is the square of the real part of the Fourier
    coefficients. Raises SkeletonMismatchError.
    """
    found, real = _pair(motion, truth)
    sheet = np.where(np.einsum("fji,fji->fj", found.rotations, real.rotations) < 0, -1.0, 1.0)
    spectra = [
        np.real(np.fft.fft(values.reshape(len(values), -1), axis=0)) ** 2
        for values in (sheet[..., None] * found.rotations, real.rotations)
    ]
    totals = [power.sum(axis=0) for power in spectra]
    below = [np.cumsum(p / np.where(t > 0, t, 1.0), axis=0) for p, t in zip(spectra, totals, strict=True)]
    moved = np.abs(below[0] - below[1]).sum(axis=0)
    return float(np.average(moved, weights=totals[1]))


def _pair(motion: Motion, truth: Motion) -> tuple[WorldPose, WorldPose]:
    if (motion.frames, motion.skeleton.names) != (truth.frames, truth.skeleton.names):
        raise SkeletonMismatchError(
            f"Expected {truth.frames} frames of the truth's {truth.skeleton.joint_count} joints, got {motion.frames} "
            f"frames of {motion.skeleton.joint_count} joints. Cut both to the gap and match their rigs first."
        )
    return world_pose(motion), world_pose(truth)
