"""The trade-off curves: on random motions as a whole, on made-up values where they are read off."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.rotation import quat_distance
from kinestitch.edit.timeline import Seam
from kinestitch.experiments import trade_off as t
from kinestitch.experiments.seams import random_cut, read_clips
from kinestitch.samples import SAMPLE_NAMES, sample
from kinestitch.solve.placed import place_timeline
from kinestitch.solve.stitch import stitch
from kinestitch.testing import random_motion


@pytest.fixture(scope="module")
def small() -> t.TradeOff:
    clips = {name: sample(name) for name in SAMPLE_NAMES}
    return t.trade_off(clips, "samples", seams=6, seed=1)


def test_every_method_is_measured_at_every_setting(small: t.TradeOff):
    assert [curve.name for curve in small.curves] == [way.name for way in t.WAYS]
    for curve in small.curves:
        assert set(curve.values) == set(t.MEASURES)
        assert all(values.shape == (len(curve.settings), 6) for values in curve.values.values())
        assert all(np.isfinite(values).all() for values in curve.values.values())


def test_wider_changes_more_and_adds_less(small: t.TradeOff):
    for curve in small.curves:
        deviation, added = curve.percentile("deviation"), curve.percentile("added")
        assert np.all(np.diff(deviation) > -1e-9), curve.name
        assert added[0] > 2 * added[-1], curve.name


def test_a_crossfade_averages_dynamics_away_and_the_solve_does_not(small: t.TradeOff):
    assert small.curve("laplacian").percentile("survived").min() > 0.95
    assert small.curve("crossfade").percentile("survived").min() < 0.9


def test_it_is_repeatable_by_its_seed():
    clips = {str(seed): random_motion(seed, frames=120) for seed in range(3)}
    one, same, other = (t.trade_off(clips, "", seams=2, seed=seed, ways=t.WAYS[:2]) for seed in (4, 4, 5))
    np.testing.assert_array_equal(one.curves[1].values["added"], same.curves[1].values["added"])
    assert np.any(one.curves[1].values["added"] != other.curves[1].values["added"])


def test_progress_is_told():
    clips = {str(seed): random_motion(seed, frames=120) for seed in range(2)}
    told: list[tuple[int, int]] = []
    t.trade_off(clips, "", seams=3, ways=t.WAYS[:1], progress=lambda done, of: told.append((done, of)))
    assert told == [(1, 3), (2, 3), (3, 3)]


def test_the_context_is_enough_for_the_widest_setting():
    """What is measured of a long timeline hardly depends on how much of it is stitched."""
    clips = {str(seed): random_motion(seed, frames=900) for seed in range(2)}
    cut = random_cut(clips, np.random.default_rng(3), Seam(smoothing=max(t.WAYS[0].settings)))
    short = t.near_seam(cut)
    assert short.frames <= 8 * 30 < cut.frames
    near, whole = stitch(short, clips), stitch(cut, clips)
    middle, seam = (place_timeline(line, clips).seams[0].frame for line in (short, cut))
    reach = min(30, middle, short.frames - middle)
    apart = quat_distance(near.rotations[middle - reach : middle + reach], whole.rotations[seam - reach : seam + reach])
    assert np.degrees(apart[:, 1:]).max() < 0.5


def made_up(name: str, deviation: list[float], added: list[float]) -> t.Curve:
    values = {key: np.ones((len(deviation), 1)) for key in t.MEASURES}
    values |= {"deviation": np.array(deviation)[:, None], "added": np.array(added)[:, None]}
    return t.Curve(name, "width", tuple(deviation), values)


def test_curves_are_read_off_on_logarithms():
    curve = made_up("a", [1.0, 4.0], [1.0, 0.25])
    assert curve.at("added", "deviation", 2.0) == pytest.approx(0.5)
    assert np.isnan(curve.at("added", "deviation", 0.5))


def test_the_advantage_is_told_at_the_same_deviation():
    trade = t.TradeOff(
        "", 1, 30.0, (made_up("laplacian", [1, 4], [1, 0.25]), made_up("crossfade", [0.5, 2, 4], [9, 1, 0.125]))
    )
    np.testing.assert_allclose(t.advantage(trade, "crossfade"), [np.nan, 2.0, 0.5])
    assert "| crossfade | width 2 | 1 (1) | 1 (1) | 2 (2) |" in t.as_markdown(trade)
    assert t.as_markdown(trade).count("\n") == 2 + 5


@pytest.mark.parametrize("suffix", [".png", ".svg"])
def test_the_picture_is_written(small: t.TradeOff, tmp_path: Path, suffix: str):
    t.plot_trade_off(small, tmp_path / f"curves{suffix}")
    assert (tmp_path / f"curves{suffix}").stat().st_size > 5000


def test_on_real_clips_ours_adds_less_wherever_it_changes_as_much():
    root = os.environ.get("KINESTITCH_DATA")
    if not root:
        pytest.skip("KINESTITCH_DATA, the folder of real clips, is not set")
    trade = t.trade_off(read_clips(Path(root) / "mixamo_xbot_60fps"), "mixamo", seams=30)
    for rival in trade.curves[1:]:
        versus = t.advantage(trade, rival.name)
        wide = rival.percentile("deviation") > 1.0
        assert np.nanmin(versus[wide]) > 1.2, rival.name
