"""Small sound files to be damaged: written by our own writers from our own motions, or by hand."""

from __future__ import annotations

import importlib.util
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from types import ModuleType

import numpy as np

from kinestitch.core.motion import Motion
from kinestitch.files import write
from kinestitch.files.smpl import LAYOUTS, skeleton_of
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


PAIR = b"\n#### the motion ####\n"
"""Between a skeleton file and the motion file that goes with it: they are damaged together."""

HAND_MADE_ASF = """# a leg and an arm
:version 1.10
:name two limbs
:units
  mass 1.0
  length 0.45
  angle deg
:documentation
   made by hand
:root
   order TX TY TZ RX RY RZ
   axis XYZ
   position 0 1 0
   orientation 0 10 0
:bonedata
  begin
     id 1
     name thigh
     direction 0 -1 0
     length 8
     axis 0 0 20 XYZ
    dof rx ry rz
    limits (-160.0 20.0)
           (-70.0 70.0)
           (-60.0 70.0)
  end
  begin
     id 2
     name shin
     direction 0 -1 0
     length 6
     axis 0 90 0 ZYX
    dof rx
    limits (-10.0 170.0)
  end
  begin
     id 3
     name arm
     direction 0.6 0.8 0
     length 5
     axis 30 0 0 XYZ
    dof rz rx
  end
:hierarchy
  begin
    root thigh arm
    thigh shin
  end
"""
HAND_MADE_AMC = """#!OML:ASF
:FULLY-SPECIFIED
:DEGREES
:samples-per-second 60
1
root 1 2 3 0 0 0
thigh 0 10 -3.5
shin 20
arm 1e1 -5
2
root 1.1 2 3 0 90 0
thigh 90 0 0
shin 90.25
arm 0 0
3
root 1.2 2 3 0 181 0
thigh 91 0 0
shin 0
arm 179 3
"""


def amc() -> Iterator[tuple[str, bytes]]:
    """Skeleton and motion in one, see PAIR; by hand, since there is no writer."""
    radians = HAND_MADE_ASF.replace("angle deg", "angle rad").replace("length 0.45", "length 1")
    yield ".asf_amc", HAND_MADE_ASF.encode() + PAIR + HAND_MADE_AMC.encode()
    yield ".asf_amc", radians.encode() + PAIR + HAND_MADE_AMC.replace(":DEGREES", ":RADIANS").encode()


def amass() -> Iterator[tuple[str, bytes]]:
    """What our writer makes, and arrays of every length of a pose, packed and not."""
    rng = np.random.default_rng(5)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "seed.npz"
        for width, save in ((66, np.savez), (72, np.savez), (156, np.savez_compressed), (165, np.savez)):
            arrays = {"poses": rng.normal(scale=0.3, size=(2, width)), "trans": rng.normal(size=(2, 3))}
            save(path, **arrays, mocap_framerate=60.0, gender=np.array("neutral"), betas=np.zeros(4))
            yield ".npz", path.read_bytes()
        parts = {"root_orient": (2, 3), "pose_body": (2, 63), "trans": (2, 3)}
        np.savez(path, **{name: rng.normal(scale=0.3, size=shape) for name, shape in parts.items()}, fps=30)
        yield ".npz", path.read_bytes()
        rig = skeleton_of(LAYOUTS[0])[0]
        still = np.tile([0.0, 0, 0, 1], (2, rig.joint_count, 1))
        write(Motion(rig, np.tile(rig.offsets, (2, 1, 1)), still, 30.0, "still"), path)
        yield ".npz", path.read_bytes()


def usd() -> Iterator[tuple[str, bytes]]:
    yield from written(".usda")
    yield from written(".usdc")


def c3d() -> Iterator[tuple[str, bytes]]:
    """Two markers and a channel, by ezc3d's writer, and said to be of other machines."""
    import ezc3d

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "seed.c3d"
        for screen, channels in (("+Z", 1), ("+Y", 0)):
            content = ezc3d.c3d()
            content["parameters"]["POINT"]["RATE"]["value"] = [100]
            content["parameters"]["POINT"]["LABELS"]["value"] = ["HEAD", "HAND"]
            content.add_parameter("POINT", "UNITS", ["mm"])
            content.add_parameter("POINT", "X_SCREEN", ["+X"])
            content.add_parameter("POINT", "Y_SCREEN", [screen])
            points = np.ones((4, 2, 3))
            points[:3] = np.arange(18.0).reshape(3, 2, 3)
            content["data"]["points"] = points
            content["parameters"]["ANALOG"]["RATE"]["value"] = [200 * channels]
            if channels:
                content["parameters"]["ANALOG"]["LABELS"]["value"] = ["EMG"]
                content["parameters"]["ANALOG"]["UNITS"]["value"] = ["V"]
                content["data"]["analogs"] = np.arange(6.0).reshape(1, 1, 6)
            content.write(str(path))
            data = path.read_bytes()
            place = (data[0] - 1) * 512 + 3
            for processor in (84, 85, 86):
                yield ".c3d", data[:place] + bytes([processor]) + data[place + 1 :]
