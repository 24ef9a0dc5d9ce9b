"""From a BVH file to quaternions: our reader beside those of the package index, same file, same run.

Each rival is given its best: the faster of its own way to quaternions and of its raw angles through our conversion,
where it has both. Names and versions stand in the benchmark's own output (``extra_info``) and in the last line printed.
"""

import time
import warnings
from importlib.metadata import version

import numpy as np
import pytest

from kinestitch.core.rotation import euler_to_quat
from kinestitch.files.bvh import read_bvh, write_bvh
from kinestitch.testing import random_motion

JOINTS, FRAMES = 65, 3000


@pytest.fixture(scope="module")
def clip(tmp_path_factory):
    path = tmp_path_factory.mktemp("speed") / "clip.bvh"
    write_bvh(random_motion(1, joints=JOINTS, frames=FRAMES, bend=2.0), path)
    return path


def kinestitch_reader(path):
    return read_bvh(path).rotations


def pybvh_own(path):
    import pybvh

    return pybvh.read_bvh_file(path, warn_on_world_up_disagreement=False).to_quat()[1]


def pybvh_angles(path):
    import pybvh

    clip = pybvh.read_bvh_file(path, warn_on_world_up_disagreement=False)
    return euler_to_quat(np.radians(clip.joint_angles), "".join(clip.euler_orders[0]))


def bvhio_own(path):
    import bvhio

    clip = bvhio.readAsBvh(str(path))
    return np.array([[pose.Rotation for pose in joint.Keyframes] for joint, _, _ in clip.Root.layout()])


def bvh_angles(path):
    import bvh

    frames = np.array(bvh.Bvh(path.read_text()).frames, dtype=np.float64)
    return euler_to_quat(np.radians(frames[:, 3:].reshape(len(frames), -1, 3)), "ZXY")


READERS = {
    "kinestitch": ("kinestitch", kinestitch_reader),
    "pybvh": ("pybvh", pybvh_own),
    "pybvh, our quaternions": ("pybvh", pybvh_angles),
    "bvhio": ("bvhio", bvhio_own),
    "bvh, our quaternions": ("bvh", bvh_angles),
}


@pytest.mark.parametrize("name", READERS)
def test_file_to_quaternions(benchmark, clip, name):
    package, reader = READERS[name]
    pytest.importorskip(package, reason=f"{package}, a rival reader, is not installed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rotations = benchmark.pedantic(
            reader, args=(clip,), rounds=3 if package in ("bvhio", "bvh") else 9, warmup_rounds=1
        )
    assert np.asarray(rotations).size == JOINTS * FRAMES * 4
    benchmark.extra_info["reader"] = f"{package} {version(package)}"
    if benchmark.stats is not None:  # None where timing is switched off
        benchmark.extra_info["MB/s"] = round(clip.stat().st_size / 1e6 / benchmark.stats.stats.min, 1)


def best_of(function, path, rounds):
    times = []
    for _ in range(rounds):
        begin = time.perf_counter()
        function(path)
        times.append(time.perf_counter() - begin)
    return min(times)


def test_at_least_as_fast_as_the_fastest(clip, capsys, note):
    pytest.importorskip("pybvh", reason="pybvh, the fastest rival reader, is not installed")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        rounds = [[best_of(f, clip, 1) for f in (kinestitch_reader, pybvh_own, pybvh_angles)] for _ in range(7)]
    ours, *theirs = np.min(rounds, axis=0)
    size = clip.stat().st_size / 1e6
    with capsys.disabled():
        print(
            f"\nBVH to quaternions, {size:.1f} MB: kinestitch {size / ours:.0f} MB/s, pybvh {version('pybvh')} "
            f"{size / theirs[0]:.0f} MB/s (angles through our conversion: {size / theirs[1]:.0f}); "
            f"{min(theirs) / ours:.1f} times as fast"
        )
    what = f"from a BVH file to quaternions, {JOINTS} joints, {FRAMES:,} frames"
    note(what, f"pybvh {version('pybvh')}, the faster of two ways", ours / min(theirs), "≤ 1")
    assert min(theirs) / ours >= 1.0
