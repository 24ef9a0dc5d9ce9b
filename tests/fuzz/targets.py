"""The readers that are fuzzed. A new one needs a row here and seeds of our own, never a file of somebody else."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import seeds
import structured


def read_motion(path: Path) -> Any:
    """The front door, as everybody uses it, and every check of its result."""
    from kinestitch.files import read
    from kinestitch.testing import check_motion

    check_motion(read(path))


def keep_character(path: Path) -> Any:
    """What `like=` does with a damaged file: its motion written into it again."""
    from kinestitch.files import read, write

    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / path.name
        write(read(path), out, like=path)
        read_motion(out)


def read_pair(path: Path) -> Any:
    """An AMC file with its ASF file beside it; the two come in one, see seeds.PAIR."""
    skeleton, _, motion = path.read_bytes().partition(seeds.PAIR)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "01.asf").write_bytes(skeleton)
        (Path(folder) / "01_01.amc").write_bytes(motion)
        read_motion(Path(folder) / "01_01.amc")


@cache
def child() -> Any:
    """One child process for all files, started again when a file has killed it."""
    from kinestitch.files.isolated import Isolated

    return Isolated(timeout=20)


def read_motion_isolated(path: Path) -> Any:
    from kinestitch.testing import check_motion

    check_motion(child().read(path))


def read_recording_isolated(path: Path) -> Any:
    recording = child().read_recording(path)
    assert recording.markers.shape[1] == len(recording.marker_names)
    assert recording.analog.shape[1] == len(recording.analog_names)


@dataclass(frozen=True)
class Target:
    """One reader.

    suffix : of the files it reads, with the dot
    seeds : small sound files as (suffix, bytes); made by code
    read : what may raise nothing but a KinestitchError
    change : one mutation that knows the format, so that damage gets past its container; None has only those of bytes
    native : rests on native code in a child process of its own, which limits its own memory
    """

    suffix: str
    seeds: Callable[[], Iterator[tuple[str, bytes]]]
    read: Callable[[Path], Any] = read_motion
    change: Callable[[random.Random, bytes], bytes] | None = None
    native: bool = False


TARGETS = {
    "bvh": Target(".bvh", seeds.bvh),
    "fbx": Target(".fbx", seeds.fbx, change=structured.fbx),
    "glb": Target(".glb", seeds.glb, change=structured.glb),
    "amc": Target(".asf_amc", seeds.amc, read_pair),
    "amass": Target(".npz", seeds.amass, change=structured.amass),
    "usd": Target(".usda", seeds.usd, read_motion_isolated, native=True),
    "c3d": Target(".c3d", seeds.c3d, read_recording_isolated, native=True),
    "fbx_like": Target(".fbx", seeds.fbx, keep_character, structured.fbx),
    "glb_like": Target(".glb", seeds.glb, keep_character, structured.glb),
}
