"""The figures of docs/retargeting.md are what their words say."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis, quat_multiply
from kinestitch.experiments import retargeting


def cut(motion: Motion, start: int, stop: int) -> Motion:
    return replace(motion, rotations=motion.rotations[start:stop], translations=motion.translations[start:stop])


def turned(motion: Motion, name: str, degrees: float) -> Motion:
    """A joint turned about its own Z axis in every frame."""
    joint = motion.skeleton.index(f"mixamorig:{name}")
    rotations = motion.rotations.copy()
    rotations[:, joint] = quat_multiply(rotations[:, joint], quat_about_axis(2, np.radians(degrees)))
    return replace(motion, rotations=rotations)


def test_errors_are_angles_between_bones():
    walk = ks.sample("walk")
    errors = retargeting.direction_errors(turned(walk, "LeftForeArm", 30.0), walk)
    assert errors["forearm"] == pytest.approx(15.0)  # the mean of both sides
    assert max(value for limb, value in errors.items() if limb != "forearm") < 1e-5
    assert retargeting.rest_difference(walk.skeleton, walk.skeleton) == 0


def test_clips_are_aligned_in_time_and_speed():
    kick = ks.sample("kick")
    late, fast = cut(kick, 20, kick.frames), replace(ks.sample("kick", fps=120), fps=240)
    ours, theirs, shift = retargeting.aligned(kick, late, 1.0)
    assert shift == -20
    assert ours.frames == theirs.frames == late.frames
    assert max(retargeting.direction_errors(ours, theirs).values()) < 1e-5
    ours, theirs, shift = retargeting.aligned(fast, kick, 0.5)
    assert shift == 0
    assert max(retargeting.direction_errors(ours, theirs).values()) < 0.1


def test_toes_that_follow_their_source_do_not_slide_more():
    walk = ks.sample("walk")
    own = retargeting.toe_slide(walk, walk)
    drifting = replace(walk, translations=walk.translations + np.linspace(0, 1, walk.frames)[:, None, None] * [1, 0, 0])
    assert own < 5
    assert retargeting.toe_slide(drifting, walk) > own + 10


def test_hips_are_compared_in_leg_lengths():
    walk = ks.sample("walk")
    higher = walk.translations.copy()
    higher[:, 0, 1] += 0.0859
    raised = replace(walk, translations=higher)
    assert retargeting.hips_error(raised, walk) == pytest.approx(10, abs=0.1)
    assert retargeting.hips_error(walk, walk) == 0


def test_the_tables_are_written(tmp_path):
    folder = os.environ.get("KINESTITCH_DATA")
    if not folder:
        pytest.skip("KINESTITCH_DATA, the folder of real clips, is not set")
    retargeting.main([folder, "-o", str(tmp_path / "table.md")])
    text = (tmp_path / "table.md").read_text(encoding="utf-8")
    assert text.count("| kinestitch |") == len(retargeting.CASES) + len(retargeting.CROSSINGS)
    assert "nan" not in text
    assert str(Path(folder)) not in text
