"""Damaged files to keep the character of: refused in our own words, or kept as far as they go."""

import warnings

import numpy as np
import pytest

from kinestitch.core.rotation import quat_distance
from kinestitch.errors import KinestitchError, KinestitchWarning
from kinestitch.files.fbx import read_fbx, write_fbx
from kinestitch.files.fbx.euler import continuous_degrees
from kinestitch.files.fbx.transform import euler_quat
from kinestitch.testing import random_motion


def test_damaged_sources_raise_nothing_but_our_errors(tmp_path):
    motion = random_motion(3, joints=4, frames=8)
    path, out = tmp_path / "clip.fbx", tmp_path / "out.fbx"
    write_fbx(motion, path)
    data = path.read_bytes()
    rng = np.random.default_rng(6)
    faults = []
    for trial in range(300):
        damaged = bytearray(data if trial % 8 else data[: int(rng.integers(len(data)))])
        for at in rng.integers(0, max(len(damaged), 1), int(rng.integers(1, 5))):
            if damaged:
                damaged[at] = int(rng.integers(256))
        path.write_bytes(bytes(damaged))
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", KinestitchWarning)
                write_fbx(motion, out, like=path)
        except KinestitchError as error:
            faults.append(str(error))
    assert 40 < len(faults) < 290
    assert all(fault.endswith(f"({path})") and "\n" not in fault for fault in faults)


@pytest.mark.parametrize("order", range(7))
def test_paths_of_angles_do_not_jump_in_any_order(order):
    time = np.linspace(0, 4, 400)
    smooth = np.stack([200 * np.sin(time), 120 * np.sin(1.7 * time + 1), 90 * time], axis=-1)
    q = euler_quat(smooth, order)[:, None]
    degrees = continuous_degrees(q, order)
    assert np.abs(np.diff(degrees, axis=0)).max() < 30
    assert np.degrees(quat_distance(euler_quat(degrees, order), q)).max() < 1e-6


@pytest.mark.parametrize("order", range(7))
@pytest.mark.parametrize("middle", [90.0, -90.0])
def test_gimbal_lock_keeps_the_rotation_in_any_order(order, middle):
    which = (1, 2, 0, 0, 2, 1, 1)[order]  # the angle that turns second
    angles = np.stack([np.linspace(0, 170, 60), np.linspace(50, -30, 60), np.linspace(0, 40, 60)], axis=-1)
    angles[:, which] = middle
    q = euler_quat(angles, order)[:, None]
    degrees = continuous_degrees(q, order)
    assert np.degrees(quat_distance(euler_quat(degrees, order), q)).max() < 1e-5
    assert np.abs(np.diff(degrees, axis=0)).max() < 10


def test_the_source_is_never_touched(tmp_path):
    write_fbx(random_motion(1), tmp_path / "a.fbx")
    before = (tmp_path / "a.fbx").read_bytes()
    write_fbx(read_fbx(tmp_path / "a.fbx"), tmp_path / "b.fbx", like=tmp_path / "a.fbx")
    assert (tmp_path / "a.fbx").read_bytes() == before
