"""Feet that stand do not slide, and nothing goes through the floor."""

from __future__ import annotations

import numpy as np
import pytest

from kinestitch.samples.feet import Footwork, Stance

FEET = ("LeftFoot", "RightFoot", "LeftToeBase", "RightToeBase")


@pytest.mark.parametrize("foot", FEET)
def test_held_joints_do_not_slide(seen, foot):
    held = seen.held(foot)
    both = held[1:] & held[:-1]
    assert both.any()
    across = np.linalg.norm(np.diff(seen.at(foot)[:, [0, 2]], axis=0), axis=1) * seen.motion.fps
    assert across[both].max() < 1e-6  # m/s; the promise is 0.01
    assert np.ptp(seen.at(foot)[held, 1]) < 1e-9


@pytest.mark.parametrize("side", ["Left", "Right"])
def test_a_sole_that_stands_holds_the_ball_too(seen, side):
    assert (seen.held(f"{side}ToeBase") | ~seen.held(f"{side}Foot")).all()


def test_nothing_goes_through_the_floor(seen):
    assert seen.positions[..., 1].min() >= 0.0
    for side in ("Left", "Right"):
        assert seen.at(f"{side}ToeBase")[:, 1].min() >= 0.022 - 1e-9
        assert seen.at(f"{side}Foot")[:, 1].min() >= 0.039 * 1.75 - 1e-9


def test_joints_that_are_free_do_move(look):
    walk = look("walk")
    for side in ("Left", "Right"):
        free = ~walk.held(f"{side}ToeBase") & (walk.at(f"{side}ToeBase")[:, 1] > 0.03)
        assert free.mean() > 0.3
        assert walk.speed(f"{side}ToeBase")[free[1:] & free[:-1]].min() > 0.3


def test_a_stance_rolls_over_heel_and_ball():
    stance = Stance(0.1, 0.5, ((0.0, 20.0, 0.0), (0.2, 0.0, 0.0), (0.5, 0.0, 0.0), (0.7, -60.0, 0.0)))
    ankle = stance.ankle(np.array([0.0, 0.3, 0.4, 0.7]))
    assert np.array_equal(ankle[1], ankle[2])
    assert ankle[0, 2] < ankle[1, 2] < ankle[3, 2]
    assert ankle[3, 1] > 0.15
    foot = Footwork((stance,))
    sole, ball = foot.contacts(np.array([0.1, 0.3, 0.6, 0.8]))
    assert sole.tolist() == [False, True, False, False]
    assert ball.tolist() == [False, True, True, False]


def test_a_swing_takes_over_speed_and_gives_it_back():
    before = Stance(0.0, 0.0, ((-1.0, 0.0, 0.0), (0.0, 0.0, 0.0), (0.3, -50.0, 0.0)))
    after = Stance(0.0, 0.8, ((0.7, 15.0, 0.0), (0.8, 0.0, 0.0), (2.0, 0.0, 0.0)))
    foot = Footwork((before, after), (((0.5, 0.0, 0.2, 0.3, -20.0, 0.0),),))
    for at in (0.3, 0.7):
        h = 1e-4
        left, mid, right = foot.state(np.array([at - h, at, at + h]))
        assert np.abs((right - mid) - (mid - left))[:3].max() / h < 0.02
