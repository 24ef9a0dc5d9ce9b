"""Every real BVH file reads, and says what the table of the data says."""

import os
import warnings
from pathlib import Path

import pytest

from kinestitch.errors import KinestitchWarning
from kinestitch.files.bvh import read_bvh
from kinestitch.testing import check_motion

DATA = os.environ.get("KINESTITCH_DATA")


def rows():
    if not DATA:
        return []
    table = (Path(DATA) / "MANIFEST.md").read_text(encoding="utf-8")
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return [(c[0], float(c[4]), int(c[5]), int(c[6])) for c in cells if c[0].endswith(".bvh")]


@pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")
def test_the_table_is_not_empty():
    assert len(rows()) >= 60


@pytest.mark.parametrize(("name", "fps", "frames", "joints"), rows())
def test_real_file(name, fps, frames, joints):
    assert DATA
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        motion = read_bvh(Path(DATA) / name)
    check_motion(motion)
    assert (motion.frames, motion.skeleton.joint_count) == (frames, joints)
    assert motion.fps == pytest.approx(fps, rel=5e-4)
    assert [str(w.message)[:8] for w in caught] == (["1 row(s)"] if "Boxing_Toes" in name else [])
    assert all(issubclass(w.category, KinestitchWarning) for w in caught)


@pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")
@pytest.mark.parametrize(
    ("name", "hips"),
    [
        ("cmu/02_01.bvh", 1.0),
        ("cmu/131_01.bvh", 0.9),
        ("cmu/16_15.bvh", 1.0),
        ("conformance_bvh/test_mocapbank.bvh", 0.9),
        ("conformance_bvh/ganimator_traj-example.bvh", 1.0),
        ("conformance_bvh/test_freebvh.bvh", 1.0),
    ],
)
def test_hips_are_at_a_persons_height(name, hips):
    assert DATA
    motion = read_bvh(Path(DATA) / name)
    assert motion.translations[0, 0, 1] == pytest.approx(hips, abs=0.12)
