"""Reading a big BVH file takes at most six times its size above the interpreter's own memory."""

import json
import subprocess
import sys

import numpy as np
import pytest

from kinestitch.files.bvh import write_bvh
from kinestitch.testing import random_motion

PROBE = """
import json, resource, sys
from kinestitch.files.bvh import read_bvh
from kinestitch.core.resample import resample
read_bvh(sys.argv[1])
before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
frames = read_bvh(sys.argv[2]).frames
after = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps([frames, (after - before) * (1 if sys.platform == "darwin" else 1024)]))
"""


def generated(path, frames, positions):
    """A file of rows with six decimals, written by repeating a block of rows."""
    write_bvh(random_motion(7, joints=31, frames=64), path)
    text = path.read_text()
    head, _, rows = text.partition("Frame Time")
    first, rows = rows.split("\n", 1)
    if positions:
        rows = "\n".join(" ".join([row, *row.split()[6:]]) for row in rows.splitlines()) + "\n"
        head = head.replace("CHANNELS 3 Z", "CHANNELS 6 Xposition Yposition Zposition Z")
    with path.open("w") as stream:
        stream.write(head.replace("Frames: 64", f"Frames: {frames * 64}") + "Frame Time" + first + "\n")
        for _ in range(frames):
            stream.write(rows)


@pytest.mark.parametrize("positions", [False, True], ids=["rotations", "positions on every joint"])
def test_memory(tmp_path, positions):
    pytest.importorskip("resource", reason="peak memory is measured through the resource module")
    small, big = tmp_path / "small.bvh", tmp_path / "big.bvh"
    generated(small, 1, positions)
    generated(big, int(np.ceil(30e6 / small.stat().st_size)), positions)
    done = subprocess.run([sys.executable, "-c", PROBE, small, big], capture_output=True, text=True, check=True)
    frames, used = json.loads(done.stdout)
    size = big.stat().st_size
    assert frames > 10_000
    assert used <= 6 * size, f"{used / size:.2f} times the file's size"
