"""The comparison with Blender without Blender: what is missing is told, and a stand-in runs all of what follows."""

from __future__ import annotations

import sys

import numpy as np
import pytest

from kinestitch.experiments import against_blender as ab
from kinestitch.experiments import blender_measures, blender_nla, punches
from kinestitch.experiments import trade_off as t
from kinestitch.experiments.dataset import DataSet, load
from kinestitch.experiments.same_deviation import at_deviation, needed_setting, spread, versus
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.rivals import crossfade
from kinestitch.solve.stitch import stitch


@pytest.fixture(scope="module")
def samples() -> DataSet:
    return load(None, "mixamo")


def stand_in(wanted, widths=blender_nla.WIDTHS):
    """What Blender would answer if it blended as we do."""
    motions = {
        (one.timeline, width, mode): crossfade(one, width)
        for mode, some in wanted.items()
        for one in some
        for width in widths
    }
    return blender_nla.Blended("0", motions, {one.timeline: 0 for one in wanted["matched"]}, (1.0, 1.0))


@pytest.mark.parametrize("python", ["/nowhere/python", sys.executable])
def test_without_blender_the_section_says_so(samples, monkeypatch, python):
    monkeypatch.setenv(blender_nla.VARIABLE, python)
    section = ab.run(samples, cuts=1)
    assert {finding.verdict for finding in section.findings} == {"missing"}
    assert all(python in finding.evidence and "\n" not in finding.evidence for finding in section.findings)
    assert section.pictures == section.tables == ()


def test_where_blender_blends_as_we_do_the_numbers_say_so(samples, monkeypatch):
    monkeypatch.setattr(ab, "blend", stand_in)
    section = ab.run(samples, cuts=2, seed=1)
    assert section.numbers["blender_from_crossfade_deg"]["matched"] < 1e-3
    assert section.numbers["dynamics_survived"]["ours"] > 0.9
    assert {f.claim for f in section.findings} >= {ab.INTERVAL, ab.FEATURES}
    assert len(section.pictures) == 2
    assert all(picture.own for picture in section.pictures)
    assert all(len(row) == len(table.head) for table in section.tables for row in table.rows)


def test_components_interpolated_meet_slerp_half_way(samples):
    placed = place_timeline(punches.punches(samples)[0].cut, samples.clips)
    (seam,) = placed.seams
    start, rotations = blender_measures.component_lerp(placed, 1)
    assert start == seam.frame - 1
    assert rotations.shape == (2, placed.skeleton.joint_count, 4)
    np.testing.assert_allclose(np.linalg.norm(rotations, axis=-1), 1.0)


def test_punches_go_both_ways_and_the_hard_cut_keeps_the_strike(samples):
    there, back = punches.punches(samples)
    assert there.speeds == back.speeds[::-1]
    for punch in (there, back):
        hard = stitch(punch.cut, samples.clips, method="cut")
        assert punches.strike_kept(hard, hard, punch) == 1.0
        after = punch.frame - punch.cut.starts[1]
        assert after == round(punches.BEFORE * punch.cut.fps)
        assert punches.joint_speeds(hard)[punch.frame - 1, punch.joint] == pytest.approx(punch.speeds[1])


def made_up(name: str, deviation: list[list[float]], added: list[list[float]]) -> t.Curve:
    values = {key: np.ones((len(deviation), len(deviation[0]))) for key in t.MEASURES}
    values |= {"deviation": np.array(deviation), "added": np.array(added)}
    return t.Curve(name, "width", tuple(float(10**k) for k in range(len(deviation))), values)


def test_rivals_are_read_at_each_seams_own_deviation():
    rival = made_up("rival", [[1, 1], [4, 4]], [[3, 3], [1, 1]])
    np.testing.assert_allclose(at_deviation(rival, "added", np.array([2.0, 4.0])), [2.0, 1.0])
    assert np.isnan(at_deviation(rival, "added", np.array([0.5, 5.0]))).all()


def test_ours_is_compared_seam_by_seam():
    ours, rival = made_up("ours", [[2, 9]], [[1.5, 0]]), made_up("rival", [[1, 1], [4, 4]], [[3, 3], [1, 1]])
    found = versus(ours, rival, "added")
    assert (found.seams, found.better, found.loses) == (1, 1.0, False)
    assert (found.ours, found.theirs) == pytest.approx((1.5, 2.0))
    assert versus(made_up("ours", [[9, 9]], [[0, 0]]), rival, "added").seams == 0
    assert versus(made_up("ours", [[2, 2]], [[5, 5]]), rival, "added").loses


def test_the_setting_a_seam_needs():
    curve = made_up("a", [[1, 1, 1], [2, 2, 2], [4, 4, 4]], [[3, 0.5, 9], [0.5, 0.4, 8], [0.1, 0.3, 7]])
    needed = needed_setting(curve, "added", 1.0)
    np.testing.assert_allclose(needed, [10**0.8, 1.0, 100.0])
    assert spread(np.array([2.0, 2.0, 2.0])) == 1.0
