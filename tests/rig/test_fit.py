"""Stitching clips of different rigs: retargeted and told where names are certain, refused with reasons where not."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from rig_builders import a_posed, hanging, renamed

import kinestitch as ks
from kinestitch.core.kinematics import world_pose
from kinestitch.errors import KinestitchWarning, SkeletonMismatchError
from kinestitch.rig.fit import fit_motion
from kinestitch.rig.match import match_motion
from kinestitch.testing import random_motion


def test_one_rig_is_matched_as_before():
    walk, kick = ks.sample("walk"), ks.sample("kick")
    assert fit_motion(kick, walk, "kick") is kick
    prefixed = replace(
        kick, skeleton=replace(kick.skeleton, names=tuple(f"hero:{name}" for name in kick.skeleton.names))
    )
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fitted = fit_motion(prefixed, walk, "kick")
    assert np.array_equal(fitted.rotations, match_motion(prefixed, walk.skeleton).rotations)


def test_another_rest_pose_is_retargeted_and_told_once():
    walk, kick = ks.sample("walk"), hanging(ks.sample("kick"))
    with pytest.warns(KinestitchWarning, match=r"Clip 'kick' is retargeted onto another Mixamo rig\.$"):
        fitted = fit_motion(kick, walk, "kick")
    assert fitted.skeleton is walk.skeleton
    assert np.abs(world_pose(fitted).positions - world_pose(ks.sample("kick")).positions).max() < 1e-4
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert fit_motion(kick, walk, "kick") is fitted


def test_a_stitch_of_two_rigs_is_the_stitch_of_one():
    walk, kick = ks.sample("walk"), ks.sample("kick")
    other = renamed(a_posed(kick), {"hips": "pelvis", "head": "head"})
    line = ks.replace(ks.timeline({"walk": walk, "kick": kick}, "walk"), 60, 90, "kick", 30, 90)
    whole = ks.stitch(line, {"walk": walk, "kick": kick})
    with pytest.warns(KinestitchWarning, match="Clip 'kick' is retargeted"):
        mixed = ks.stitch(line, {"walk": walk, "kick": other})
    assert mixed.skeleton is walk.skeleton
    assert np.abs(world_pose(mixed).positions - world_pose(whole).positions).max() < 1e-3


def test_doubt_is_refused_with_the_joints_that_are_not_found():
    walk = ks.sample("walk")
    lamp = renamed(ks.sample("kick"), {"left_hand": "Lamp"})
    with pytest.raises(SkeletonMismatchError) as caught:
        fit_motion(lamp, walk, "kick")
    told = str(caught.value)
    assert "differ at joint 10: 'mixamorig:LeftHand' and 'Lamp'" in told
    assert "clip 'kick' cannot be retargeted by names, which do not tell left_hand of the source." in told
    with pytest.raises(SkeletonMismatchError, match="any limb of the source"):
        fit_motion(random_motion(1), walk, "worm")
