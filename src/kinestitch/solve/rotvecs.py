"""The solver's own door for bare rotation vectors: research on the vectors themselves, branch and all."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from kinestitch.core.components import join, split
from kinestitch.core.rotation import Array, rotvec_to_quat
from kinestitch.errors import ParameterError
from kinestitch.solve.chart import Chart, centred_chart, check_chart, corrected, mid_tangent, solve_rotations
from kinestitch.solve.laplacian import check_stiffness
from kinestitch.solve.seam import SeamPlace, clusters, shared_curves


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
