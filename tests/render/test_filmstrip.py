"""The filmstrip: rows, poses, words, suffixes, and bodies of every kind."""

from __future__ import annotations

import itertools
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_identity
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import OutputError, ParameterError, RangeError, UnsupportedFormatError
from kinestitch.render.filmstrip import Stretch, filmstrip, filmstrip_figure
from kinestitch.samples import sample
from kinestitch.testing import random_motion


def poses(axes) -> list[int]:
    found = (artist.get_gid() or "" for artist in axes.collections)
    return [int(gid.removeprefix("pose ")) for gid in found if gid.startswith("pose ")]


def words(axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def single_joint() -> Motion:
    return Motion(Skeleton(("Root",), (-1,), [[0, 0, 0]]), np.zeros((1, 1, 3)), quat_identity((1, 1)), 30.0, "dot")


@pytest.mark.parametrize(
    ("suffix", "start"), [(".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF"), (".PNG", b"\x89PNG")]
)
def test_writes_the_format_of_the_suffix(tmp_path, suffix, start):
    path = tmp_path / f"strip{suffix}"
    filmstrip(sample("idle"), path, poses=3)
    assert path.read_bytes().startswith(start)
    assert [entry.name for entry in tmp_path.iterdir()] == [path.name]


def test_one_row_a_motion_and_one_figure_a_pose():
    figure = filmstrip_figure([sample("walk"), sample("kick")], poses=7, labels=["A", "B"])
    assert len(figure.axes) == 2
    assert poses(figure.axes[0]) == [0, 33, 67, 100, 133, 167, 200]
    assert poses(figure.axes[1]) == [0, 25, 50, 75, 100, 125, 150]
    assert words(figure.axes[0]) == [*map(str, poses(figure.axes[0])), "A"]


def test_poses_can_be_named():
    figure = filmstrip_figure(sample("kick"), poses=[60, 0, 60, 30])
    assert poses(figure.axes[0]) == [0, 30, 60]


def test_fewer_frames_than_poses():
    short = sample("idle")
    short = replace(short, rotations=short.rotations[:3], translations=short.translations[:3])
    assert poses(filmstrip_figure(short, poses=9).axes[0]) == [0, 1, 2]


def test_svg_keeps_text_as_text_and_is_the_same_every_time(tmp_path):
    once, twice = tmp_path / "a.svg", tmp_path / "b.svg"
    for path in (once, twice):
        filmstrip(
            sample("walk"),
            path,
            poses=4,
            labels=["walk & kick"],
            title="A title",
            marks=[[60]],
            segments=[[(60, 120, "pasted from kick")]],
        )
    text = once.read_text()
    for word in ("walk &amp; kick", "A title", "pasted from kick", ">200<"):
        assert word in text
    assert 'id="pose 200"' in text
    assert once.read_bytes() == twice.read_bytes()


def test_segments_and_marks_stand_where_their_frames_are():
    figure = filmstrip_figure(
        sample("walk"), poses=[0, 100, 200], marks=[[50]], segments=[[Stretch(50, 150, "kick", "#123456"), (150, 201)]]
    )
    axes = figure.axes[0]
    seam = next(line for line in axes.lines if line.get_linestyle() not in ("-", "None"))
    zero, hundred = (next(t.get_position()[0] for t in axes.texts if t.get_text() == n) for n in ("0", "100"))
    assert seam.get_xdata()[0] == pytest.approx((zero + hundred) / 2)
    assert "kick" in words(axes)
    assert any(line.get_color() == "#123456" for line in axes.lines)


def extent(figure) -> tuple[np.ndarray, np.ndarray]:
    """All words and all bodies as boxes (N, 4) in pixels."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    renderer = FigureCanvasAgg(figure).get_renderer()
    texts = [text.get_window_extent(renderer).extents for axes in figure.axes for text in axes.texts]
    texts += [text.get_window_extent(renderer).extents for text in figure.texts]
    bodies = [
        np.concatenate([axes.transData.transform(path.vertices) for path in artist.get_paths()])
        for axes in figure.axes
        for artist in axes.collections
        if (artist.get_gid() or "").startswith("pose")
    ]
    return np.array(texts), np.array([[*body.min(axis=0), *body.max(axis=0)] for body in bodies])


@pytest.mark.parametrize("travel", [False, True])
@pytest.mark.parametrize("view", ["front", "side", "three-quarter", "back", 30.0])
@pytest.mark.parametrize("name", ["walk", "jump", "jumping_jacks", "kick"])
def test_nothing_is_cut_off(name, view, travel):
    figure = filmstrip_figure(
        sample(name), poses=6, view=view, travel=travel, title="Title", segments=[[(10, 40, "a pasted segment")]]
    )
    width, height = figure.get_size_inches() * figure.dpi
    for boxes in extent(figure):
        assert (boxes[:, :2] >= -0.5).all()
        assert (boxes[:, 2] <= width + 0.5).all()
        assert (boxes[:, 3] <= height + 0.5).all()


def test_long_words_are_cut_short_in_the_middle():
    name = "a very long name of a clip " * 12 + "end"
    figure = filmstrip_figure(
        sample("kick"), poses=3, labels=[name], title=name, segments=[[(0, 8, name), (140, 151, "far to the right")]]
    )
    width, _ = figure.get_size_inches() * figure.dpi
    texts, _ = extent(figure)
    assert (texts[:, 0] >= 0).all()
    assert (texts[:, 2] <= width).all()
    assert all("…" in word and word.endswith("end") for word in words(figure.axes[0]) if len(word) > 30)


@pytest.mark.parametrize(
    "motion",
    [single_joint(), random_motion(3, joints=1), random_motion(4, joints=30, frames=2), random_motion(5, bend=6.0)],
    ids=["one joint, one frame", "one joint", "a tree", "a whirl"],
)
@pytest.mark.parametrize("travel", [False, True])
def test_any_skeleton_can_be_drawn(motion, travel, tmp_path):
    filmstrip(motion, tmp_path / "strip.png", travel=travel)
    assert poses(filmstrip_figure(motion).axes[0])[0] == 0


def test_numbers_never_lie_on_each_other():
    figure = filmstrip_figure(sample("idle"), travel=True, poses=9)
    texts, bodies = extent(figure)
    assert len(bodies) == 9
    numbers = sorted(
        tuple(box) for box, text in zip(texts, figure.axes[0].texts, strict=True) if text.get_text().isdigit()
    )
    assert all(left[2] < right[0] for left, right in itertools.pairwise(numbers))


def outlines(figure: Figure) -> float:
    poses = (artist for artist in figure.axes[0].collections if (artist.get_gid() or "").startswith("pose"))
    return max(float(np.max(artist.get_linewidths())) for artist in poses)


def test_small_figures_have_finer_outlines():
    walk = sample("walk")
    assert outlines(filmstrip_figure(walk, poses=9)) == 0.5
    assert outlines(filmstrip_figure(walk, poses=201)) < 0.12


@pytest.mark.parametrize("travel", [False, True])
def test_words_of_segments_stand_apart(travel):
    walk = sample("walk")
    stretches = [(0, 20, "Punching 0–19"), (20, 32, "walking 6–17"), (32, 44, "kick 3–14"), (90, 201, "run 0–110")]
    axes = filmstrip_figure(walk, segments=[stretches], travel=travel).axes[0]
    canvas = FigureCanvasAgg(axes.figure).get_renderer()
    words = [text for text in axes.texts if "–" in text.get_text()]
    assert words[0].get_text() == "run 0–110"
    assert len(words) < len(stretches)
    boxes = sorted((text.get_window_extent(canvas) for text in words), key=lambda box: box.x0)
    assert all(left.x1 < right.x0 for left, right in itertools.pairwise(boxes))


def test_rows_of_different_bodies_share_one_scale():
    """A body twice as large is drawn as large as the other."""
    small = sample("idle")
    body = small.skeleton
    large = replace(small, skeleton=replace(body, offsets=2 * body.offsets), translations=2 * small.translations)
    heights = [
        np.ptp(np.concatenate([path.vertices for path in axes.collections[-1].get_paths()])[:, 1])
        for axes in filmstrip_figure([small, large], poses=1).axes
    ]
    assert heights[0] == pytest.approx(heights[1], rel=1e-6)


def test_refusals(tmp_path):
    walk = sample("walk")
    with pytest.raises(UnsupportedFormatError, match=r"\.png, \.svg, \.pdf, got '\.gif'"):
        filmstrip(walk, tmp_path / "strip.gif")
    with pytest.raises(UnsupportedFormatError, match="no suffix"):
        filmstrip(walk, tmp_path / "strip")
    with pytest.raises(OutputError):
        filmstrip(walk, tmp_path / "absent" / "strip.png")
    for options in ({"poses": 0}, {"poses": []}, {"view": "above"}, {"labels": ["a", "b"]}, {"marks": []}):
        with pytest.raises(ParameterError):
            filmstrip_figure(walk, **options)
    with pytest.raises(ParameterError, match="at least one motion"):
        filmstrip_figure([])
    for options in ({"poses": [201]}, {"marks": [[-1]]}, {"segments": [[(0, 202)]]}):
        with pytest.raises(RangeError, match="201"):
            filmstrip_figure(walk, **options)


def test_a_failed_drawing_leaves_the_old_picture(tmp_path):
    path = tmp_path / "strip.png"
    path.write_bytes(b"old")
    with pytest.raises(ParameterError):
        filmstrip(sample("walk"), path, view="above")
    assert path.read_bytes() == b"old"


def test_matplotlib_comes_late_and_pyplot_never():
    script = (
        "import sys, kinestitch.render.filmstrip as f; assert 'matplotlib' not in sys.modules;"
        "from kinestitch.samples import sample; f._rendered(f.filmstrip_figure(sample('idle'), poses=2), 'png');"
        "print('matplotlib.pyplot' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "False"


def test_real_clips_have_a_trunk_limbs_and_a_head(real_clip, tmp_path):
    names = ("mixamo_xbot_60fps/Kicking.fbx", "bandai/dataset-1_walk_normal_001.bvh", "cmu/02_01.bvh")
    figure = filmstrip_figure([real_clip(name) for name in names], poses=4)
    for axes in figure.axes:
        shapes = next(artist for artist in axes.collections if (artist.get_gid() or "").startswith("pose"))
        assert len(shapes.get_paths()) > 14
        assert re.match("row ", axes.get_gid())
