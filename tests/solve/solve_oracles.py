"""The method once more, slowly: dense least squares over whole clips, frame by frame and joint by joint.

Nothing here comes from ``kinestitch.solve``: the rows of L are written out, δ is taken in each source with its own
neighbours, and SciPy turns quaternions into whatever is needed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from scipy.spatial.transform import Rotation

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_continuous, quat_log
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.rig.hips import hips_joint
from kinestitch.testing import random_motion


def laplacian(frames: int) -> np.ndarray:
    """L (F, F), its first and last row zero."""
    out = np.zeros((frames, frames))
    for t in range(1, frames - 1):
        out[t, t - 1 : t + 2] = [1.0, -2.0, 1.0]
    return out


def dense(target: np.ndarray, delta: np.ndarray, stiffness: np.ndarray) -> np.ndarray:
    """argmin ‖R − target‖² + Σ Λ_t ‖(L R)_t − delta_t‖² by ``numpy.linalg.lstsq``; (F, C), stiffness (F,).

    Solved for R − target, since lstsq too loses digits in proportion to what it solves for.
    """
    root = np.sqrt(stiffness)[:, None]
    L = laplacian(len(target))
    left = np.vstack([np.eye(len(target)), root * L])
    right = np.vstack([np.zeros_like(target), root * (delta - L @ target)])
    return target + np.linalg.lstsq(left, right, rcond=None)[0]


def energy(values: np.ndarray, target: np.ndarray, delta: np.ndarray, stiffness: np.ndarray) -> float:
    """What `dense` makes least."""
    bent = laplacian(len(target))[1:-1] @ values - delta[1:-1]
    return float(((values - target) ** 2).sum() + (stiffness[1:-1, None] * bent**2).sum())


def joined(pieces: Sequence[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Target and δ (F, C) of pieces (n_i + 2, C) that carry their own neighbours at both ends."""
    target = np.concatenate([piece[1:-1] for piece in pieces])
    delta = np.concatenate([piece[:-2] - 2 * piece[1:-1] + piece[2:] for piece in pieces])
    delta[[0, -1]] = 0.0
    return target, delta


def reach(stiffness: float) -> float:
    return np.ceil(40 * stiffness**0.25) + 8


def rows_of(frames: int, seams: Sequence[tuple[float, float]], half: float = 0.5) -> np.ndarray:
    """Λ (F,): a seam's own rows, place ± half, have its λ, every other row that of the seam nearest in reaches.

    seams : (place, λ), where place is m − ½ for rows of frames and m − 1 (half 1) for rows of intervals
    """
    out = np.zeros(frames)
    for t in range(1, frames - 1):
        distances = [max(abs(t - place) - half, 0.0) / reach(stiffness) for place, stiffness in seams]
        nearest = min(distances)
        out[t] = max(s for (_, s), d in zip(seams, distances, strict=True) if d <= nearest * (1 + 1e-12) + 1e-15)
    return out


def own(values: np.ndarray, frame: int, *, rotation: bool) -> np.ndarray:
    """A clip's frame, or one beyond its end at constant velocity."""
    if 0 <= frame < len(values):
        return values[frame]
    edge, inner = (
        (values[0], values[min(1, len(values) - 1)]) if frame < 0 else (values[-1], values[max(-2, -len(values))])
    )
    steps = -frame if frame < 0 else frame - len(values) + 1
    if not rotation:
        return edge + steps * (edge - inner)
    step = Rotation.from_quat(inner.reshape(-1, 4).copy()).inv() * Rotation.from_quat(edge.reshape(-1, 4).copy())
    out = Rotation.from_quat(edge.reshape(-1, 4).copy())
    for _ in range(steps):
        out = out * step
    return out.as_quat().reshape(edge.shape)


def _turn(yaw: float) -> Rotation:
    return Rotation.from_rotvec([0.0, yaw, 0.0])


class Piece:
    """One segment with two of its clip's own frames on either side, all of it placed."""

    def __init__(self, motion: Motion, start: int, stop: int) -> None:
        frames = range(start - 2, stop + 2)
        self.rotations = np.stack([own(motion.rotations, f, rotation=True) for f in frames])
        self.translations = np.stack([own(motion.translations, f, rotation=False) for f in frames])

    def place(self, yaw: float, shift: np.ndarray) -> None:
        root = _turn(yaw) * Rotation.from_quat(self.rotations[:, 0].copy())
        self.rotations[:, 0] = root.as_quat()
        self.translations[:, 0] = _turn(yaw).apply(self.translations[:, 0]) + np.array([shift[0], 0.0, shift[1]])


def _world(rotations: np.ndarray, chain: Sequence[int]) -> Rotation:
    out = Rotation.identity(len(rotations))
    for joint in chain:
        out = out * Rotation.from_quat(rotations[:, joint].copy())
    return out


def placed_pieces(timeline: Timeline, clips: Mapping[str, Motion]) -> list[Piece]:
    """The segments, each turned and moved so that it continues the one before; the root carries the travel."""
    pieces = [Piece(clips[s.clip], s.range.start, s.range.stop) for s in timeline.segments]
    skeleton = clips[timeline.segments[0].clip].skeleton
    chain = skeleton.chain(hips_joint(skeleton))
    for a, b in pairwise(pieces):
        left, right = _world(a.rotations[-3:-1], chain), _world(b.rotations[1:3], chain)
        relative = (left * right.inv()).as_quat()
        mean = relative[0] + relative[1] * np.sign(relative[0] @ relative[1])
        yaw = 2 * np.arctan2(mean[1], mean[3])
        b.place(yaw, np.zeros(2))
        b.place(0.0, (a.translations[-3:-1, 0] - b.translations[1:3, 0]).mean(axis=0)[[0, 2]])
    return pieces


def naive_stitch(timeline: Timeline, clips: Mapping[str, Motion], chart: str = "centred") -> Motion:
    """Charts and root from the method's text; all seams' windows must overlap, or there is one."""
    pieces = placed_pieces(timeline, clips)
    starts = np.array(timeline.starts)
    seams = [(starts[i + 1], seam.lambda_at(timeline.fps)) for i, seam in enumerate(timeline.seams)]
    rows = rows_of(timeline.frames, [(m - 0.5, stiffness) for m, stiffness in seams])
    translations = _solved_translations(pieces, rows)
    intervals = rows_of(timeline.frames - 1, [(m - 1.0, stiffness) for m, stiffness in seams], half=1.0)
    translations[:, 0, [0, 2]] = _solved_path([piece.translations[:, 0][:, [0, 2]] for piece in pieces], intervals)
    first = clips[timeline.segments[0].clip]
    joints = range(first.skeleton.joint_count)
    chain = first.skeleton.chain(hips_joint(first.skeleton))
    if chart == "centred":  # hips below the root are solved as the world sees them
        for piece in pieces:
            piece.rotations[:, chain[-1]] = _world(piece.rotations, chain).as_quat()
    rest = first.skeleton.rest if chart == "principal" else [None] * len(joints)
    rotations = np.stack(
        [_solved_joint([piece.rotations[:, j] for piece in pieces], rows, rest[j]) for j in joints], axis=1
    )
    if chart == "centred" and len(chain) > 1:
        local = _world(rotations, chain[:-1]).inv() * Rotation.from_quat(rotations[:, chain[-1]])
        rotations[:, chain[-1]] = local.as_quat()
    return replace(first, translations=translations, rotations=rotations, fps=timeline.fps)


def _solved_translations(pieces: Sequence[Piece], rows: np.ndarray) -> np.ndarray:
    target, delta = joined([piece.translations[1:-1].reshape(len(piece.translations) - 2, -1) for piece in pieces])
    return dense(target, delta, rows).reshape(len(target), -1, 3)


def _solved_path(paths: Sequence[np.ndarray], rows: np.ndarray) -> np.ndarray:
    """Ground path (F, 2) solved on its displacements; a seam's interval is the mean of both sources' own."""
    steps, bends = [], []
    for i, path in enumerate(paths):
        own_steps = np.diff(path, axis=0)  # of intervals −2 … n, where n is the piece's number of frames
        own_bends = np.vstack([np.full((1, 2), np.nan), np.diff(own_steps, n=2, axis=0), np.full((1, 2), np.nan)])
        count = len(path) - 4
        if i:
            steps[-1] = (steps[-1] + own_steps[1]) / 2
            bends[-1] = (bends[-1] + own_bends[1]) / 2
        steps.extend(own_steps[2 : count + 2])
        bends.extend(own_bends[2 : count + 2])
    target, delta = np.array(steps[:-1]), np.array(bends[:-1])
    delta[[0, -1]] = 0.0
    solved = dense(target, delta, rows)
    return paths[0][2] + np.vstack([np.zeros((1, 2)), np.cumsum(solved, axis=0)])


def _solved_joint(paths: Sequence[np.ndarray], rows: np.ndarray, rest: np.ndarray | None) -> np.ndarray:
    if rest is None:
        around = np.concatenate([np.stack([a[-3], a[-2], b[1], b[2]]) for a, b in pairwise(paths)])
        centre = Rotation.from_quat(np.linalg.eigh(around.T @ around)[1][:, -1])
    else:
        centre = Rotation.from_quat(rest.copy())
    vectors = []
    for i, path in enumerate(paths):
        x = (centre.inv() * Rotation.from_quat(path[1:-1].copy())).as_quat()
        if rest is None:
            x = quat_continuous(x)
            ends = ([*x[:2]] if i else []) + ([*x[-2:]] if i < len(paths) - 1 else [])
            vectors.append(quat_log(x if sum(q[3] for q in ends) >= 0 else -x))
        else:
            vectors.append(Rotation.from_quat(x).as_rotvec())
    target, delta = joined(vectors)
    return (centre * Rotation.from_rotvec(dense(target, delta, rows))).as_quat()


def line(
    segments: Sequence[tuple[str, int, int]], clips: Mapping[str, Motion], *seams: Seam, fps: float | None = None
) -> Timeline:
    """A timeline of the named ranges; one seam setting for all, or one for each."""
    infos = tuple(ClipInfo(key, motion.frames, motion.fps) for key, motion in clips.items())
    each = seams if len(seams) == len(segments) - 1 else (seams[0] if seams else Seam(),) * (len(segments) - 1)
    parts = tuple(Segment(key, FrameRange(start, stop)) for key, start, stop in segments)
    return Timeline(infos, parts, tuple(each), fps or infos[0].fps)


def cast(count: int = 3, **options: object) -> dict[str, Motion]:
    """Random motions "a", "b", … of one rig."""
    return {key: random_motion(7 + i, **options) for i, key in enumerate("abcdef"[:count])}  # type: ignore[arg-type]


def reversed_motion(motion: Motion) -> Motion:
    """The same poses in the opposite order."""
    return replace(motion, translations=motion.translations[::-1], rotations=motion.rotations[::-1])
