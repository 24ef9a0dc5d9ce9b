"""The rivals: what each of them promises at a seam, and that a seam without a gap is left alone."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from solve_oracles import cast, line

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_distance, quat_log, quat_multiply, quat_rotate
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError
from kinestitch.solve.placed import Placed, place_timeline
from kinestitch.solve.rivals import crossfade, dead_blend, hermite, inertialize
from kinestitch.solve.rivals.offsets import hermite_decay, spring_decay
from kinestitch.solve.stitch import stitch
from kinestitch.testing import assert_motion_close, check_motion

Rival = Callable[[Placed], Motion]

RIVALS: dict[str, Rival] = {
    "crossfade": lambda placed: crossfade(placed, 12),
    "crossfade, eased": lambda placed: crossfade(placed, 12, eased=True),
    "inertialize": lambda placed: inertialize(placed, 0.05),
    "dead_blend": lambda placed: dead_blend(placed, 12),
    "dead_blend, one half-life": lambda placed: dead_blend(placed, 12, halflife=0.1),
    "hermite": lambda placed: hermite(placed, 12),
    "hermite, both sides": lambda placed: hermite(placed, 12, sides="both"),
    "quintic": lambda placed: hermite(placed, 12, degree=5),
}
ONE_SIDED = [name for name in RIVALS if name not in ("crossfade", "crossfade, eased", "hermite, both sides")]
FPS = 30.0
RIG = Skeleton(("Hips", "Arm"), (-1, 0), [[0, 1, 0], [0, 0.3, 0]])


def arm(angles: np.ndarray) -> Motion:
    """A body that stands still and turns its arm about X."""
    rotations = np.zeros((len(angles), 2, 4))
    rotations[:, 0] = [0, 0, 0, 1]
    rotations[:, 1] = quat_about_axis(0, angles)
    return Motion(RIG, np.broadcast_to(RIG.offsets, (len(angles), 2, 3)), rotations, FPS)


def arms(left: np.ndarray, right: np.ndarray, cut: int = 40) -> Placed:
    clips = {"a": arm(left), "b": arm(right)}
    return place_timeline(line([("a", 0, cut), ("b", cut, len(right))], clips), clips)


def angles(motion: Motion) -> np.ndarray:
    return quat_log(motion.rotations[:, 1])[:, 0]


def three() -> Placed:
    clips = cast(3, frames=200, joints=6)
    return place_timeline(line([("a", 0, 80), ("b", 50, 150), ("c", 20, 100)], clips), clips)


@pytest.mark.parametrize("rival", RIVALS.values(), ids=RIVALS)
def test_a_valid_motion_of_the_same_length(rival: Rival):
    placed = three()
    found = rival(placed)
    check_motion(found)
    assert found.frames == placed.frames


@pytest.mark.parametrize("rival", RIVALS.values(), ids=RIVALS)
def test_no_seam_no_change(rival: Rival):
    clips = cast(1, frames=90)
    timeline = line([("a", 0, 40), ("a", 40, 90)], clips)
    assert_motion_close(rival(place_timeline(timeline, clips)), clips["a"])


@pytest.mark.parametrize("rival", [rival for name, rival in RIVALS.items() if "dead" not in name])
def test_a_seam_without_a_gap_changes_nothing(rival: Rival):
    clip = cast(1, frames=90)["a"]
    clips = {"a": clip, "b": replace(clip, name="the same")}
    timeline = line([("a", 0, 40), ("b", 40, 90)], clips)
    assert_motion_close(rival(place_timeline(timeline, clips)), clip)


def test_dead_blending_without_a_gap_keeps_still_and_steady_movements_only_where_nothing_moves():
    still = np.full(90, 0.7)
    np.testing.assert_allclose(angles(dead_blend(arms(still, still), 12)), 0.7, atol=1e-12)
    steady = 0.01 * np.arange(90)
    found = angles(dead_blend(arms(steady, steady), 12, halflife=1e9))
    np.testing.assert_allclose(found, steady, atol=1e-9)


@pytest.mark.parametrize("rival", RIVALS.values(), ids=RIVALS)
def test_frames_outside_the_window_are_the_sources(rival: Rival):
    placed = three()
    cut, found = stitch(placed.timeline, placed.sources, method="cut"), rival(placed)
    touched = np.zeros(cut.frames, dtype=bool)
    reach = 40 if rival is RIVALS["inertialize"] else 12
    for seam in placed.seams:
        touched[seam.frame - 12 : seam.frame + reach] = True
    np.testing.assert_array_equal(found.rotations[~touched], cut.rotations[~touched])
    np.testing.assert_array_equal(found.translations[~touched], cut.translations[~touched])
    assert quat_distance(found.rotations[touched], cut.rotations[touched]).max() > 0.1


@pytest.mark.parametrize("name", ONE_SIDED)
def test_a_one_sided_rival_leaves_the_left_source_alone(name: str):
    placed = three()
    cut, found = stitch(placed.timeline, placed.sources, method="cut"), RIVALS[name](placed)
    first = placed.seams[0].frame
    np.testing.assert_array_equal(found.rotations[:first], cut.rotations[:first])


@pytest.mark.parametrize("rival", RIVALS.values(), ids=RIVALS)
def test_positions_meet_at_the_seam(rival: Rival):
    placed = three()
    cut, found = stitch(placed.timeline, placed.sources, method="cut"), rival(placed)
    for seam in placed.seams:
        gap, step = (
            quat_distance(motion.rotations[seam.frame - 1], motion.rotations[seam.frame]) for motion in (cut, found)
        )
        assert step.max() < 0.25 * gap.max()


@pytest.mark.parametrize("name", [name for name in RIVALS if "crossfade" not in name])
def test_velocity_is_continuous_where_it_is_promised(name: str):
    """Of a movement told ever more finely the step in velocity goes to nothing; that of a crossfade's ends does not."""

    def bend(rival: Rival, fine: int) -> float:
        """Largest change of velocity in rad/s within two frames of the seam."""
        time = np.arange(90 * fine) / (FPS * fine)
        left, right = np.sin(3 * time), 1.0 + np.cos(2 * time)
        clips = {key: replace(arm(values), fps=FPS * fine) for key, values in (("a", left), ("b", right))}
        cut = 40 * fine
        placed = place_timeline(line([("a", 0, cut), ("b", cut, len(right))], clips), clips)
        speed = np.diff(angles(rival(placed))) * FPS * fine
        return float(np.abs(np.diff(speed))[cut - 4 : cut + 2].max())

    widths: dict[str, Callable[[Placed, int], Motion]] = {
        "inertialize": lambda placed, n: inertialize(placed, 0.2),
        "dead_blend": lambda placed, n: dead_blend(placed, 12 * n),
        "dead_blend, one half-life": lambda placed, n: dead_blend(placed, 12 * n, halflife=0.1),
        "hermite": lambda placed, n: hermite(placed, 12 * n),
        "hermite, both sides": lambda placed, n: hermite(placed, 12 * n, sides="both"),
        "quintic": lambda placed, n: hermite(placed, 12 * n, degree=5),
    }
    coarse, finer = (bend(lambda placed, n=n: widths[name](placed, n), n) for n in (4, 16))
    assert finer < 0.3 * coarse


def test_a_crossfade_in_closed_form():
    """Two still arms: linear weights at half frames, or eased ones; both half way at the seam."""
    share = (np.arange(20) + 0.5) / 20
    placed = arms(np.zeros(90), np.ones(90))
    np.testing.assert_allclose(angles(crossfade(placed, 10))[30:50], share, atol=1e-12)
    eased = angles(crossfade(placed, 10, eased=True))
    np.testing.assert_allclose(eased[30:50], share**2 * (3 - 2 * share), atol=1e-12)


def test_a_crossfade_does_not_snap_round_where_both_poses_are_half_a_turn_apart():
    """The gap grows from 2.9 to 3.5 rad within the window; no step is larger than blend and sources explain."""
    gap = np.linspace(2.0, 4.4, 80)
    found = crossfade(arms(np.zeros(80), gap), 20).rotations[:, 1]
    assert quat_distance(found[1:], found[:-1]).max() < 0.15
    assert quat_distance(found[60:], quat_about_axis(0, gap[60:])).max() < 1e-9


@given(st.floats(0.05, 0.5), st.floats(-2.5, 2.5), st.floats(-0.05, 0.05))
def test_inertialization_is_the_damped_spring(halflife: float, gap: float, speed: float):
    """Left: gap + speed · k; right: still. After the seam the angle is the spring's closed form."""
    frames = np.arange(120)
    found = angles(inertialize(arms(gap + speed * (frames - 39.0), np.zeros(120)), halflife))
    time = np.arange(1, 81) / FPS
    y = 2 * np.log(2) / halflife
    np.testing.assert_allclose(found[40:], np.exp(-y * time) * (gap + (speed * FPS + y * gap) * time), atol=1e-10)


def test_the_spring_at_its_half_life():
    """y t = 2 ln 2 leaves (1 + 2 ln 2)/4 of the offset and t/4 of the velocity; the rest dies away."""
    place, speed = spring_decay(np.array([0.0, 0.3, 60.0]), 0.3)
    np.testing.assert_allclose(place, [1.0, (1 + 2 * np.log(2)) / 4, 0.0], atol=1e-12)
    np.testing.assert_allclose(speed, [0.0, 0.3 / 4, 0.0], atol=1e-12)


@pytest.mark.parametrize("degree", [3, 5])
def test_the_hermite_shares_start_and_end_as_they_should(degree: int):
    fine = np.linspace(0, 1, 100_001)
    place, speed = hermite_decay(fine, degree)
    slope, tilt = np.gradient(place, fine), np.gradient(speed, fine)
    np.testing.assert_allclose([place[0], place[-1], speed[0], speed[-1]], [1, 0, 0, 0], atol=1e-12)
    np.testing.assert_allclose([slope[0], slope[-1], tilt[0], tilt[-1]], [0, 0, 1, 0], atol=1e-4)
    if degree == 5:
        bends = [np.gradient(np.gradient(share, fine), fine)[[2, -3]] for share in (place, speed)]
        np.testing.assert_allclose(bends, 0.0, atol=5e-3)
    assert place[50_000] == pytest.approx(0.5)


def test_hermite_on_both_sides_meets_half_way():
    found = angles(hermite(arms(np.zeros(90), np.ones(90)), 12, sides="both"))
    assert found[39] + found[40] == pytest.approx(1.0)
    np.testing.assert_allclose(found[:40] + found[79:39:-1], 1.0, atol=1e-12)
    assert np.all(np.diff(found) >= -1e-12)


def test_hermite_on_both_sides_commutes_with_time_reversal():
    clips = cast(2, frames=100)
    turned = {key: replace(clip, rotations=clip.rotations[::-1], translations=clip.translations[::-1])
              for key, clip in clips.items()}  # fmt: skip
    there = place_timeline(line([("a", 0, 50), ("b", 40, 100)], clips), clips)
    back = place_timeline(line([("b", 0, 60), ("a", 50, 100)], turned), turned)
    found, again = hermite(there, 20, sides="both"), hermite(back, 20, sides="both")
    np.testing.assert_allclose(quat_distance(found.rotations[:, 1:], again.rotations[::-1, 1:]), 0.0, atol=1e-7)


def test_dead_blending_in_closed_form():
    """A steady left arm runs on with a decaying speed while it fades to a still right one."""
    frames = np.arange(120)
    found = angles(dead_blend(arms(0.5 + 0.02 * (frames - 39.0), np.zeros(120)), 20, halflife=0.1))
    k = np.arange(1, 21)
    y = np.log(2) / (0.1 * FPS)
    share = (k / 20) ** 2 * (3 - 2 * k / 20)
    np.testing.assert_allclose(found[40:60], (1 - share) * (0.5 + 0.02 * (1 - np.exp(-y * k)) / y), atol=1e-10)
    np.testing.assert_allclose(found[60:], 0.0, atol=1e-12)


def test_dead_blending_stops_at_once_what_moves_away():
    frames = np.arange(120)
    away = angles(dead_blend(arms(0.5 + 0.02 * (frames - 39.0), np.zeros(120)), 60))
    towards = angles(dead_blend(arms(0.5 - 0.02 * (frames - 39.0), np.zeros(120)), 60))
    travel = 0.02 * 0.05 * FPS / np.log(2)
    assert away.max() < 0.5 + travel
    assert towards[60] < 0.5 - 2 * travel


def test_what_is_left_of_one_seam_is_carried_over_the_next():
    """Two seams nearer than the spring's reach: the second starts from where the first had got to."""
    clips = {"a": arm(np.zeros(60)), "b": arm(np.ones(60)), "c": arm(np.full(60, 0.5))}
    placed = place_timeline(line([("a", 0, 30), ("b", 10, 14), ("c", 0, 60)], clips), clips)
    found = angles(inertialize(placed, 0.5))
    assert np.abs(np.diff(found)).max() < 0.1
    assert found[-1] == pytest.approx(0.5, abs=1e-2)


@pytest.mark.parametrize("rival", RIVALS.values(), ids=RIVALS)
def test_turning_and_moving_the_whole_scene_turns_and_moves_the_result(rival: Rival):
    clips = cast(2, frames=100)
    timeline = line([("a", 0, 50), ("b", 40, 100)], clips)
    turn, shift = quat_about_axis(1, np.array(1.0)), np.array([3.0, 0.0, -2.0])
    found = rival(place_timeline(timeline, clips))

    def moved(clip: Motion) -> Motion:
        rotations, translations = clip.rotations.copy(), clip.translations.copy()
        rotations[:, 0] = quat_multiply(turn, rotations[:, 0])
        translations[:, 0] = quat_rotate(turn, translations[:, 0]) + shift
        return replace(clip, rotations=rotations, translations=translations)

    again = rival(place_timeline(timeline, {key: moved(clip) for key, clip in clips.items()}))
    if rival is RIVALS["dead_blend"]:  # its half-lives belong to the axes of the hips' parent, which is the world
        assert quat_distance(again.rotations[:, 1:], found.rotations[:, 1:]).max() < 1e-7
    else:
        assert_motion_close(again, moved(found), degrees=1e-5, metres=1e-9)


@pytest.mark.parametrize("width", [0, -3])
def test_a_width_below_one_frame_is_refused(width: int):
    placed = arms(np.zeros(60), np.ones(60))
    for rival in (crossfade, hermite, dead_blend):
        with pytest.raises(ParameterError, match="at least 1 frame"):
            rival(placed, width)  # type: ignore[operator]


@pytest.mark.parametrize("halflife", [0.0, -1.0, float("nan"), float("inf")])
def test_a_half_life_that_is_none_is_refused(halflife: float):
    placed = arms(np.zeros(60), np.ones(60))
    with pytest.raises(ParameterError, match="half-life"):
        inertialize(placed, halflife)
    with pytest.raises(ParameterError, match="half-life"):
        dead_blend(placed, 10, halflife=halflife)


def test_another_degree_is_refused():
    with pytest.raises(ParameterError, match="degree 3 or 5"):
        hermite(arms(np.zeros(60), np.ones(60)), 10, degree=4)


def test_widths_end_with_the_segment():
    """A window wider than the clip ends where the clip ends, with the right source's last frame."""
    placed = arms(np.zeros(60), np.ones(60))
    for found in (dead_blend(placed, 500), hermite(placed, 500)):
        assert angles(found)[-1] == pytest.approx(1.0)
        assert np.abs(np.diff(angles(found))).max() < 0.08
