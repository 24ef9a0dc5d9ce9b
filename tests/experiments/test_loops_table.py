"""The figures of docs/loops.md are what their words say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import kinestitch as ks
from kinestitch.analysis.cycle import GATES
from kinestitch.core.rotation import quat_distance
from kinestitch.experiments import loops
from kinestitch.experiments.seams import DATA_SETS
from kinestitch.files import write
from kinestitch.search.cycle import whole_cycle
from kinestitch.solve.loop import solve_loop


def part(name: str, start: int, stop: int) -> ks.Motion:
    clip = ks.sample(name, fps=30)
    return replace(clip, rotations=clip.rotations[start:stop], translations=clip.translations[start:stop])


def test_the_rival_shares_the_gap_out_evenly():
    clip = part("walk", 5, 75)
    looped = solve_loop(clip, 2, 60)
    spread = loops.spread_evenly(clip, looped).motion
    assert quat_distance(spread.rotations[0, 1:], spread.rotations[-1, 1:]).max() < 1e-7
    gap = quat_distance(clip.rotations[60], clip.rotations[2])
    moved = quat_distance(spread.rotations, looped.cut.rotations)[:-1]
    wanted = np.abs(np.arange(58) / 58 - 0.5)[:, None] * gap
    np.testing.assert_allclose(moved[:, 1:], wanted[:, 1:], atol=1e-6)
    ways = [np.diff(m.translations[:-1, 0, [0, 2]], axis=0) for m in (spread, looped.cut)]
    np.testing.assert_allclose(ways[0], ways[1], atol=1e-12)


def test_every_method_measures_the_same_frames():
    row = loops.measured("walk", part("walk", 5, 75), whole_cycle)
    assert tuple(row.numbers) == loops.METHODS
    assert row.share == pytest.approx(69 / 70)
    cut, solved = row.numbers["cut"], row.numbers["solved"]
    assert cut.angular_velocity_step_deg_s > 500 > 100 > solved.angular_velocity_step_deg_s
    assert loops.kept([row], "cut") == 0
    assert loops.kept([row, row], "solved", "rotation_step_deg") == 2


def test_names_tell_what_repeats():
    names = ("Walk Forward", "dataset-1_dash_active_001.bvh", "Idle.fbx", "Side Kick", "Jumping Down")
    assert [loops.repeats(name) for name in names] == [True, True, True, False, False]


def test_the_section_is_written_and_the_text_before_it_stays(tmp_path):
    for folder in DATA_SETS:
        (tmp_path / folder).mkdir()
        for name in ("walk", "kick"):
            write(part(name, 5, 75), tmp_path / folder / f"{name}.bvh")
    page = tmp_path / "loops.md"
    page.write_text(f"# Loops\n\nWords.\n\n{loops.HEADING}\n\nold figures\n", encoding="utf-8")
    loops.main([str(tmp_path), "-o", str(page)])
    text = page.read_text(encoding="utf-8")
    assert text.startswith(f"# Loops\n\nWords.\n\n{loops.HEADING}\n")
    assert "old figures" not in text
    assert all(text.count(f"| `{gate}` |") == 2 for gate in GATES)
    assert f"| {DATA_SETS[0]}, gaits and idle | best | 1 |" in text
    assert "nan" not in text
    assert str(tmp_path) not in text
