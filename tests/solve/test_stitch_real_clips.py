"""Walk, kick, walk: the body goes on from where it is, in the direction it had."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from kinestitch.core.kinematics import world_pose
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance
from kinestitch.edit.operations import replace
from kinestitch.edit.timeline import Seam, timeline
from kinestitch.rig.hips import hips_joint
from kinestitch.solve.seam import seam_reach
from kinestitch.solve.stitch import solve_timeline

Reader = Callable[[str], Motion]


def hips_path(motion: Motion) -> np.ndarray:
    return world_pose(motion).positions[:, hips_joint(motion.skeleton)]


def largest_step(path: np.ndarray) -> float:
    return float(np.linalg.norm(np.diff(path, axis=0), axis=1).max())


def facing(motion: Motion, start: int, stop: int) -> np.ndarray:
    """Mean direction on the ground (2,) in which the hips look, from the line between the legs."""
    rig = motion.skeleton
    pose = world_pose(motion).positions[start:stop]
    across = pose[:, rig.index("mixamorig:LeftUpLeg")] - pose[:, rig.index("mixamorig:RightUpLeg")]
    ahead = np.cross(across, [0.0, 1.0, 0.0]).mean(axis=0)[[0, 2]]
    return ahead / np.linalg.norm(ahead)


@pytest.mark.parametrize("smoothing", [0.05, 0.1, 0.2])
@pytest.mark.parametrize(("start", "stop", "first", "last"), [(20, 40, 10, 120), (45, 60, 30, 90), (70, 75, 0, 130)])
def test_walk_kick_walk(real_clip: Reader, smoothing: float, start: int, stop: int, first: int, last: int):
    walk, kick = (real_clip(f"mixamo_xbot_60fps/{name}.fbx") for name in ("Walking", "Kicking"))
    clips = {"walk": walk, "kick": kick}
    edited = replace(timeline(clips, "walk"), start, stop, "kick", first, last, seam=Seam(smoothing=smoothing))
    solved = solve_timeline(edited, clips)
    path = hips_path(solved.motion)
    own = max(largest_step(hips_path(clip)) for clip in clips.values())
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    for seam in solved.seams:
        assert steps[seam.frame - 1] <= 1.1 * own
    assert steps.max() <= 1.15 * own

    # No snap to the origin: the walk goes on from where the kick ended, as far as it went in its own clip.
    resumed = start + last - first
    rest = np.linalg.norm((path[-1] - path[resumed])[[0, 2]])
    walked = hips_path(walk)
    assert rest == pytest.approx(np.linalg.norm((walked[-1] - walked[stop])[[0, 2]]), abs=0.05)

    # The heading is kept: the kick turns to where the walk looked, and the walk goes on as the kick ended.
    for before, after in (
        (slice(start - 3, start), slice(start, start + 3)),
        (slice(resumed - 3, resumed), slice(resumed, resumed + 3)),
    ):
        looks = [facing(solved.cut, part.start, part.stop) for part in (before, after)]
        assert looks[0] @ looks[1] > np.cos(np.radians(15))


def test_frames_out_of_reach_are_the_walks_own(real_clip: Reader):
    walk, kick = (real_clip(f"mixamo_xbot_60fps/{name}.fbx") for name in ("Walking", "Kicking"))
    clips = {"walk": walk, "kick": kick}
    solved = solve_timeline(replace(timeline(clips, "walk"), 60, 70, "kick", 0, 130, seam=Seam(stiffness=1e-6)), clips)
    reach = seam_reach(1e-6)
    assert reach < 12
    np.testing.assert_array_equal(solved.motion.rotations[: 60 - reach], walk.rotations[: 60 - reach])
    np.testing.assert_array_equal(solved.motion.translations[: 60 - reach], walk.translations[: 60 - reach])
    inner = slice(60 + reach, 190 - reach)
    np.testing.assert_array_equal(solved.motion.rotations[inner, 1:], kick.rotations[reach : 130 - reach, 1:])


@pytest.mark.parametrize("names", [("RM", "NoRM"), ("NoRM", "RM"), ("RM", "RM"), ("NoRM", "NoRM")])
def test_root_motion_and_in_place_clips_of_one_rig(real_clip: Reader, names: tuple[str, str]):
    files = {"RM": "MCU_am_OrcHammer_Loco_Walk_Fwd.FBX", "NoRM": "MCU_am_OrcHammer_Loco_Walk_Fwd_NoRM.FBX"}
    clips = {key: real_clip(f"ue_mannequin/{files[name]}") for key, name in zip("ab", names, strict=True)}
    solved = solve_timeline(replace(timeline(clips, "a"), 10, 20, "b", 5, 28), clips)
    own = max(largest_step(hips_path(clip)) for clip in clips.values())
    assert largest_step(hips_path(solved.motion)) < 1.15 * own
    travel = np.ptp(solved.motion.translations[:, 0], axis=0).max()
    assert travel > 0.5 if names[0] == "RM" else travel == 0.0


def test_limbs_that_rest_near_pi_do_not_spin(real_clip: Reader):
    names = ("walk_normal_001", "punch_normal_001", "kick_normal_001", "run_normal_001", "slash_normal_001")
    clips = {name: real_clip(f"bandai/dataset-1_{name}.bvh") for name in names}
    own = {key: steps_of(clip) for key, clip in clips.items()}
    spins = {"centred": 0, "principal": 0}
    rng = np.random.default_rng(3)
    for _ in range(20):
        first, second = rng.choice(names, 2, replace=False)
        start, into = (int(rng.integers(8, clips[key].frames - 8)) for key in (first, second))
        edited = replace(timeline(clips, first), start, clips[first].frames, second, into)
        for chart in spins:
            solved = solve_timeline(edited, clips, chart=chart)  # type: ignore[arg-type]
            gap = quat_distance(solved.cut.rotations[start - 1], solved.cut.rotations[start])
            allowed = 2 * np.maximum(own[first], own[second]) + 0.2 * gap + np.radians(3)
            spins[chart] += int((steps_of(solved.motion) > allowed).sum())
    assert spins["centred"] == 0
    assert spins["principal"] > 0


def steps_of(motion: Motion) -> np.ndarray:
    """Each joint's largest turn from frame to frame, in rad."""
    return quat_distance(motion.rotations[1:], motion.rotations[:-1]).max(axis=0)
