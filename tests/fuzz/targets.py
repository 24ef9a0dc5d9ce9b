"""The readers that are fuzzed. A new one needs a row here and seeds of our own, never a file of somebody else."""

from __future__ import annotations

import random
import tempfile
from collections.abc import Callable, Iterator
from dataclasses import dataclass
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
    "fbx_like": Target(".fbx", seeds.fbx, keep_character, structured.fbx),
    "glb_like": Target(".glb", seeds.glb, keep_character, structured.glb),
}
