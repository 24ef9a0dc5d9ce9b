"""FBX on real clips and on other programs' conformance files."""

import os
import re
import time
import warnings
from pathlib import Path

import pytest

from kinestitch.errors import FormatError, KinestitchError, KinestitchWarning
from kinestitch.files.fbx import read_fbx, write_fbx
from kinestitch.files.fbx.binary import is_binary, parse_binary, serialise
from kinestitch.testing import assert_motion_close, check_motion

HOME = os.environ.get("KINESTITCH_DATA")
pytestmark = pytest.mark.skipif(not HOME, reason="KINESTITCH_DATA is unset: no real clips")


def table():
    """Path, frame rate, frames and joints of every character clip in the data folder's own table."""
    rows = []
    for line in (Path(HOME) / "MANIFEST.md").read_text(encoding="utf-8").splitlines() if HOME else ():
        cells = [cell.strip() for cell in line.split("|")[1:-1]]
        if len(cells) == 8 and re.match(r"(mixamo_|ue_mannequin).*\.fbx$", cells[0], re.IGNORECASE):
            rows.append((cells[0], float(cells[4]), int(cells[5]), int(cells[6])))
    return rows


def files(folder):
    return sorted(path for path in (Path(HOME) / folder).rglob("*") if path.suffix.lower() == ".fbx") if HOME else []


def test_the_table_is_there():
    assert len(table()) > 60


@pytest.mark.parametrize(("name", "fps", "frames", "joints"), table(), ids=str)
def test_a_clip_is_what_the_table_says(name, fps, frames, joints, tmp_path):
    motion = read_fbx(Path(HOME) / name)
    check_motion(motion)
    assert (motion.fps, motion.frames, motion.skeleton.joint_count) == (fps, frames, joints)
    write_fbx(motion, tmp_path / "again.fbx")
    again = read_fbx(tmp_path / "again.fbx")
    assert_motion_close(again, motion, degrees=0.001, metres=1e-6)
    assert_motion_close(again, motion, metres=1e-5, world=True)


@pytest.mark.parametrize("folder", ["mixamo_skinned", "mixamo_other_rigs", "ue_mannequin", "conformance_fbx"])
def test_what_was_parsed_is_written_byte_for_byte(folder):
    same = 0
    for path in files(folder):
        data = path.read_bytes()
        if not is_binary(data):
            continue
        try:
            tree = parse_binary(data)
        except FormatError:
            continue
        assert serialise(tree) == data, path
        same += 1
    assert same > 0


@pytest.mark.parametrize("path", files("conformance_fbx"), ids=lambda path: path.name)
def test_a_conformance_file_is_read_or_refused_in_time(path):
    started = time.perf_counter()
    fault = f"({path})"
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", KinestitchWarning)
        try:
            check_motion(read_fbx(path))
        except KinestitchError as error:
            fault = str(error)
    assert fault.endswith(f"({path})")
    assert time.perf_counter() - started < 10


def test_enough_conformance_files_are_read():
    read = 0
    for path in files("conformance_fbx"):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", KinestitchWarning)
            try:
                read += read_fbx(path).frames > 0
            except FormatError:
                continue
    assert read >= 140
