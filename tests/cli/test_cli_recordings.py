"""``info`` on a recording of markers."""

from __future__ import annotations

import json

import numpy as np
import pytest

ezc3d = pytest.importorskip("ezc3d", reason="ezc3d, of the extra c3d, is not installed")


@pytest.fixture(autouse=True)
def trial(tmp_path):
    content = ezc3d.c3d()
    content["parameters"]["POINT"]["RATE"]["value"] = [100]
    content["parameters"]["POINT"]["LABELS"]["value"] = ["HEAD", "HAND"]
    content["parameters"]["ANALOG"]["RATE"]["value"] = [200]
    content["parameters"]["ANALOG"]["LABELS"]["value"] = ["EMG 1"]
    content["parameters"]["ANALOG"]["UNITS"]["value"] = ["mV"]
    points = np.ones((4, 2, 5))
    points[:3, 1, 0] = np.nan
    content["data"]["points"] = points
    content["data"]["analogs"] = np.zeros((1, 1, 10))
    content.write(str(tmp_path / "trial.c3d"))


def test_a_block(kinestitch):
    ran = kinestitch("info", "trial.c3d")
    assert (ran.code, ran.err) == (0, "")
    assert "2, 5 frames at 100 a second, 90.0% seen" in ran.out
    assert "HEAD, HAND" in ran.out
    assert "1, 10 samples at 200 a second" in ran.out
    assert "EMG 1 (mV)" in ran.out


def test_json_beside_a_clip(kinestitch, clip):
    clip("walk.bvh")
    ran = kinestitch("info", "--json", "trial.c3d", "walk.bvh")
    told = json.loads(ran.out)
    assert [entry["file"] for entry in told] == ["walk.bvh", "trial.c3d"]
    assert told[1]["marker_names"] == ["HEAD", "HAND"]
    assert (told[1]["seen"], told[1]["channel_rate"]) == (0.9, 200.0)


def test_a_damaged_one_is_one_line(kinestitch, tmp_path):
    (tmp_path / "bad.c3d").write_bytes(b"\x02P" + bytes(600))
    assert "bad.c3d" in kinestitch("info", "bad.c3d").error


def test_a_clip_is_wanted_elsewhere(kinestitch):
    assert "Use read_recording" in kinestitch("convert", "trial.c3d", "out.bvh").error
