"""Readers in a child process: the same motion, the same errors, and none of the crashes."""

import os
import sys
import threading
import time

import numpy as np
import pytest

from kinestitch import files
from kinestitch.errors import FormatError, KinestitchWarning, ParameterError, UnsupportedFormatError
from kinestitch.files.bvh import read_bvh, write_bvh
from kinestitch.files.isolated import Isolated, read_isolated
from kinestitch.files.messages import receive, send, value_of
from kinestitch.testing import assert_motion_close, check_motion, random_motion


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    path = tmp_path_factory.mktemp("isolated") / "walk.bvh"
    write_bvh(random_motion(3), path)
    return path


@pytest.fixture
def child():
    with Isolated(timeout=20) as reader:
        yield reader


def test_the_same_motion(clip, child):
    for motion in (child.read(clip), child.read(clip), read_isolated(clip), files.read(clip, isolated=True)):
        check_motion(motion)
        assert_motion_close(motion, read_bvh(clip), degrees=1e-12, metres=0)
        np.testing.assert_array_equal(motion.rotations, read_bvh(clip).rotations)
        assert motion.skeleton == read_bvh(clip).skeleton
        assert motion.name == "walk"


def test_options_reach_the_reader(clip, child):
    assert np.allclose(child.read(clip, unit="m").skeleton.offsets, read_bvh(clip, unit="m").skeleton.offsets)
    with pytest.raises(ParameterError, match=r"Expected a unit out of auto.*got 'mile'"):
        child.read(clip, unit="mile")
    with pytest.raises(ParameterError, match=r"Expected an option of BVH \(unit\), got 'speed'"):
        child.read(clip, speed=2)
    with pytest.raises(ParameterError, match="Expected options of text, numbers and paths"):
        child.read(clip, unit=object())


def test_errors_are_the_readers_own(clip, child, tmp_path):
    with pytest.raises(FileNotFoundError):
        child.read(tmp_path / "none.bvh")
    (tmp_path / "a.bvh").write_text("HIERARCHY\nROOT")
    with pytest.raises(FormatError, match=r"Expected a line MOTION.*a\.bvh\)$") as caught:
        child.read(tmp_path / "a.bvh")
    assert str(caught.value).count("a.bvh") == 1
    with pytest.raises(UnsupportedFormatError):
        child.read(tmp_path / "a.txt")
    with pytest.raises(UnsupportedFormatError, match=r"Use read\."):
        child.read_recording(clip)


def test_warnings_come_along(clip, child, tmp_path):
    text = clip.read_text().rstrip("\n")
    (tmp_path / "a.bvh").write_text(text + "\n" + text.split("\n")[-1] + "\n")
    with pytest.warns(KinestitchWarning, match=r"1 row"):
        child.read(tmp_path / "a.bvh")


def module(tmp_path, monkeypatch, body):
    """A reader of our own in the place of that of BVH, for the child only."""
    (tmp_path / "sitecustomize.py").write_text(
        "import sys, types\n"
        "module = types.ModuleType('kinestitch.files.bvh')\n"
        f"def read_bvh(path):\n    {body}\n"
        "module.read_bvh = read_bvh\n"
        "sys.modules['kinestitch.files.bvh'] = module\n"
    )
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])


def test_a_crash_is_a_format_error_and_the_next_file_is_read(tmp_path, monkeypatch, clip):
    module(tmp_path, monkeypatch, "import os; os.abort()")
    with Isolated(timeout=20) as reader:
        for _ in range(2):
            with pytest.raises(FormatError, match=r"crashes on \((signal 6|exit code \d+)\).*walk\.bvh\)"):
                reader.read(clip)
        monkeypatch.undo()
        assert reader.read(clip).frames == 40


def test_a_child_that_hangs_is_ended(tmp_path, monkeypatch, clip):
    module(tmp_path, monkeypatch, "import time; time.sleep(60)")
    start = time.monotonic()
    with Isolated(timeout=1.0) as reader, pytest.raises(FormatError, match="within 1 s, got no end"):
        reader.read(clip)
    assert time.monotonic() - start < 10


@pytest.mark.skipif(sys.platform != "linux", reason="memory is limited on Linux")
def test_memory_is_limited(tmp_path, monkeypatch, clip):
    module(tmp_path, monkeypatch, "return bytearray(300 << 20)")
    with Isolated(memory=200 << 20) as reader, pytest.raises(FormatError, match="within the memory that is allowed"):
        reader.read(clip)


def test_what_a_library_prints_goes_nowhere(tmp_path, monkeypatch, clip, capfd):
    module(tmp_path, monkeypatch, "import os; os.write(1, b'out'); os.write(2, b'err'); print('more'); 1 / 0")
    with Isolated() as reader, pytest.raises(RuntimeError, match="ZeroDivisionError"):
        reader.read(clip)
    assert capfd.readouterr() == ("", "")


def test_a_mistake_of_a_reader_stays_one(tmp_path, monkeypatch, clip):
    module(tmp_path, monkeypatch, "raise TypeError('a mistake')")
    with Isolated() as reader, pytest.raises(TypeError, match="a mistake"):
        reader.read(clip)


def test_closing_ends_the_child(clip):
    reader = Isolated()
    reader.read(clip)
    child = reader._child
    reader.close()
    assert child.returncode is not None
    assert reader.read(clip).frames == 40  # it starts another
    reader.close()
    reader.close()
    for limits in ({"timeout": 0}, {"memory": -1}):
        with pytest.raises(ParameterError):
            Isolated(**limits)


@pytest.mark.parametrize("data", [b"", b"\0" * 7, b"\xff" * 64, b"\1" + b"\0" * 7 + b"\5" + b"\0" * 7 + b"hel"])
def test_a_broken_answer_is_refused(data):
    read_end, write_end = os.pipe()
    with os.fdopen(write_end, "wb") as stream:
        stream.write(data)
    with os.fdopen(read_end, "rb") as stream, pytest.raises((EOFError, ValueError, OSError)):
        receive(stream, 1000)


def test_an_answer_that_is_no_motion_is_refused():
    read_end, write_end = os.pipe()
    with os.fdopen(write_end, "wb") as out, os.fdopen(read_end, "rb") as back:
        writer = threading.Thread(target=send, args=(out, b'{"shapes": [[2, 3]]}', [b"short"]))
        writer.start()
        answer = receive(back, 1000)
        writer.join()
    with pytest.raises(ValueError, match=r"reshape|buffer"):
        value_of(*answer)
