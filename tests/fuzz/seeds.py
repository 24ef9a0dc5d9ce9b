"""Small sound files to be damaged: written by our own writers from our own motions, or by hand."""

from __future__ import annotations

import importlib.util
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType

from kinestitch.core.motion import Motion
from kinestitch.files import write
from kinestitch.samples import sample
from kinestitch.testing import random_motion


def motions() -> Iterator[Motion]:
    """A random one, a still one, and the trunk of a sample."""
    yield random_motion(1, joints=5, frames=6, bend=2.0)
    yield random_motion(2, joints=2, frames=1)
    walk = sample("walk", fps=30)
    rig = walk.skeleton
    trunk = replace(
        rig, names=rig.names[:8], parents=rig.parents[:8], offsets=rig.offsets[:8], rest=rig.rest[:8], tips=None
    )
    yield Motion(trunk, walk.translations[:4, :8], walk.rotations[:4, :8], walk.fps, "walk")


def written(suffix: str) -> Iterator[tuple[str, bytes]]:
    """The motions in the format of a suffix."""
    with tempfile.TemporaryDirectory() as folder:
        for motion in motions():
            path = Path(folder) / f"seed{suffix}"
            write(motion, path)
            yield suffix, path.read_bytes()


def bvh() -> Iterator[tuple[str, bytes]]:
    yield from written(".bvh")
    yield ".bvh", HAND_MADE_BVH.encode()


HAND_MADE_BVH = """HIERARCHY
ROOT Hips {
  OFFSET 0 90 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT Left Leg { OFFSET 10 -5 0 CHANNELS 3 Xrotation Yrotation Zrotation
    End Site { OFFSET 0 -80 0 } }
  JOINT Spine { OFFSET 0 10 0 CHANNELS 2 Zrotation Xrotation
    JOINT Head { OFFSET 0 50 0 CHANNELS 4 Yposition Zrotation Xrotation Yrotation End Site { OFFSET 0 20 0 } } }
}
MOTION
Frames: 3
Frame Time: .0333333
0 90 0 1 2 3 4 5 6 7 8 50 9 10 11
1 91 -1 1e1 2.5 -3 4 5 6 7 8 51 9 10 11
2 92 0 1 2 3 4 5 +6 7 8 52 9 10 11
"""


def fbx() -> Iterator[tuple[str, bytes]]:
    from kinestitch.files.fbx.binary import parse_binary

    binary = list(written(".fbx"))
    yield from binary
    for _, data in binary[:2]:
        yield ".fbx", text_of(parse_binary(data)).encode("utf-8", errors="replace")


def text_of(document) -> str:
    """A node tree as a text file."""
    lines: list[str] = [f"; FBX {document.version // 1000}.{document.version // 100 % 10}.0 project file"]

    def spelt(value: object) -> str:
        if isinstance(value, str):
            title, _, kind = value.partition("\x00\x01")
            return f'"{kind}::{title}"' if kind else f'"{value}"'
        return repr(value) if isinstance(value, int | float) else '""'

    def tell(node, depth: int) -> None:
        array = next((p for p in node.properties if hasattr(p, "values")), None)
        indent = "\t" * depth
        if array is not None:
            numbers = ",".join(repr(v) for v in array.values().tolist())
            lines.append(f"{indent}{node.name}: *{array.count} {{\n{indent}\ta: {numbers}\n{indent}}}")
            return
        head = f"{indent}{node.name}: {', '.join(spelt(p) for p in node.properties)}"
        lines.append(head + (" {" if node.children or node.terminated else ""))
        for child in node.children:
            tell(child, depth + 1)
        if node.children or node.terminated:
            lines.append(indent + "}")

    for node in document.nodes:
        if not isinstance(next(iter(node.properties), None), bytes):
            tell(node, 0)
    return "\n".join(lines) + "\n"


def glb() -> Iterator[tuple[str, bytes]]:
    yield from written(".glb")
    yield next(written(".gltf"))
    characters = _characters()
    with tempfile.TemporaryDirectory() as folder:
        for make in (characters.plain_character, characters.awkward_character):
            yield ".glb", make(joints=6, frames=4).save(Path(folder) / "seed.glb").read_bytes()


def _characters() -> ModuleType:
    path = Path(__file__).parents[1] / "files" / "gltf_character.py"
    spec = importlib.util.spec_from_file_location("gltf_character", path)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module
