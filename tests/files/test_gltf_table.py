"""Every real GLB reads: as many joints as the table says, joints where a plain evaluation of the nodes puts them."""

import json
import os
import struct
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.files.gltf import list_takes, read_gltf, write_gltf
from kinestitch.testing import assert_motion_close, check_motion

DATA = os.environ.get("KINESTITCH_DATA")


def rows():
    if not DATA:
        return []
    table = (Path(DATA) / "MANIFEST.md").read_text(encoding="utf-8")
    cells = [[cell.strip() for cell in line.strip("|").split("|")] for line in table.splitlines()]
    return [(c[0], int(c[6])) for c in cells if c[0].endswith(".glb")]


@pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")
def test_the_table_is_not_empty():
    assert len(rows()) >= 6


def local(node, changed):
    values = node | changed
    if "matrix" in values:
        return np.array(values["matrix"], dtype=float).reshape(4, 4).T
    x, y, z, w = np.array(values.get("rotation", [0, 0, 0, 1.0])) / np.linalg.norm(
        values.get("rotation", [0, 0, 0, 1.0])
    )
    turn = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    m = np.eye(4)
    m[:3, :3] = np.array(turn) * np.array(values.get("scale", [1.0, 1, 1]))
    m[:3, 3] = values.get("translation", [0, 0, 0])
    return m


def first_pose(path, take):
    """Positions by name at the first key of an animation, read without the package; float accessors only."""
    data = path.read_bytes()
    (size,) = struct.unpack_from("<I", data, 12)
    document, binary = json.loads(data[20 : 20 + size]), data[28 + size :]

    def first(index, width):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        assert accessor["componentType"] == 5126
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, "<f4", width, start).astype(float)

    animation = next(entry for entry in document["animations"] if entry.get("name") == take)
    paths = {"rotation": 4, "translation": 3, "scale": 3}
    samplers = animation["samplers"]
    wanted = [c for c in animation["channels"] if c["target"]["path"] in paths]
    start = min(first(samplers[c["sampler"]]["input"], 1)[0] for c in wanted)
    changed = {}
    for channel in wanted:
        sampler, target = samplers[channel["sampler"]], channel["target"]
        assert first(sampler["input"], 1)[0] == start
        value = first(sampler["output"], paths[target["path"]])
        changed.setdefault(target["node"], {})[target["path"]] = value
    nodes = document["nodes"]
    parents = {below: above for above, node in enumerate(nodes) for below in node.get("children", [])}
    positions = {}
    for index in {joint for skin in document["skins"] for joint in skin["joints"]}:
        node = nodes[index]
        m, at = np.eye(4), index
        while at is not None:
            m, at = local(nodes[at], changed.get(at, {})) @ m, parents.get(at)
        positions[node.get("name")] = m[:3, 3]
    return positions


@pytest.mark.parametrize(("name", "joints"), rows())
def test_real_file(name, joints, tmp_path):
    assert DATA
    path = Path(DATA) / name
    motion = read_gltf(path)
    check_motion(motion)
    assert motion.skeleton.joint_count == joints
    assert motion.fps in (24.0, 30.0)
    expected = first_pose(path, motion.name)
    size = np.ptp(rest_pose(motion.skeleton)[0], axis=0).max()
    for joint, position in zip(motion.skeleton.names, world_pose(motion).positions[0], strict=True):
        assert np.abs(position - expected[joint]).max() < 2e-6 * size, joint
    write_gltf(motion, tmp_path / "a.glb")
    assert_motion_close(read_gltf(tmp_path / "a.glb"), motion, degrees=1e-4, metres=1e-6 * max(1.0, size / 2))


@pytest.mark.parametrize(("name", "joints"), rows())
def test_every_take_reads(name, joints):
    assert DATA
    path = Path(DATA) / name
    takes = list_takes(path)
    for take in takes[:20]:
        assert read_gltf(path, take=take).skeleton.joint_count == joints
    assert takes


@pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")
@pytest.mark.parametrize("name", ["Michelle", "Soldier", "Xbot"])
def test_rest_pose_is_a_standing_person_with_arms_out(name):
    assert DATA
    motion = read_gltf(Path(DATA) / "mixamo_skinned" / f"{name}.glb")
    positions, _ = rest_pose(motion.skeleton)
    wide, tall, deep = np.ptp(positions, axis=0)
    assert 1.4 < wide < 1.9
    assert 1.5 < tall < 1.9
    assert deep < 0.3
