"""The seam form of a loop: the same two rows, the same curves, wrapped around the cycle.

Far from the clip's ends nothing tells a loop's seam from any other. Its second difference is periodic, so that the
curves of a window longer than the cycle come round again and add up:

    g(t) = Σ_k  g_window(t + kN)                                                                     (Eq. 20)
"""

from __future__ import annotations

import numpy as np

from kinestitch.core.rotation import Array
from kinestitch.solve.seam import Cluster, SeamPlace, cluster_rows, row_curves, seam_curves, seam_reach


def loop_curves(stiffness: float, frames: int) -> Array:
    """The curves g₀, g₁ (N, 2) of the seam between the last and the first frame of a cycle of N frames (Eq. 20).

    The correction of frame t is ``g₀(t) · d_{N−1} + g₁(t) · d_N``: what is b − a just before and just after the seam.
    """
    cluster, reach = _alone(stiffness)
    return _wrapped(seam_curves(cluster), frames, reach)


def loop_interval_curves(stiffness: float, frames: int) -> Array:
    """What residuals in the interval rows N−2, N−1 and N, those around the seam's own interval N−1, do to the N
    intervals of a cycle: (N, 3), each column without a mean, so that the cycle's travel stays (Eq. 20).
    """
    cluster, reach = _alone(stiffness)
    rows = cluster_rows(cluster, intervals=True)
    return _wrapped(row_curves(rows, [reach - 2, reach - 1, reach]), frames, reach)


def _alone(stiffness: float) -> tuple[Cluster, int]:
    """A seam with room on both sides, and the frame that it stands before."""
    reach = seam_reach(stiffness)
    return Cluster(0, 2 * reach, (SeamPlace(0, reach, stiffness),)), reach


def _wrapped(curves: Array, frames: int, middle: int) -> Array:
    """Curves (n, K) summed modulo `frames`; row `middle` comes to stand at 0."""
    out = np.zeros((frames, curves.shape[1]))
    np.add.at(out, (np.arange(len(curves)) - middle) % frames, curves)
    return out
