"""For tests of code that uses kinestitch: one checker, one comparison, and Hypothesis strategies."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance
from kinestitch.core.skeleton import Skeleton, first_difference

if TYPE_CHECKING:
    from hypothesis.strategies import SearchStrategy


def check_motion(motion: Motion) -> None:
    """Build the motion and its skeleton anew from their parts, so that every check of their constructors runs."""
    skeleton = motion.skeleton
    again = Skeleton(skeleton.names, skeleton.parents, skeleton.offsets, skeleton.rest, skeleton.tips)
    Motion(again, motion.translations, motion.rotations, motion.fps, motion.name)
    assert not motion.rotations.flags.writeable
    assert not motion.translations.flags.writeable


def assert_motion_close(
    actual: Motion, expected: Motion, *, degrees: float = 1e-6, metres: float = 1e-9, world: bool = False
) -> None:
    """Fail, naming the worst frame and joint, unless both motions show the same joints, frames, rate and poses.

    degrees, metres : tolerance of local rotations and translations (of world positions only where `world` is set, for
    motions told in different joint axes)
    """
    difference = first_difference(actual.skeleton.names, expected.skeleton.names)
    assert difference is None, f"joint {difference}: {actual.skeleton.names} and {expected.skeleton.names}"
    assert actual.skeleton.parents == expected.skeleton.parents
    assert actual.frames == expected.frames, f"{actual.frames} frames, expected {expected.frames}"
    assert abs(actual.fps - expected.fps) < 1e-3, f"{actual.fps} fps, expected {expected.fps}"
    if world:
        gap = np.linalg.norm(world_pose(actual).positions - world_pose(expected).positions, axis=-1)
        _assert_below(gap, metres, "m", actual)
        return
    _assert_below(np.degrees(quat_distance(actual.rotations, expected.rotations)), degrees, "°", actual)
    _assert_below(np.linalg.norm(actual.translations - expected.translations, axis=-1), metres, "m", actual)


def _assert_below(gap: np.ndarray, bound: float, unit: str, motion: Motion) -> None:
    frame, joint = np.unravel_index(int(np.argmax(gap)), gap.shape)
    worst = gap[frame, joint]
    assert worst <= bound, f"{worst:.3g} {unit} > {bound:.3g} {unit} at frame {frame}, {motion.skeleton.names[joint]!r}"


def quaternions(kind: str = "any") -> SearchStrategy[np.ndarray]:
    """Strategy of unit quaternions (4,): ``uniform``, ``near_identity``, ``near_pi``, ``exact`` (identity or π),
    ``any``.
    """
    from hypothesis import strategies as st

    from kinestitch.core.rotation import quat_normalize, rotvec_to_quat

    unit = st.integers(0, 2**32 - 1).map(np.random.default_rng)

    def axis_angle(rng: np.random.Generator, angle: float) -> np.ndarray:
        axis = rng.normal(size=3)
        return rotvec_to_quat(axis / np.linalg.norm(axis) * angle)

    kinds: dict[str, SearchStrategy[Any]] = {
        "uniform": unit.map(lambda rng: quat_normalize(rng.normal(size=4))),
        "near_identity": unit.map(lambda rng: axis_angle(rng, 10.0 ** rng.uniform(-14, -2))),
        "near_pi": unit.map(lambda rng: axis_angle(rng, np.pi - 10.0 ** rng.uniform(-14, -2))),
        "exact": unit.map(lambda rng: axis_angle(rng, rng.choice([0.0, np.pi]))),
    }
    return st.one_of(*kinds.values()) if kind == "any" else kinds[kind]


def motions(*, joints: int = 4, frames: int = 40, fps: float = 30.0, bend: float = 0.6) -> SearchStrategy[Motion]:
    """Strategy of smooth random motions of one random chain-and-branch skeleton whose rest pose is random too.

    bend : rad, size of the joints' slow swings; about π and above the rotations wander over the whole group
    """
    from hypothesis import strategies as st

    return st.integers(0, 2**32 - 1).map(
        lambda seed: random_motion(seed, joints=joints, frames=frames, fps=fps, bend=bend)
    )


def random_motion(
    seed: int, *, joints: int = 4, frames: int = 40, fps: float = 30.0, bend: float = 0.6, skeleton_seed: int = 0
) -> Motion:
    """A smooth random motion; motions of one `skeleton_seed` and joint count share their skeleton."""
    from kinestitch.core.rotation import quat_multiply, quat_normalize, rotvec_to_quat

    rig = np.random.default_rng(skeleton_seed)
    rng = np.random.default_rng(seed)
    parents = tuple(-1 if j == 0 else int(rig.integers(max(0, j - 2), j)) for j in range(joints))
    offsets = rig.normal(scale=0.2, size=(joints, 3))
    rest = quat_normalize(rig.normal(size=(joints, 4)))
    skeleton = Skeleton(tuple(f"Joint{j}" for j in range(joints)), parents, offsets, rest)
    time = np.arange(frames)[:, None, None] / fps
    waves = np.zeros((frames, joints, 3))
    for _ in range(3):
        phase = 2 * np.pi * rng.uniform(0.2, 1.5) * time + rng.uniform(0, 6.28, (1, joints, 3))
        waves += rng.normal(size=(1, joints, 3)) * np.sin(phase)
    base = quat_normalize(rng.normal(size=(joints, 4)) * min(bend, 1.0) + np.array([0, 0, 0, 1.0]))
    rotations = quat_normalize(quat_multiply(quat_multiply(rest, base), rotvec_to_quat(bend * waves / 2)))
    translations = np.broadcast_to(offsets, (frames, joints, 3)).copy()
    translations[:, 0] += np.cumsum(rng.normal(size=3) * 0.01 + 0.005 * waves[:, 0], axis=0)
    return Motion(skeleton, translations, rotations, fps, name=f"random {seed}")
