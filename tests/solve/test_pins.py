"""Pins on whole motions: each kind is met, what it does not concern stays, and the world may be turned."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from solve_oracles import cast, line

from kinestitch.core.kinematics import turn_about_up, world_pose
from kinestitch.core.rotation import quat_about_axis, quat_conjugate, quat_distance, quat_multiply, quat_normalize
from kinestitch.edit.operations import replace as paste
from kinestitch.edit.pins import Pin
from kinestitch.edit.timeline import timeline
from kinestitch.errors import KinestitchWarning, ParameterError
from kinestitch.rig.root_motion import extract_root
from kinestitch.samples import sample
from kinestitch.solve.seam import seam_reach
from kinestitch.solve.stitch import solve_timeline, stitch
from kinestitch.testing import assert_motion_close, check_motion

WALK = {"walk": sample("walk")}
LINE = timeline(WALK, "walk")
PLAIN = stitch(LINE, WALK)
LAST = LINE.frames - 1
NAMES = PLAIN.skeleton.names


def with_pins(*pins, clips=WALK, base=LINE, **options):
    motion = solve_timeline(replace(base, pins=pins), clips, **options).motion
    check_motion(motion)
    return motion


def places(motion, joint=0):
    return world_pose(motion).positions[:, joint]


def named(ending):
    return next(k for k, name in enumerate(NAMES) if name.endswith(ending))


def facing(motion, frame):
    """Where the hips' rest facing, +Z, points to in the world, as a yaw."""
    q = quat_multiply(world_pose(motion).rotations[frame, 0], quat_conjugate(motion.skeleton.rest[0]))
    return 2 * np.arctan2(q[1], q[3])


@pytest.mark.parametrize("clips", [WALK, {"walk": extract_root(WALK["walk"])}], ids=["hips", "root"])
def test_the_body_stands_where_and_heads_as_it_is_told(clips):
    base = timeline(clips, "walk")
    hips = 0 if clips is WALK else 1
    pins = (
        Pin("waypoint", 90, (0.5, 1.6)),
        Pin("root", 130, (0.9, 0.05, 2.3)),
        Pin("heading", 150, (np.radians(40),)),
    )
    motion = with_pins(*pins, clips=clips, base=base)
    before = stitch(base, clips)
    path = places(motion, hips)
    own = places(before, hips)
    assert np.allclose(path[130], [0.9, own[130, 1] + 0.05, 2.3], atol=1e-9)
    turned = quat_multiply(world_pose(motion).rotations[150, hips], quat_conjugate(PLAIN.skeleton.rest[0]))
    assert 2 * np.arctan2(turned[1], turned[3]) == pytest.approx(np.radians(40), abs=1e-9)
    assert np.abs(motion.translations[:, 2:] - before.translations[:, 2:]).max() < 1e-12
    assert np.abs(motion.rotations[:, 2:] - before.rotations[:, 2:]).max() < 1e-12
    alone = with_pins(pins[0], clips=clips, base=base)
    assert np.allclose(places(alone, hips)[90][[0, 2]], [0.5, 1.6], atol=1e-9)


def test_behind_the_last_pin_everything_rides_along():
    motion = with_pins(Pin("waypoint", 80, (0.4, 1.4)), Pin("root", 100, (0.3, 0.0, 2.0)))
    steps, own = np.diff(places(motion)[100:], axis=0), np.diff(places(PLAIN)[100:], axis=0)
    yaw = facing(motion, 100) - facing(PLAIN, 100)
    turned = np.stack(
        [
            np.cos(yaw) * own[:, 0] + np.sin(yaw) * own[:, 2],
            own[:, 1],
            np.cos(yaw) * own[:, 2] - np.sin(yaw) * own[:, 0],
        ],
        1,
    )
    assert np.abs(steps - turned).max() < 1e-12


def test_several_turns_add_up():
    motion = with_pins(*(Pin("heading", frame, (angle,)) for frame, angle in ((60, 2.5), (120, 5.0), (180, 7.5))))
    yaw = np.unwrap([facing(motion, frame) for frame in range(0, 181, 5)])
    assert yaw[-1] - facing(PLAIN, 0) == pytest.approx(7.5 - facing(PLAIN, 0), abs=1e-9)


def test_pins_of_the_first_frame_move_all():
    motion = with_pins(Pin("heading", 0, (1.0,)), Pin("root", 0, (2.0, 0.0, -1.0)))
    turn = 1.0 - facing(PLAIN, 0)
    expected = turn_about_up(turn_about_up(PLAIN, 0.0, -places(PLAIN)[0] * [1, 0, 1]), turn, (2.0, 0.0, -1.0))
    assert_motion_close(motion, expected, degrees=1e-6, metres=1e-9)


def test_joint_rotations_and_what_lies_beyond_their_reach():
    joint, other = named("LeftArm"), named("RightLeg")
    wanted = quat_normalize([0.2, 0.5, -0.3, 0.8])
    pin = Pin("rotation", 100, tuple(wanted), "LeftArm", smoothing=0.03)
    motion = with_pins(pin, Pin("rotation", 103, tuple(-wanted), "LeftArm", smoothing=0.03))
    for frame in (100, 103):
        assert quat_distance(motion.rotations[frame, joint], wanted) < 1e-9
    changed = np.abs(motion.rotations - PLAIN.rotations).max(axis=2)
    assert changed[:, other].max() == 0.0
    reach = seam_reach((0.03 * 60) ** 4)
    far = np.abs(np.arange(LINE.frames)[:, None] - [100, 103]).min(axis=1) > reach
    assert far.sum() > 20
    assert changed[far].max() == 0.0
    assert np.array_equal(motion.translations, PLAIN.translations)


@settings(deadline=None, max_examples=25)
@given(st.integers(0, 2**32 - 1))
def test_random_rotations_of_any_size_are_met(seed):
    rng = np.random.default_rng(seed)
    clips = cast(1, joints=5, frames=80, bend=3.0)
    base = line([("a", 0, 80)], clips)
    frames = rng.choice(80, 3, replace=False)
    pins = [Pin("rotation", int(f), tuple(quat_normalize(rng.normal(size=4))), "Joint2") for f in frames]
    motion = with_pins(*pins, clips=clips, base=base)
    for pin in pins:
        assert quat_distance(motion.rotations[pin.frame, 2], np.array(pin.target)) < 1e-9


REACHED = [
    ("LeftHand", 80, (0.30, 1.30, 1.95)),
    ("LeftHandMiddle3", 80, (0.25, 1.35, 1.95)),
    ("RightFoot", 60, (-0.15, 0.30, 1.35)),
    ("RightToeBase", 60, (-0.15, 0.15, 1.45)),
    ("Head", 90, (0.10, 1.45, 2.02)),
    ("LeftForeArm", 90, (0.28, 1.20, 1.90)),
]


@pytest.mark.parametrize(("joint", "frame", "target"), REACHED)
def test_joints_get_to_their_places(joint, frame, target):
    motion = with_pins(Pin("position", frame, target, joint))
    assert np.abs(places(motion, named(joint))[frame] - target).max() < 1e-6
    assert np.array_equal(motion.translations, PLAIN.translations)
    assert np.array_equal(motion.rotations[:, 0], PLAIN.rotations[:, 0])
    if "Foot" in joint or "Toe" in joint:
        foot = named("RightFoot")
        before, after = (world_pose(m).rotations[frame, foot] for m in (PLAIN, motion))
        assert quat_distance(before, after) < 1e-9


def test_pins_of_trunk_and_limbs_are_met_together():
    pins = [
        Pin("rotation", 70, tuple(quat_about_axis(1, 0.4)), "Spine1"),
        Pin("position", 90, (0.10, 1.47, 1.98), "Head"),
        Pin("position", 92, (0.30, 1.25, 2.15), "LeftHand"),
        Pin("position", 70, (-0.30, 1.20, 1.55), "RightHand"),
        Pin("waypoint", LAST, (1.0, 3.9)),
    ]
    pins[1] = replace(pins[1], target=tuple(places(with_pins(pins[-1]), named("Head"))[90] + [0.05, -0.03, 0.04]))
    pins[2] = replace(pins[2], target=tuple(places(with_pins(pins[-1]), named("LeftHand"))[92] + [0.1, 0.2, 0.1]))
    pins[3] = replace(pins[3], target=tuple(places(with_pins(pins[-1]), named("RightHand"))[70] + [-0.1, 0.2, 0.1]))
    motion = with_pins(*pins)
    for pin in pins[1:4]:
        assert np.abs(places(motion, named(pin.joint))[pin.frame] - pin.target).max() < 1e-6
    assert quat_distance(motion.rotations[70, named("Spine1")], quat_about_axis(1, 0.4)) < 1e-9
    assert np.allclose(places(motion)[LAST][[0, 2]], [1.0, 3.9], atol=1e-9)


ALL = [
    Pin("root", LAST, (0.4, 0.03, 4.0)),
    Pin("heading", LAST, (0.5,)),
    Pin("waypoint", LAST, (0.6, 3.9)),
    Pin("position", 80, (0.30, 1.30, 1.95), "LeftHand"),
    Pin("position", 90, (0.10, 1.45, 2.02), "Head"),
    Pin("rotation", 100, (0.2, 0.5, -0.3, 0.7874), "LeftArm"),
]


@pytest.mark.parametrize("pin", ALL, ids=str)
def test_weights_lead_from_nothing_to_all(pin):
    exact = with_pins(pin)
    assert_motion_close(with_pins(replace(pin, weight=1e9)), exact, degrees=1e-4, metres=1e-6)
    assert_motion_close(with_pins(replace(pin, weight=1e-9)), PLAIN, degrees=1e-4, metres=1e-6)
    half = with_pins(replace(pin, weight=1.0))
    part, whole = (np.abs(world_pose(m).positions - world_pose(PLAIN).positions).max() for m in (half, exact))
    assert 0.3 * whole < part < 0.8 * whole


@settings(deadline=None, max_examples=15)
@given(st.floats(-3, 3), st.floats(-20, 20), st.integers(0, len(ALL) - 1))
def test_a_turned_world_gives_the_same_motion_turned(yaw, shift, which):
    pin = ALL[which]
    move = np.array([shift, 0.0, -shift / 2])
    clips = {"walk": turn_about_up(WALK["walk"], yaw, move)}
    x, z = (pin.target[0], pin.target[-1]) if len(pin.target) < 4 else (0.0, 0.0)
    turned = (np.cos(yaw) * x + np.sin(yaw) * z + move[0], np.cos(yaw) * z - np.sin(yaw) * x + move[2])
    target = {"heading": (pin.target[0] + yaw,), "rotation": pin.target, "waypoint": turned}.get(
        pin.kind, (turned[0], *pin.target[1:2], turned[1])
    )
    found = with_pins(replace(pin, target=target), clips=clips, base=timeline(clips, "walk"))
    assert_motion_close(found, turn_about_up(with_pins(pin), yaw, move), degrees=1e-5, metres=1e-7)


@pytest.mark.parametrize(
    ("pins", "words"),
    [
        (
            [Pin("position", 80, (0.3, 2.9, 1.9), "LeftHand")],
            r"0.\d+ m from 'mixamorig:LeftArm' for LeftHand@80.* away",
        ),
        ([Pin("position", 80, (0.3, 2.9, 1.9), "Head")], r"can reach from the hips for Head@80"),
        ([Pin("position", 80, (0.3, 1.0, 1.9), "Hips")], "Use a root pin"),
        ([Pin("position", 80, (0.3, 1.3, 1.9), "LeftHnd")], r"name of a joint for LeftHnd@80.*'LeftHnd'.*LeftHand"),
        ([Pin("rotation", 80, (0, 0, 0, 1), "Tail")], "name of a joint"),
        (
            [Pin("position", 80, (0.3, 1.3, 1.9), "LeftHand"), Pin("rotation", 80, (0, 0, 0, 1), "LeftArm")],
            r"one turns 'mixamorig:LeftArm' in frame 80",
        ),
        ([Pin("waypoint", 10, (3.0, 3.0))], r"travels 4.\d+ m .* before waypoint@10.*root pin"),
        ([Pin("waypoint", 100, (0.0, 2.0)), Pin("waypoint", 103, (0.0, 1.9))], r"walk can be bent through"),
        ([Pin("root", 80, (0, 0, 2.0), smoothing=1000.0)], "smoothing time from 0 to 16.7 s at 60 fps, got 1000 s"),
    ],
)
@pytest.mark.filterwarnings("ignore::kinestitch.errors.KinestitchWarning")
def test_pins_that_cannot_be_met_are_refused(pins, words):
    with pytest.raises(ParameterError, match=words) as caught:
        with_pins(*pins)
    assert "\n" not in str(caught.value)


def test_a_weighted_place_out_of_reach_is_approached():
    arm, hand = named("LeftArm"), named("LeftHand")
    motion = with_pins(Pin("position", 80, (0.3, 2.9, 1.9), "LeftHand", weight=1e6))
    way = np.linalg.norm(places(motion, hand)[80] - places(motion, arm)[80])
    bones = np.linalg.norm(PLAIN.skeleton.offsets[[named("LeftForeArm"), hand]], axis=1).sum()
    assert way == pytest.approx(bones, rel=1e-3)
    assert places(motion, hand)[80, 1] > places(motion, arm)[80, 1] + 0.9 * bones


def test_steps_that_become_much_longer_are_told():
    with pytest.warns(KinestitchWarning, match=r"Steps before waypoint@200=0,5.9 become 1.\d\d times as long"):
        with_pins(Pin("waypoint", LAST, (0.0, 5.9)))


@pytest.mark.parametrize(
    ("target", "words"),
    [
        ((900.0, 0.0, 3.0), r"way to root@120=900,0,3 is 900 m in 2 s, where the body itself goes 2.5\d m"),
        ((0.0, 0.0, 1.0), r"way to root@120=0,0,1 is 1.\d+ m in 2 s"),
        ((0.0, -5.0, 2.5), r"root@120=0,-5,2.5 sinks the body by 5 m, more than the 0.86 m from ankles to hips"),
        ((0.0, 0.9, 2.5), r"root@120=0,0.9,2.5 lifts the body by 0.9 m"),
    ],
)
def test_a_root_pin_that_asks_for_too_much_is_told(target, words):
    with pytest.warns(KinestitchWarning, match=words) as told:
        with_pins(Pin("root", 120, target))
    assert len(told) == 1


@pytest.mark.filterwarnings("error")
def test_root_pins_within_measure_are_not():
    with_pins(Pin("root", 0, (900.0, 0.0, 3.0)))
    with_pins(Pin("root", 60, (0.2, 0.8, 0.8)), Pin("root", 120, (0.0, 0.0, 2.4)))
    clips = {"idle": sample("idle")}
    with_pins(Pin("root", 240, (0.4, 0.0, 0.0)), clips=clips, base=timeline(clips, "idle"))


def test_seams_are_solved_first_and_pins_change_none_of_what_they_do_to_joints():
    clips = {"walk": sample("walk"), "kick": sample("kick")}
    base = paste(timeline(clips, "walk"), 84, 130, "kick", 30, 112)
    solved = solve_timeline(replace(base, pins=(Pin("waypoint", 230, (0.5, 2.6)),)), clips)
    plain = stitch(base, clips)
    assert_motion_close(solved.unpinned, plain, degrees=1e-12, metres=1e-12)
    assert np.array_equal(solved.motion.rotations[:, 1:], plain.rotations[:, 1:])
    assert np.allclose(places(solved.motion)[230][[0, 2]], [0.5, 2.6], atol=1e-9)
    assert_motion_close(stitch(solved.placed.timeline, clips), solved.motion, degrees=1e-12, metres=1e-12)
    cut = solve_timeline(solved.placed.timeline, clips, method="cut")
    assert np.allclose(places(cut.motion)[230][[0, 2]], [0.5, 2.6], atol=1e-9)
