"""Foot skate of a body that glides, steps or stands, whose values are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.analysis import feet
from kinestitch.core.motion import Motion
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import ParameterError, SkeletonMismatchError
from kinestitch.samples import SAMPLE_NAMES, sample

NAMES = ("Hips", "Spine", "LeftUpLeg", "LeftLeg", "LeftFoot", "RightUpLeg", "RightLeg", "RightFoot")
PARENTS = (-1, 0, 0, 2, 3, 0, 5, 6)
RIG = Skeleton(
    NAMES,
    PARENTS,
    [[0, 1, 0], [0, 0.4, 0], [0.1, -0.1, 0], [0, -0.4, 0], [0, -0.4, 0], [-0.1, -0.1, 0], [0, -0.4, 0], [0, -0.4, 0]],
)
STANDS = 0.1  # m, the height of its feet


def body(x: np.ndarray, y: np.ndarray | float = 0.0, fps: float = 20.0) -> Motion:
    """A body that glides: hips moved by x and y (F,) m."""
    translations = np.broadcast_to(RIG.offsets, (len(x), len(NAMES), 3)).copy()
    translations[:, 0, 0] += x
    translations[:, 0, 1] += y
    rotations = np.zeros((len(x), len(NAMES), 4))
    rotations[..., 3] = 1.0
    return Motion(RIG, translations, rotations, fps)


def test_feet_are_found_by_their_names():
    assert feet.foot_joints(RIG) == (4, 7)
    rig = sample("walk").skeleton
    assert [rig.names[joint] for joint in feet.foot_joints(rig)] == ["mixamorig:LeftToeBase", "mixamorig:RightToeBase"]


def test_feet_without_names_are_the_ends_of_the_legs():
    nameless = replace(RIG, names=tuple(f"{'LR'[n > 4]}{n % 3}" if n > 1 else f"x{n}" for n in range(8)))
    renamed = ("a", "b", "leftone", "lefttwo", "leftthree", "rightone", "righttwo", "rightthree")
    assert feet.foot_joints(replace(nameless, names=renamed)) == (4, 7)
    with pytest.raises(SkeletonMismatchError, match="two legs"):
        feet.foot_joints(Skeleton(("A", "B"), (-1, 0), [[0, 1, 0], [0, 1, 0]]))


def test_standing_heights_are_where_feet_stand():
    lift = np.maximum(0, np.sin(np.arange(200) / 10)) * 0.3
    np.testing.assert_allclose(feet.standing_heights(body(np.zeros(200), lift), (4, 7)), STANDS, atol=1e-9)


@pytest.mark.parametrize(("height", "weight"), [(0.0, 1.0), (0.0125, 2 - np.sqrt(2)), (0.025, 0.0), (0.3, 0.0)])
def test_a_glide_is_weighed_by_its_height(height: float, weight: float):
    """1 cm a frame, at a constant height over the ground."""
    found = feet.weighted_skate(body(0.01 * np.arange(30), height), ground=STANDS)
    assert found.shape == (29, 2)
    np.testing.assert_allclose(found, 0.01 * weight, atol=1e-12)


def test_below_the_ground_counts_as_on_it():
    np.testing.assert_allclose(feet.weighted_skate(body(0.01 * np.arange(9), -0.05), ground=STANDS), 0.01)


def test_a_body_that_stands_or_only_rises_does_not_skate():
    assert feet.weighted_skate(body(np.zeros(30))).max() == 0.0
    assert feet.weighted_skate(body(np.zeros(30), 0.001 * np.arange(30))).max() == 0.0
    assert feet.skating_share(body(np.zeros(30))) == 0.0
    assert feet.skating_share(body(np.zeros(1))) == 0.0


@pytest.mark.parametrize(("speed", "height", "share"), [(0.49, 0, 0), (0.51, 0, 1), (2, 0.049, 1), (2, 0.051, 0)])
def test_the_share_of_skating_frames_has_its_two_thresholds(speed: float, height: float, share: float):
    found = feet.skating_share(body(speed * np.arange(30) / 20, height), ground=STANDS)
    assert found == share


def test_the_share_is_told_at_20_frames_a_second_whatever_the_rate():
    """Half of the time at 1 m/s, half of it still."""
    for fps in (20.0, 60.0, 120.0):
        time = np.arange(int(4 * fps) + 1) / fps
        found = feet.skating_share(body(np.minimum(time, 2.0), fps=fps))
        assert found == pytest.approx(0.5, abs=0.02)


def test_the_samples_do_not_skate_and_a_slid_one_does():
    """A walk's swinging toe passes low over the ground, which both measures count: 8 % of the frames."""
    for name in SAMPLE_NAMES:
        clip = sample(name)
        assert feet.skating_share(clip) < (0.1 if name == "walk" else 0.06), name
        assert feet.weighted_skate(clip).mean() * clip.fps < 0.06, name
    assert feet.weighted_skate(sample("idle")).max() < 1e-6
    walk = sample("walk")
    slid = walk.translations.copy()
    slid[:, 0, 0] += np.arange(walk.frames) / walk.fps
    slides = replace(walk, translations=slid)
    assert feet.skating_share(slides) > 0.3
    assert feet.weighted_skate(slides).mean() > 10 * feet.weighted_skate(walk).mean()


def test_a_height_that_is_none_is_refused():
    with pytest.raises(ParameterError, match="height"):
        feet.weighted_skate(body(np.zeros(5)), height=0.0)
