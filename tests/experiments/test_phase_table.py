"""The tables of steps across seams, on the samples."""

from __future__ import annotations

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.experiments.phase import MARKS, WAYS, as_markdown, crossing, filled, slowed, stepping, survey
from kinestitch.testing import random_motion

CLIPS = {name: ks.sample(name, fps=30.0) for name in ("walk", "run", "idle", "jump")}


@pytest.fixture(scope="module")
def found():
    return survey(stepping(CLIPS), 4, 0)


def test_which_clips_step():
    named = CLIPS | {"standing walk": CLIPS["idle"], "robot walk": random_motion(0)}
    assert sorted(stepping(named)) == ["run", "walk"]


def test_every_seam_in_all_ways(found):
    assert list(found) == list(WAYS)
    gaps = {way: np.array([abs(one.gap) for one in crossings]) for way, crossings in found.items()}
    cut, _, aligned, warped, both = gaps.values()
    assert (aligned <= np.maximum(cut, np.radians(10)) + 1e-9).all()
    assert (warped <= cut + 1e-6).all()
    assert (both <= aligned + 1e-6).all()


def test_a_walk_that_goes_on_keeps_its_step():
    line = ks.append(ks.delete(ks.timeline(CLIPS, "walk"), 60, 101), "walk", 27)
    one = crossing(line, CLIPS)
    assert one.alternate
    assert one.interval == pytest.approx(1.0, abs=0.1)
    assert abs(one.gap) < 0.2


def test_straight_lines_double_the_acceleration_at_half_speed():
    numbers = slowed(CLIPS["walk"])
    assert numbers.lines == pytest.approx(2.0, rel=0.01)
    assert numbers.ours < 1.5
    assert numbers.jerk < 0.5


def test_the_tables_take_the_place_between_the_marks(found):
    text = as_markdown({"samples": (stepping(CLIPS), found)}, {"samples": [slowed(CLIPS["walk"])]}, 0)
    lines = text.splitlines()
    assert sum(line.startswith("| ") for line in lines) == 1 + len(WAYS) + 2
    page = f"before\n{MARKS[0]}\nold\n{MARKS[1]}\nafter\n"
    new = filled(page, text)
    assert text in new
    assert "old" not in new
    assert new.startswith("before\n")
    assert new.endswith("after\n")
    assert filled(new, text) == new
    with pytest.raises(ValueError, match="marks"):
        filled("no marks", text)
