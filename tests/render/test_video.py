"""The video: what the file holds, which frame each picture shows, the camera, the marks, and what is refused."""

from __future__ import annotations

import sys
from dataclasses import replace

import numpy as np
import pytest

from kinestitch.core.kinematics import turn_about_up
from kinestitch.errors import MissingExtraError, OutputError, ParameterError, RangeError, UnsupportedFormatError
from kinestitch.render.mannequin import feet
from kinestitch.render.paint import COLOURS, PASTED, SEAM, STANDS
from kinestitch.render.stage import FLOOR, grid_step
from kinestitch.render.video import film, pictures, video
from kinestitch.samples import sample
from kinestitch.solve.contacts import Contacts, find_contacts
from kinestitch.testing import random_motion

SMALL = (320, 240)


@pytest.fixture
def av():
    return pytest.importorskip("av", reason="the extra kinestitch[video] is not installed")


def short(name, frames=12, fps=60.0):
    motion = sample(name, fps=fps)
    return replace(motion, rotations=motion.rotations[:frames], translations=motion.translations[:frames])


def colour(text: str) -> np.ndarray:
    return np.array([int(text[i : i + 2], 16) for i in (1, 3, 5)])


def near(picture: np.ndarray, text: str, within: int = 6) -> int:
    """How many pixels have a colour."""
    return int((np.abs(picture[..., :3].astype(int) - colour(text)).max(axis=-1) <= within).sum())


@pytest.mark.parametrize(
    ("fps", "speed", "count", "rate"),
    [(None, 1.0, 12, 60), (30, 1.0, 6, 30), (24, 0.5, 10, 24), (60, 0.25, 48, 60), (29.97, 1.0, 6, 29.97)],
)
def test_the_file_decodes_to_what_was_asked_for(tmp_path, av, fps, speed, count, rate):
    path = tmp_path / "a.mp4"
    video([short("walk"), short("kick")], path, size=SMALL, fps=fps, speed=speed)
    with av.open(str(path)) as container:
        track = container.streams.video[0]
        assert (track.codec_context.name, track.codec_context.pix_fmt) == ("h264", "yuv420p")
        assert float(track.average_rate) == pytest.approx(rate, rel=1e-5)
        frames = [frame.to_ndarray(format="rgb24") for frame in container.decode(video=0)]
    assert len(frames) == count
    assert all(frame.shape == (240, 320, 3) for frame in frames)
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.mp4"]
    data = path.read_bytes()
    assert data.index(b"moov") < data.index(b"mdat")  # plays before all of it is loaded


def test_decoded_colours_are_those_that_were_drawn(tmp_path, av):
    motion = short("walk")
    video(motion, tmp_path / "a.mp4", size=(640, 480))
    with av.open(str(tmp_path / "a.mp4")) as container:
        decoded = next(container.decode(video=0)).to_ndarray(format="rgb24")
    drawn = next(pictures(film(motion, size=(640, 480))))
    for text in (COLOURS["right"], COLOURS["torso"]):
        assert near(decoded, text, within=10) > 0.8 * near(drawn, text) > 400
    assert np.abs(decoded.astype(int) - drawn[..., :3]).mean() < 1.0


def test_progress_counts_pictures(tmp_path, av):
    told = []
    video(short("walk"), tmp_path / "a.mp4", size=SMALL, progress=lambda done, count: told.append((done, count)))
    assert told == [(done, 12) for done in range(1, 13)]


def test_left_is_blue_and_right_is_orange():
    picture = next(pictures(film(sample("idle"), size=SMALL, view="front")))
    columns = np.arange(320)
    left, right = (
        (columns * (np.abs(picture[..., :3].astype(int) - colour(COLOURS[side])).max(axis=-1) < 6)).sum()
        / near(picture, COLOURS[side])
        for side in ("left", "right")
    )
    assert left > 160 > right


def test_a_motion_that_ends_holds_its_last_pose():
    long, brief = sample("idle"), short("kick", frames=3)
    shown = [picture.copy() for picture in pictures(film([brief, long], size=SMALL, fps=10))]
    assert len(shown) == film(long, fps=10).count
    assert np.array_equal(shown[2][:, :150], shown[-1][:, :150])
    assert not np.array_equal(shown[2][:, 170:], shown[-1][:, 170:])


def test_motions_of_different_rates_keep_time():
    made = film([short("walk", frames=60), short("walk", frames=30, fps=30.0)], size=SMALL)
    assert (made.fps, made.count) == (60.0, 60)
    shown = [picture.copy() for picture in pictures(made)]
    halves = [np.abs(picture[40:200, :160].astype(int) - picture[40:200, 160:]).mean() for picture in shown[::2]]
    assert max(halves) < 3.0  # twice the same pose, up to the camera's smoothing


def test_the_ground_glows_at_seams_and_is_tinted_where_something_was_pasted():
    made = film(sample("walk"), size=SMALL, seams=[60], segments=[[(60, 120, "kick 0–59")]], fps=60)
    shown = {n: picture.copy() for n, picture in enumerate(pictures(made)) if n in (30, 59, 60, 65, 119, 120)}
    glowing = {n: near(picture, SEAM, 50) for n, picture in shown.items()}
    assert glowing[60] > 10 * glowing[59]
    assert glowing[60] > glowing[65] > glowing[119]
    words = {n: near(picture[14:30], PASTED[0], 60) for n, picture in shown.items()}
    assert (words[59], words[120]) == (0, 0)
    assert min(words[60], words[119]) > 10
    assert near(shown[30], FLOOR) > 1000 > near(shown[119], FLOOR)


def test_the_grid_passes_under_a_camera_that_follows():
    made = film(sample("walk"), size=SMALL)
    figure = [picture.copy() for n, picture in enumerate(pictures(made)) if n % 40 == 20]
    panel = made.panels[0]
    assert np.ptp(panel.actor.path[:, 2]) > 4.0  # m walked
    for picture in figure:
        torso = np.abs(picture[..., :3].astype(int) - colour(COLOURS["torso"])).max(axis=-1) < 6
        assert abs(np.nonzero(torso)[1].mean() - 160) < 15
    floors = [picture[200:214, 40:280] for picture in figure]
    assert not np.array_equal(floors[0], floors[1])


def test_one_camera_for_motions_of_one_rig_and_length_and_one_each_for_others():
    walk = sample("walk")
    moved = turn_about_up(walk, 0.0, (0.3, 0.0, 0.0))
    actors = [panel.actor for panel in film([walk, moved]).panels]
    assert actors[0].path is actors[1].path
    assert actors[0].camera.project(np.ones(3)) == pytest.approx(actors[1].camera.project(np.ones(3)))
    others = [panel.actor for panel in film([walk, sample("run")]).panels]
    assert others[0].path is not others[1].path


@pytest.mark.parametrize("name", ["walk", "run", "jump", "jumping_jacks", "kick", "heavy_punch"])
@pytest.mark.parametrize("size", [(960, 540), (240, 400)])
def test_no_body_leaves_its_panel(name, size):
    for panel in film([sample(name), sample("idle")], size=size).panels:
        side, up = panel.actor.extent()
        assert side * panel.unit <= panel.width / 2
        assert panel.origin[1] + up * panel.unit <= size[1] * 0.95


def test_the_feet_leave_trails():
    body = sample("walk").skeleton
    assert [(body.names[joint], side) for joint, side in feet(body)] == [
        ("mixamorig:LeftToeBase", "left"),
        ("mixamorig:RightToeBase", "right"),
    ]


@pytest.mark.parametrize("style", ["mannequin", "skeleton"])
def test_feet_are_green_while_they_stand(style):
    motion = short("walk", frames=30)
    joints = find_contacts(motion).joints
    held = np.zeros((30, len(joints)), dtype=bool)
    held[10:20, :2] = True  # ankle and toe of the left foot
    held[25:, 1] = True
    made = film(motion, size=(480, 540), contacts=[Contacts(joints, held)], style=style)
    legend = near(next(pictures(film(short("walk", frames=1), contacts=[Contacts(joints, held[:1])]))), STANDS)
    green = [near(picture, STANDS) for picture in pictures(made)]
    assert 0 < legend < 100
    assert set(green[:10]) == set(green[20:25]) == {green[0]}
    assert min(green[10:20]) > max(green[25:]) > green[0] + 10
    assert all(near(picture, STANDS) == 0 for picture in pictures(film(motion, size=(480, 540), style=style)))


def test_a_skeleton_is_thinner_than_a_mannequin():
    """By more than half: how many pixels are neither ground nor paper, above the ground."""
    body, bare = (
        (next(pictures(film(sample("idle"), size=(480, 540), style=style)))[80:340, :, :3] < 250).any(axis=-1).sum()
        for style in ("mannequin", "skeleton")
    )
    assert 500 < bare < 0.5 * body


@pytest.mark.parametrize(("height", "step"), [(1.75, 0.5), (0.17, 0.05), (180.0, 50.0), (2.2, 1.0)])
def test_the_grid_is_a_round_number(height, step):
    assert grid_step(height) == pytest.approx(step)


@pytest.mark.parametrize("joints", [1, 2, 30])
def test_any_skeleton_can_be_shown(joints):
    made = film(random_motion(1, joints=joints, frames=2, bend=5.0), size=(64, 64))
    assert sum(1 for _ in pictures(made)) == 2


def test_the_same_pictures_every_time():
    once, twice = ([p.copy() for p in pictures(film(short("kick"), size=SMALL))] for _ in range(2))
    assert all(np.array_equal(a, b) for a, b in zip(once, twice, strict=True))


@pytest.mark.parametrize(
    ("options", "error", "words"),
    [
        ({"size": (321, 240)}, ParameterError, "321x240"),
        ({"size": (32, 240)}, ParameterError, "32x240"),
        ({"fps": 0.0}, ParameterError, "fps"),
        ({"fps": float("nan")}, ParameterError, "fps"),
        ({"speed": -1.0}, ParameterError, "speed"),
        ({"view": "below"}, ParameterError, "below"),
        ({"labels": ["a", "b"]}, ParameterError, "labels"),
        ({"seams": [[1], [2]]}, ParameterError, "seams"),
        ({"segments": []}, ParameterError, "segments"),
        ({"contacts": []}, ParameterError, "contacts"),
        ({"contacts": [Contacts((0,), np.zeros((9, 1)))]}, ParameterError, "contacts for 12 frames, got 9"),
        ({"style": "stick"}, ParameterError, "mannequin, skeleton"),
        ({"seams": [13]}, RangeError, "13"),
        ({"segments": [[(0, 99, "x")]]}, RangeError, "99"),
    ],
)
def test_what_is_refused(options, error, words):
    with pytest.raises(error, match=words):
        film(short("walk"), **options)


def test_no_motion_is_refused():
    with pytest.raises(ParameterError, match="at least one motion"):
        film([])


def test_other_suffixes_and_missing_folders_are_refused(tmp_path, av):
    with pytest.raises(UnsupportedFormatError, match=r"\.mp4"):
        video(short("walk"), tmp_path / "a.avi")
    with pytest.raises(OutputError):
        video(short("walk"), tmp_path / "nowhere" / "a.mp4", size=SMALL)
    assert list(tmp_path.iterdir()) == []


def test_what_breaks_half_way_leaves_no_file(tmp_path, av):
    def stop(done, count):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        video(short("walk"), tmp_path / "a.mp4", size=SMALL, progress=stop)
    assert list(tmp_path.iterdir()) == []


def test_without_the_extra_the_command_that_installs_it_is_told(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'kinestitch\[video\]'"):
        video(short("walk"), tmp_path / "a.mp4")


def test_no_window_system_is_touched():
    import subprocess

    code = """
import sys
from kinestitch.render.video import film, pictures
from kinestitch.samples import sample
from kinestitch.solve.contacts import Contacts, find_contacts
next(pictures(film(sample("idle"), size=(64, 64))))
print("matplotlib.pyplot" in sys.modules, "av" in sys.modules)
"""
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout == "False False\n"
