"""C3D: files made here with another program's writer, byte orders, damaged files, and the table of real ones."""

import os
import sys
from pathlib import Path

import numpy as np
import pytest

from kinestitch import files
from kinestitch.errors import (
    FormatError,
    KinestitchError,
    KinestitchWarning,
    MissingExtraError,
    UnsupportedFormatError,
)
from kinestitch.files.c3d import read_c3d
from kinestitch.files.c3d_bytes import little_endian, processor
from kinestitch.files.isolated import Isolated

ezc3d = pytest.importorskip("ezc3d", reason="ezc3d, of the extra c3d, is not installed")
DATA = os.environ.get("KINESTITCH_DATA")
needs_data = pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")


def write(path, *, units="mm", screen=("+X", "+Z"), labels=("HEAD", "HAND"), analog=("EMG",), missing=()):
    """Two markers over five frames at 100 Hz, and a channel at 200 Hz."""
    content = ezc3d.c3d()
    point, channels = content["parameters"]["POINT"], content["parameters"]["ANALOG"]
    point["RATE"]["value"] = [100]
    point["LABELS"]["value"] = list(labels)
    content.add_parameter("POINT", "UNITS", [units] if units is not None else [])
    if screen:
        content.add_parameter("POINT", "X_SCREEN", [screen[0]])
        content.add_parameter("POINT", "Y_SCREEN", [screen[1]])
    channels["RATE"]["value"] = [200 if analog else 0]
    channels["LABELS"]["value"] = list(analog)
    channels["UNITS"]["value"] = ["V"] * len(analog)
    points = np.ones((4, 2, 5))
    points[:3, 0] = np.array([1000.0, 2000.0, 3000.0])[:, None]
    points[:3, 1] = np.arange(15).reshape(3, 5)
    for frame, marker in missing:
        points[:3, marker, frame] = np.nan
    content["data"]["points"] = points
    if analog:
        content["data"]["analogs"] = np.arange(10.0 * len(analog)).reshape(1, len(analog), 10)
    content.write(str(path))
    return path


def test_markers_and_channels(tmp_path):
    recording = files.read_recording(write(tmp_path / "trial.c3d"))
    assert recording.name == "trial"
    assert recording.marker_names == ("HEAD", "HAND")
    assert (recording.frames, recording.rate) == (5, 100.0)
    np.testing.assert_allclose(recording.markers[:, 0], [[1.0, 3.0, -2.0]] * 5)
    assert (recording.samples, recording.analog_rate) == (10, 200.0)
    assert (recording.analog_names, recording.analog_units) == (("EMG",), ("V",))
    np.testing.assert_allclose(recording.analog[:, 0], np.arange(10))


@pytest.mark.parametrize(
    ("screen", "expected"),
    [
        (None, [1, 3, -2]),
        (("+X", "+Z"), [1, 3, -2]),
        (("+Y", "+Z"), [2, 3, 1]),
        (("-X", "+Z"), [-1, 3, 2]),
        (("+X", "+Y"), [1, 2, 3]),
        (("+Z", "+Z"), [1, 3, -2]),
        (("+X", "-Z"), [1, -3, 2]),
        (("", "+Y"), [1, 2, 3]),
        (("", "up"), [1, 3, -2]),
    ],
)
def test_axes_of_the_screen(tmp_path, screen, expected):
    recording = read_c3d(write(tmp_path / "a.c3d", screen=screen))
    np.testing.assert_allclose(recording.markers[0, 0], expected)


@pytest.mark.parametrize(("units", "metres"), [("mm", 0.001), ("m", 1.0), ("CM ", 0.01), ("in", 0.0254), (None, 0.001)])
def test_units(tmp_path, units, metres):
    assert read_c3d(write(tmp_path / "a.c3d", units=units)).markers[0, 0, 0] == pytest.approx(1000 * metres)


def test_unknown_unit(tmp_path):
    with pytest.raises(FormatError, match=r"Expected POINT:UNITS out of m, dm.*, got 'mile'.*a\.c3d\)"):
        read_c3d(write(tmp_path / "a.c3d", units="mile"))


def test_a_marker_that_was_not_seen_is_nan(tmp_path):
    markers = read_c3d(write(tmp_path / "a.c3d", missing=[(2, 1), (3, 0)])).markers
    assert np.isnan(markers[2, 1]).all()
    assert np.isnan(markers[3, 0]).all()
    assert np.isnan(markers).sum() == 6


def test_names_that_repeat(tmp_path):
    with pytest.warns(KinestitchWarning, match=r"1 marker name\(s\) used twice"):
        assert read_c3d(write(tmp_path / "a.c3d", labels=("A", "A"))).marker_names == ("A", "A_2")


def test_labels_that_miss(tmp_path):
    data = write(tmp_path / "a.c3d").read_bytes()
    (tmp_path / "a.c3d").write_bytes(data.replace(b"HAND", b"    "))
    assert read_c3d(tmp_path / "a.c3d").marker_names == ("HEAD", "marker 1")


def test_without_channels(tmp_path):
    recording = read_c3d(write(tmp_path / "a.c3d", analog=()))
    assert recording.analog.shape[1] == 0
    assert recording.analog_names == ()


def test_the_doors(tmp_path):
    path = write(tmp_path / "a.c3d")
    with pytest.raises(UnsupportedFormatError, match=r"holds markers. Use read_recording\. .*a\.c3d\)"):
        files.read(path)
    with pytest.raises(UnsupportedFormatError, match=r"got BVH, which holds a clip\. Use read"):
        files.read_recording(tmp_path / "a.bvh")
    with pytest.raises(FileNotFoundError):
        files.read_recording(tmp_path / "b.c3d")
    with pytest.raises(UnsupportedFormatError, match="read only"):
        files.write(None, path)
    isolated = files.read_recording(path, isolated=True)
    np.testing.assert_array_equal(isolated.markers, read_c3d(path).markers)
    np.testing.assert_array_equal(isolated.analog, read_c3d(path).analog)


@pytest.mark.parametrize("suffix", [".mot", ".sto", ".txt", ".trc", ".csv", ""])
def test_other_text_is_refused_with_the_known_suffixes(tmp_path, suffix):
    for read in (files.read, files.read_recording):
        with pytest.raises(UnsupportedFormatError, match=r"Expected a file that ends in \.bvh, \.fbx.*\.c3d, got"):
            read(tmp_path / f"a{suffix}")


def test_without_the_library(tmp_path, monkeypatch):
    path = write(tmp_path / "a.c3d")
    monkeypatch.setitem(sys.modules, "ezc3d", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'kinestitch\[c3d\]'"):
        files.read_recording(path)


def test_not_a_c3d_file(tmp_path, capfd):
    for data in (b"", b"hello", b"\x02P" + bytes(400), b"\x09P" + bytes(2000), b"\x02P" + bytes(2000)):
        (tmp_path / "a.c3d").write_bytes(data)
        with pytest.raises(FormatError, match=r"Expected.*a\.c3d\)$"):
            read_c3d(tmp_path / "a.c3d")
    assert capfd.readouterr() == ("", "")


def test_damage_raises_only_our_errors(tmp_path):
    """In a child process: on some damaged files the library crashes or never ends."""
    data = write(tmp_path / "good.c3d").read_bytes()
    rng = np.random.default_rng(0)
    damaged, outcomes = tmp_path / "a.c3d", []
    with Isolated(timeout=10) as reader:
        for _ in range(80):
            content = bytearray(data[: rng.integers(1, len(data))] if rng.random() < 0.3 else data)
            for _ in range(rng.integers(1, 6)):
                content[rng.integers(len(content))] = rng.integers(256)
            damaged.write_bytes(content)
            try:
                reader.read_recording(damaged)
                outcomes.append("read")
            except KinestitchError:
                outcomes.append("refused")
    assert {"read", "refused"} == set(outcomes)


def test_damaged_big_endian_files():
    with pytest.raises(FormatError):
        processor(b"")
    rng = np.random.default_rng(1)
    for _ in range(300):
        data = bytearray(rng.integers(0, 256, 4096, dtype=np.uint8).tobytes())
        data[0], data[1], data[515] = 2, 0x50, 86
        assert processor(bytes(data)) == 86
        try:
            assert len(little_endian(bytes(data))) == len(data)
        except FormatError:
            continue


def rows():
    if not DATA:
        return []
    table = (Path(DATA) / "MANIFEST.md").read_text(encoding="utf-8")
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return [(c[0], float(c[4]), int(c[5])) for c in cells if c[0].endswith(".c3d")]


@pytest.mark.parametrize(("name", "rate", "frames"), rows())
def test_real_file(name, rate, frames, capfd):
    assert DATA
    recording = files.read_recording(Path(DATA) / name)
    assert (recording.rate, recording.frames) == (rate, frames)
    assert recording.samples / recording.analog_rate == pytest.approx(frames / rate)
    if recording.marker_names:
        assert 0.4 < np.nanmax(recording.markers[..., 1]) < 2.2
        assert np.nanmin(recording.markers[..., 1]) > -0.1
    assert capfd.readouterr() == ("", "")


@needs_data
@pytest.mark.parametrize(
    ("one", "other", "metres"),
    [
        ("sgi_int", "pc_int", 0.0),
        ("sgi_real", "pc_real", 0.0),
        ("Eb015si", "Eb015pi", 0.0),
        ("Eb015sr", "Eb015pr", 0.0),
        ("dec_real", "pc_real", 0.0),
        ("dec_int", "pc_int", 3e-4),  # one count is 0.28 mm
        ("Eb015vr", "Eb015pr", 0.0),
    ],
)
def test_one_trial_in_the_byte_orders_of_three_machines(one, other, metres):
    assert DATA
    a, b = (files.read_recording(Path(DATA) / "c3d" / f"{name}.c3d") for name in (one, other))
    np.testing.assert_allclose(a.markers, b.markers, atol=metres, rtol=0)
    np.testing.assert_array_equal(a.analog, b.analog)
    assert (a.marker_names, a.analog_names, a.analog_units) == (b.marker_names, b.analog_names, b.analog_units)
