"""The table of locked feet: measured on the samples, and written whole."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinestitch.edit.operations import replace as paste
from kinestitch.edit.timeline import timeline
from kinestitch.experiments.feet import MEASURES, Feet, as_markdown, draw, main, measure
from kinestitch.files import write
from kinestitch.samples import sample
from kinestitch.solve.footlock import Locked, placed_contacts
from kinestitch.solve.stitch import solve_timeline

ROWS = list(MEASURES)


def walk_kick():
    clips = {name: sample(name) for name in ("walk", "kick")}
    return solve_timeline(paste(timeline(clips, "walk"), 84, 130, "kick", 30, 112), clips)


def test_locking_is_measured():
    found = measure(walk_kick())
    assert found.values.shape == (len(MEASURES), 3)
    assert 0.5 < found.kept <= 1.0
    assert 0.0 <= found.down < 6.0
    before, after, own = found.values[ROWS.index("slide")]
    assert after <= 1.01 * own
    assert after < 0.3 * before


def test_a_lock_that_does_nothing_changes_nothing():
    found = measure(walk_kick(), lambda solved: Locked(solved.motion, placed_contacts(solved.placed)))
    assert np.array_equal(found.values[:, 0], found.values[:, 1])
    assert (found.kept, found.down) == (1.0, 0.0)


def test_half_of_the_seams_are_cuts():
    lines = draw({name: sample(name) for name in ("walk", "kick", "run")}, 8, 0)
    assert [len(line.seams) for line in lines] == [1, 1, 1, 1, 2, 2]
    assert lines == draw({name: sample(name) for name in ("walk", "kick", "run")}, 8, 0)
    assert lines != draw({name: sample(name) for name in ("walk", "kick", "run")}, 8, 1)


def test_the_document_has_every_row():
    feet = Feet(np.arange(3.0 * len(MEASURES)).reshape(-1, 3), 0.9, 1.5)
    silent = replace(feet, values=np.where(np.arange(3) == 2, np.nan, feet.values))
    told = as_markdown({"walk": feet}, {"set": {"random": [feet, silent]}}, "# Head\n")
    assert told.startswith("# Head\n| walk | 0.00 | 1.00 | 2.00 | 3.00 |")
    for label in MEASURES.values():
        assert f"| {label} | " in told
    assert "90.0% of the contacts are kept" in told


def test_it_runs_on_a_folder(tmp_path):
    for data_set in ("mixamo_xbot_60fps", "bandai"):
        (tmp_path / data_set).mkdir()
        for name in ("walk", "kick"):
            write(sample(name, fps=30), tmp_path / data_set / f"{name}.bvh")
    main([str(tmp_path), "-o", str(tmp_path / "out.md"), "--seams", "4"])
    told = (tmp_path / "out.md").read_text(encoding="utf-8")
    assert told.count("snapped cuts") == 2
    assert "nan" not in told


BOUNDS = {
    "slide": (1.05, 1.02),
    "skate": (4.0, 3.6),
    "ankles": (1.1, 1.1),
    "knees": (1.1, 1.1),
    "thighs": (1.1, 1.1),
}
"""What docs/feet.md says of the table: median and mean after locking, over the clips' own."""


@pytest.mark.parametrize("name", BOUNDS)
def test_the_table_keeps_to_what_is_said_of_it(name: str):
    table = (Path(__file__).parents[2] / "docs" / "feet_table.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in table.splitlines() if line.startswith(f"| {MEASURES[name]} |")]
    assert len(rows) == 4
    for row in rows:
        before, after, own = ([float(value) for value in cell.split("/")] for cell in row[2:5])
        assert after[0] <= BOUNDS[name][0] * own[0]
        assert after[1] <= BOUNDS[name][1] * own[1]
        if name in ("slide", "skate"):
            assert after[0] < (0.6 if name == "slide" else 0.4) * before[0]


def test_feet_hardly_sink_in_the_table():
    table = (Path(__file__).parents[2] / "docs" / "feet_table.md").read_text(encoding="utf-8")
    rows = [line.split("|") for line in table.splitlines() if line.startswith(f"| {MEASURES['sink']} |")]
    assert len(rows) == 4
    for row in rows:
        before, after = ([float(value) for value in cell.split("/")] for cell in row[2:4])
        assert after[1] <= 0.5
        assert 1.0 < before[1] < 3.0
