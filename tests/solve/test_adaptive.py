"""Automatic seams: the least stiffness that keeps its bounds, for each part of the body by itself."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solve_oracles import cast, dense, laplacian, line, reversed_motion

import kinestitch as ks
from kinestitch.analysis.smoothness import added_acceleration, added_velocity
from kinestitch.core.kinematics import turn_about_up
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_multiply, rotvec_to_quat
from kinestitch.edit.timeline import DEFAULT_SMOOTHING, Seam, Timeline
from kinestitch.errors import ParameterError
from kinestitch.rig.groups import joint_groups
from kinestitch.solve import window
from kinestitch.solve.adaptive import LEAST, MOST, UNSEEN, Share, with_automatic
from kinestitch.solve.chart import mid_tangent
from kinestitch.solve.energy import joint_price, seam_price
from kinestitch.solve.placed import JointGroup, Placed, place_timeline, straddling
from kinestitch.solve.sources import own_strength
from kinestitch.solve.stitch import solve_placed, solve_timeline, stitch
from kinestitch.testing import assert_motion_close, random_motion

AUTO = Seam(automatic=True)
SEEDS = st.integers(0, 2**16)
ALONE = {"velocity": np.inf, "path": np.inf}


def times(placed: Placed) -> np.ndarray:
    """Smoothing times in s: a row for each group, or for the whole body, a column for each seam."""
    rows = [group.stiffness for group in placed.groups] or [[seam.stiffness for seam in placed.seams]]
    return np.array(rows) ** 0.25 / placed.timeline.fps


def chosen(parts: list[tuple[str, int, int]], clips: dict[str, Motion], *seams: Seam, **options: object) -> Placed:
    return with_automatic(place_timeline(line(parts, clips, *(seams or (AUTO,))), clips), **options)  # type: ignore[arg-type]


def still(angle: float, frames: int = 150) -> Motion:
    """A body at rest with one joint turned by an angle in rad."""
    motion = random_motion(1, joints=4, frames=2)
    rotations = np.repeat(motion.rotations[:1], frames, axis=0)
    rotations[:, 2] = quat_multiply(rotations[:, 2], quat_about_axis(0, angle))
    translations = np.repeat(motion.translations[:1], frames, axis=0)
    return replace(motion, rotations=rotations, translations=translations)


def walk_and_kick() -> tuple[Timeline, dict[str, Motion]]:
    clips = {name: ks.sample(name) for name in ("walk", "kick")}
    return ks.replace(ks.timeline(clips, "walk"), 84, 130, "kick", 30, 112, seam=AUTO), clips


@pytest.mark.parametrize("angle", [0.05, 0.3, 1.0])
@pytest.mark.parametrize("share", [0.5, 2.0])
def test_between_two_still_poses_it_adds_its_share_exactly(angle: float, share: float):
    clips = {"a": still(0.0), "b": still(angle)}
    placed = chosen([("a", 0, 150), ("b", 0, 150)], clips, share=Share(share, **ALONE))
    stiffness, fps = placed.seams[0].stiffness, placed.timeline.fps
    e = np.zeros((300, 1))
    e[149], e[150] = -angle, angle

    def peak(value: float) -> float:
        c = dense(np.zeros_like(e), e, np.full(300, value))
        return float(np.abs(laplacian(300) @ c - e).max()) * fps**2

    bound = share * UNSEEN.acceleration
    assert LEAST * 1.1 < stiffness**0.25 / fps < MOST * 0.97
    assert (1 - 2e-3) * bound <= peak(stiffness) <= bound * (1 + 1e-6)
    assert peak(stiffness * 0.99) > bound


@given(SEEDS, st.floats(0.05, 1.0))
@settings(max_examples=25)
def test_what_the_result_shows_stays_under_the_share(seed: int, share: float):
    clips = {key: random_motion(seed + k, joints=5, frames=120, bend=0.1) for k, key in enumerate("ab")}
    placed = chosen([("a", 0, 70), ("b", 30, 120)], clips, share=Share(share, **ALONE))
    (seam,) = placed.seams
    found = added_acceleration(solve_placed(placed), placed, seam, round(placed.timeline.fps))
    assert found.own_body == pytest.approx(own_strength(placed, seam).acceleration, rel=1e-9)
    if times(placed).max() < 0.8 * MOST:  # else it may be out of reach
        assert found.peak <= share * 1.02  # bent charts add something on the group


def test_every_bound_counts():
    line, clips = walk_and_kick()
    placed = place_timeline(line, clips)
    loose = times(with_automatic(placed, Share(2.0, np.inf, np.inf)))
    for tight in (Share(0.02, np.inf, np.inf), Share(2.0, 0.2, np.inf), Share(2.0, np.inf, 0.3)):
        found = times(with_automatic(placed, tight))
        assert (found >= loose * (1 - 1e-3)).all()
        assert (found > loose * 1.2).any()
    path = times(with_automatic(placed, Share(2.0, np.inf, 0.3)))
    np.testing.assert_array_equal(path[1:], loose[1:])  # the trunk carries the path, limbs do not
    slow = solve_placed(with_automatic(placed, Share(2.0, 0.5, np.inf)))
    reach = round(slow.fps)
    assert all(added_velocity(slow, placed, seam, reach).peak <= 0.5 for seam in placed.seams)


def test_a_bound_that_nothing_keeps_is_met_as_nearly_as_it_can():
    placed = place_timeline(*walk_and_kick())
    found = times(with_automatic(placed, Share(1e-6, np.inf, np.inf)))
    assert (found > 0.8 * found.max()).all()
    assert found.max() <= MOST


@pytest.mark.parametrize("grouped", [True, False])
def test_nothing_to_close_takes_the_least_time(grouped: bool):
    clips = {"a": ks.sample("walk"), "b": replace(ks.sample("walk"), name="b")}
    placed = chosen([("a", 0, 70), ("b", 70, 150)], clips, grouped=grouped)
    np.testing.assert_allclose(times(placed), LEAST, rtol=1e-12)


@given(SEEDS, st.integers(1, 12), st.integers(1, 40), st.integers(1, 12))
@settings(max_examples=25)
def test_the_bounds_on_time_are_kept(seed: int, first: int, middle: int, last: int):
    clips = {key: random_motion(seed + k, joints=3, frames=60) for k, key in enumerate("abc")}
    placed = chosen([("a", 5, 5 + first), ("b", 3, 3 + middle), ("c", 9, 9 + last)], clips)
    found, fps = times(placed), placed.timeline.fps
    assert (found >= LEAST * (1 - 1e-12)).all()
    assert (found <= max(DEFAULT_SMOOTHING, middle / 2 / 4.2 / fps) * (1 + 1e-12)).all()
    assert np.isfinite(solve_placed(placed).rotations).all()


def test_a_seam_alone_may_take_more_than_one_with_a_neighbour():
    clips = {"a": still(0.0, 60), "b": still(2.0, 60)}
    alone = chosen([("a", 0, 60), ("b", 0, 60)], clips)
    near = chosen([("a", 0, 60), ("b", 0, 10), ("a", 0, 60)], clips)
    assert times(alone).max() > 3 * DEFAULT_SMOOTHING
    assert 0.9 * DEFAULT_SMOOTHING < times(near).min() <= times(near).max() <= DEFAULT_SMOOTHING


def test_time_may_run_backwards():
    line_, clips = walk_and_kick()
    forwards = times(with_automatic(place_timeline(line_, clips)))
    back = {key: reversed_motion(clip) for key, clip in clips.items()}
    parts = [
        (s.clip, clips[s.clip].frames - s.range.stop, clips[s.clip].frames - s.range.start) for s in line_.segments
    ]
    np.testing.assert_allclose(times(chosen(parts[::-1], back))[:, ::-1], forwards, rtol=1e-5)


def test_turning_a_clip_changes_nothing():
    line_, clips = walk_and_kick()
    expected = times(with_automatic(place_timeline(line_, clips)))
    turned = clips | {"kick": turn_about_up(clips["kick"], 1.2)}
    np.testing.assert_allclose(times(with_automatic(place_timeline(line_, turned))), expected, rtol=1e-5)


def test_neither_rest_pose_nor_the_axes_of_a_joint_matter():
    clips = cast(2, frames=80, joints=5)
    parts = [("a", 0, 40), ("b", 20, 80)]
    expected = times(chosen(parts, clips))
    turn = rotvec_to_quat(np.array([0.7, -1.1, 0.4]))
    other = {}
    for key, clip in clips.items():
        rotations, rest = clip.rotations.copy(), clip.skeleton.rest.copy()
        leaf = clip.skeleton.joint_count - 1
        rotations[:, leaf] = quat_multiply(rotations[:, leaf], turn)
        rest[1] = turn
        other[key] = replace(clip, rotations=rotations, skeleton=replace(clip.skeleton, rest=rest))
    np.testing.assert_allclose(times(chosen(parts, other)), expected, rtol=1e-5)


def test_each_part_is_solved_with_its_own_stiffness():
    line_, clips = walk_and_kick()
    placed = with_automatic(place_timeline(line_, clips))
    result = solve_placed(placed)
    assert len({group.stiffness for group in placed.groups}) == len(placed.groups) == 5
    assert [s.stiffness for s in placed.seams] == [
        max(values) for values in zip(*(g.stiffness for g in placed.groups), strict=True)
    ]
    for group in placed.groups:
        seams = tuple(replace(s, stiffness=value) for s, value in zip(placed.seams, group.stiffness, strict=True))
        alone = solve_placed(replace(placed, seams=seams, groups=()))
        joints = list(group.joints)
        assert_motion_close(_part(result, joints), _part(alone, joints), degrees=1e-7, metres=1e-9)


def _part(motion: Motion, joints: list[int]) -> Motion:
    """The rotations of some joints, and all translations where the root is among them; the rest put away."""
    rotations = np.zeros_like(motion.rotations)
    rotations[..., 3] = 1.0
    rotations[:, joints] = motion.rotations[:, joints]
    translations = np.zeros_like(motion.translations)
    if 0 in joints:
        translations[:] = motion.translations
    return replace(motion, rotations=rotations, translations=translations)


@pytest.mark.parametrize("chart", ["centred", "principal"])
def test_parts_of_one_stiffness_are_the_whole(chart: str):
    line_, clips = walk_and_kick()
    placed = with_automatic(place_timeline(line_, clips))
    same = replace(placed, groups=tuple(replace(g, stiffness=(81.0, 17.0)) for g in placed.groups))
    apart = replace(placed, groups=(*same.groups[:-1], replace(same.groups[-1], stiffness=(81.0, 17.0 + 1e-9))))
    seams = tuple(replace(s, stiffness=value) for s, value in zip(placed.seams, (81.0, 17.0), strict=True))
    whole = solve_placed(replace(placed, seams=seams, groups=()), chart=chart)  # type: ignore[arg-type]
    for parts in (same, apart):
        result = solve_placed(replace(parts, seams=seams), chart=chart)  # type: ignore[arg-type]
        assert_motion_close(result, whole, degrees=1e-6, metres=1e-9)


def test_joints_that_turn_all_the_way_round_are_solved_alike_in_parts(monkeypatch: pytest.MonkeyPatch):
    line_, clips = walk_and_kick()
    kick = clips["kick"]
    arm = kick.skeleton.index("mixamorig:LeftForeArm")
    rotations = kick.rotations.copy()
    rotations[:, arm] = quat_multiply(rotations[:, arm], quat_about_axis(0, np.linspace(0, 4 * np.pi, kick.frames)))
    clips["kick"] = replace(kick, rotations=rotations)
    placed = place_timeline(line_, clips)
    seams = tuple(replace(s, stiffness=1e4) for s in placed.seams)
    groups = [JointGroup(name, joints, (1e4, 1e4)) for name, joints in joint_groups(placed.skeleton).items()]
    groups[2] = replace(groups[2], stiffness=(1e4, 1e4 * (1 + 1e-13)))
    turned = []
    monkeypatch.setattr(window, "mid_tangent", lambda *given: turned.append(given) or mid_tangent(*given))
    whole = solve_placed(replace(placed, seams=seams))
    assert len(turned) == 1
    assert_motion_close(
        solve_placed(replace(placed, seams=seams, groups=tuple(groups))), whole, degrees=1e-6, metres=1e-9
    )
    assert len(turned) == 2


def test_seams_that_are_told_stay_as_they_are():
    line_, clips = walk_and_kick()
    mixed = replace(line_, seams=(Seam(stiffness=7.0), AUTO))
    placed = place_timeline(mixed, clips)
    assert [s.stiffness for s in placed.seams] == [7.0, Seam().lambda_at(mixed.fps)]
    found = with_automatic(placed)
    assert all(group.stiffness[0] == 7.0 for group in found.groups)
    assert found.seams[0].stiffness == 7.0
    told = place_timeline(replace(mixed, seams=(Seam(),) * 2), clips)
    assert with_automatic(told) is told


def test_the_front_door_solves_them():
    line_, clips = walk_and_kick()
    solved = solve_timeline(line_, clips)
    assert_motion_close(solved.motion, stitch(line_, clips), degrees=1e-9, metres=0)
    assert solved.placed.groups == with_automatic(place_timeline(line_, clips)).groups
    assert tuple(solved.seams) == tuple(solved.placed.seams)


def test_the_price_of_parts_is_the_energy_they_leave():
    clips = {name: ks.sample(name) for name in ("walk", "kick")}
    placed = chosen([("walk", 0, 84), ("kick", 30, 112)], clips)
    (seam,) = placed.seams
    poses = straddling(placed, seam).rotations
    base = np.linalg.eigh(np.einsum("kji,kjl->jil", poses, poses))[1][:, :, -1]
    vectors = [_vectors(base, pose) for pose in poses]
    first, second = (b - a for a, b in zip(vectors[:2], vectors[2:], strict=True))
    total = 0.0
    for group in placed.groups:
        e = np.zeros((placed.frames, 3 * len(group.joints)))
        joints = list(group.joints)
        e[seam.frame - 1], e[seam.frame] = -second[joints].ravel(), first[joints].ravel()
        (stiffness,) = group.stiffness
        c = dense(np.zeros_like(e), e, np.full(placed.frames, stiffness))
        left = laplacian(placed.frames) @ c - e
        total += float((c**2).sum() + stiffness * (left[1:-1] ** 2).sum())
    assert seam_price(placed, seam) == pytest.approx(total, rel=1e-6)
    assert joint_price(placed) == pytest.approx(total, rel=1e-6)


def _vectors(base: np.ndarray, pose: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    return (Rotation.from_quat(base).inv() * Rotation.from_quat(pose)).as_rotvec()


@pytest.mark.parametrize("wrong", [0.0, -1.0, float("nan")])
@pytest.mark.parametrize("name", ["acceleration", "velocity", "path"])
def test_a_share_must_be_above_0(name: str, wrong: float):
    with pytest.raises(ParameterError, match=f"share of {name} above 0, got"):
        Share(**{name: wrong})


def test_a_rig_of_unknown_parts_is_solved_as_one():
    clips = cast(2, frames=60)
    assert len(joint_groups(clips["a"].skeleton)) == 1
    assert chosen([("a", 0, 30), ("b", 10, 60)], clips).groups == ()
