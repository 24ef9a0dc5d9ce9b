"""The table of features: what it measures, on seams whose values are known, and the document."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_about_axis
from kinestitch.core.skeleton import Skeleton
from kinestitch.edit.timeline import ClipInfo, FrameRange, Seam, Segment, Timeline
from kinestitch.experiments import features as f
from kinestitch.experiments import features_page as page
from kinestitch.files import write
from kinestitch.samples import SAMPLE_NAMES, humanoid, sample
from kinestitch.solve.contacts import Contacts, find_contacts
from kinestitch.solve.footlock import placed_contacts
from kinestitch.solve.stitch import solve_timeline

RATE = 30.0


@pytest.fixture(scope="module")
def clips() -> dict[str, Motion]:
    return {name: sample(name, fps=RATE) for name in SAMPLE_NAMES}


@pytest.fixture(scope="module")
def small(clips) -> f.Survey:
    return f.survey(clips, "samples", seams=5, seed=3)


def joined(left: Motion, right: Motion, out: int, into: int, seam: Seam | None = None) -> tuple[Timeline, f.Clips]:
    infos = (ClipInfo("a", left.frames, left.fps), ClipInfo("b", right.frames, right.fps))
    segments = (Segment("a", FrameRange(0, out)), Segment("b", FrameRange(into, right.frames)))
    return Timeline(infos, segments, (seam or Seam(),), left.fps), {"a": left, "b": right}


def values(rows: dict[str, list[list[float]]], row: str) -> dict[str, float]:
    (found,) = rows[row]
    return dict(zip(f.MEASURES, found, strict=True))


def test_every_row_has_every_measure_at_every_seam(small: f.Survey):
    assert set(small.values) == {"random", "snapped"}
    for rows in small.values.values():
        assert list(rows) == [f.SOURCES, *f.FEATURES]
        assert all(found.shape == (5, len(f.MEASURES)) for found in rows.values())
        assert all(np.isfinite(rows[name][:, :-4]).all() for name in f.FEATURES)
        assert np.isnan(rows["solved"][:, -2:]).all()


def test_a_hard_cut_changes_nothing_and_pops(small: f.Survey):
    for cuts in f.CUTS:
        np.testing.assert_allclose(small.of(cuts, "hard cut", "deviation_max"), 0.0, atol=1e-9)
        hard, solved = (small.of(cuts, row, "acceleration") for row in ("hard cut", "solved"))
        assert np.all(hard > 3 * solved)


def test_a_price_belongs_to_the_cut_and_falls_by_snapping(small: f.Survey):
    for cuts in f.CUTS:
        stays = [row for row in f.FEATURES if row not in {"steps aligned", "everything on"}]
        prices = [small.of(cuts, row, "price") for row in stays]
        assert all(np.array_equal(prices[0], price) for price in prices)
    assert np.median(small.of("snapped", "solved", "price")) < np.median(small.of("random", "solved", "price"))


def test_locked_feet_slide_about_as_little_as_in_the_clips(small: f.Survey):
    own, solved, kept = (small.of("random", row, "skate") for row in (f.SOURCES, "solved", "solved, feet locked"))
    assert np.nanmean(kept - own) < 0.25 * np.nanmean(solved - own)
    stances, hovering = (small.of("random", "solved, feet locked", name) for name in ("stances", "hovering"))
    assert 0 < np.nanmin(stances) <= np.nanmax(stances) <= 100
    assert 0 <= np.nanmin(hovering) <= np.nanmax(hovering) < 2


def test_it_is_repeatable_by_its_seed(clips, small: f.Survey):
    told: list[tuple[int, int]] = []
    again = f.survey(clips, "samples", seams=5, seed=3, progress=lambda done, of: told.append((done, of)))
    assert told == [(n, 5) for n in range(1, 6)]
    for cuts, rows in small.values.items():
        for row, found in rows.items():
            np.testing.assert_array_equal(found, again.values[cuts][row])
    other = f.survey(clips, "samples", seams=1, seed=4)
    assert np.any(other.of("random", "solved", "price") != small.of("random", "solved", "price")[:1])


def test_replacements_have_two_seams_each(clips):
    plain = {"solved": f.FEATURES["solved"]}
    found = f.survey(clips, "samples", seams=3, draw="replacements", features=plain)
    assert found.values["random"]["solved"].shape == (4, len(f.MEASURES))


SPIN, GAP, BEND = 1.0, 0.3, 4.0


def turning(start: float, frames: int = 400) -> Motion:
    """The samples' body at rest, an arm of which turns ever faster about X: constant acceleration `BEND` rad/s²."""
    body: Skeleton = humanoid()
    time = np.arange(frames) / RATE
    rotations = np.broadcast_to(body.rest, (frames, body.joint_count, 4)).copy()
    arm = body.index("mixamorig:LeftForeArm")
    rotations[:, arm] = quat_about_axis(0, start + SPIN * (time - 200 / RATE) + BEND / 2 * (time - 200 / RATE) ** 2)
    return Motion(body, np.broadcast_to(body.offsets, (frames, body.joint_count, 3)), rotations, RATE)


def test_the_closed_forms_over_a_gap_between_two_turning_arms():
    """Both arms turn alike, one `GAP` ahead: what is added is what the solve adds to a gap, over the turn's own."""
    stiffness = 1e4
    line, clips = joined(turning(0.0), turning(GAP), 200, 200, Seam(stiffness=stiffness))
    rows = f.measure(line, clips)
    found = values(rows, "solved")
    assert found["acceleration"] == pytest.approx(0.161 * GAP / np.sqrt(stiffness) * RATE**2 / BEND, rel=0.03)
    fastest = np.percentile(SPIN + BEND * (np.arange(-29, 30) / RATE), 95)
    steepest = GAP / (2 * np.sqrt(2) * stiffness**0.25) * RATE
    assert found["velocity"] == pytest.approx(steepest / fastest, rel=0.05)
    assert found["kept"] == pytest.approx(1.0, abs=1e-2)
    hard = values(rows, "hard cut")
    assert hard["velocity"] == pytest.approx(GAP * RATE / fastest, rel=0.05)
    assert hard["acceleration"] == pytest.approx(GAP * RATE**2 / BEND, rel=0.05)
    assert hard["deviation_max"] == pytest.approx(0.0, abs=1e-9)
    assert found["deviation_max"] == pytest.approx(np.degrees(GAP - steepest / RATE) / 2, rel=0.01)


def test_a_clip_cut_and_put_back_has_no_seam():
    walk = sample("walk", fps=RATE)
    line, clips = joined(walk, replace(walk, name="again"), 30, 30)
    rows = f.measure(line, clips)
    own = values(rows, f.SOURCES)
    for row in ("hard cut", "crossfade", "solved"):
        found = values(rows, row)
        assert max(found[name] for name in ("price", "acceleration", "velocity", "deviation_max")) < 1e-6
        assert found["kept"] == pytest.approx(1.0, abs=1e-6)
        assert found["root_step"] == pytest.approx(own["root_step"], rel=1e-6)
    assert values(rows, "solved, feet locked")["stances"] > 90


def test_nothing_stands_in_the_air():
    """A body that is carried through the air has no contact, and so no skate to be told."""
    moving = turning(0.0)
    places = moving.translations.copy()
    places[:, 0, 2] += np.arange(moving.frames) * 0.1
    line, clips = joined(*(replace(moving, translations=places),) * 2, 200, 100)
    rows = f.measure(line, clips, {"locked": f.FEATURES["solved, feet locked"]})
    assert all(np.isnan(values(rows, "locked")[name]) for name in ("skate", "stances", "hovering"))
    assert values(rows, f.SOURCES)["root_step"] == pytest.approx(100.0)


def test_stances_that_are_given_up_leave_the_body_without_support():
    walk = sample("walk", fps=RATE)
    line, clips = joined(walk, replace(walk, name="again"), 30, 30)

    def without(line: Timeline, clips: f.Clips):
        solved = solve_timeline(line, clips, foot_lock=True)
        held = placed_contacts(solved.placed).held.copy()
        held[20:26] = False
        return replace(solved, contacts=Contacts(solved.contacts.joints, held))

    found = values(f.measure(line, clips, {"without": without}), "without")
    own = find_contacts(walk).held[:60]
    assert own[20:26].any(axis=1).all()
    assert found["hovering"] == pytest.approx(6 / RATE)
    assert found["stances"] == pytest.approx(100 - 100 * own[20:26].sum() / own.sum())


def made_up(rows: dict[str, list[dict[str, float]]]) -> f.Survey:
    """A survey of given values; what is not given is 1."""
    found = {
        row: np.array([[seam.get(measure, 1.0) for measure in f.MEASURES] for seam in seams])
        for row, seams in rows.items()
    }
    return f.Survey("mine", 2, 4, 30.0, dict.fromkeys(f.CUTS, found))


def test_who_meets_the_aims():
    nan = float("nan")
    made = made_up(
        {
            f.SOURCES: [{}, {}, {}],
            "on": [
                {"acceleration": 0.25, "velocity": 1.0, "kept": 0.98, "skate": 1.05},
                {"acceleration": 0.26, "velocity": 1.1, "kept": 0.97, "skate": 1.2},
                {"acceleration": 0.1, "velocity": 0.5, "kept": 2.0, "skate": nan},
            ],
        }
    )
    np.testing.assert_array_equal(page.met(made, "random", "on"), [[1, 1, 1, 1], [0, 0, 0, 0], [1, 1, 1, nan]])
    text = page.as_markdown([made], seed=0)
    assert "| mine | snapped | on | 66.7% | 66.7% | 66.7% | 50.0% | 66.7% |" in text
    assert "- mine, on: acceleration ≤ 0.25 is missed (66.7%)" in text


def test_cells_name_the_worse_side():
    made = made_up({"on": [{"acceleration": x, "kept": x} for x in range(101)]})
    assert page._cell(made.of("random", "on", "acceleration"), "acceleration") == "50 / 95"
    assert page._cell(made.of("random", "on", "kept"), "kept") == "50 / 5"
    assert page._cell(np.array([np.nan]), "skate") == "–"
    assert page._cell(np.array([1e-14]), "deviation") == "0 / 0"


def test_the_program_writes_the_document(tmp_path, capsys):
    (tmp_path / "mine").mkdir()
    for name in ("walk", "kick", "jump"):
        write(sample(name, fps=20), tmp_path / "mine" / f"{name}.bvh")
    f.main([str(tmp_path), "-o", str(tmp_path / "page.md"), "--sets", "mine", "--seams", "2", "--seed", "1"])
    text = (tmp_path / "page.md").read_text(encoding="utf-8")
    assert "## mine\n\n3 clips, " in text
    assert "2 random cuts for each" in text
    for row in (f.SOURCES, *f.FEATURES):
        assert text.count(f"| {row} |") == (2 if row == f.SOURCES else 4)
    assert "mine: 2 of 2 seams" in capsys.readouterr().err
