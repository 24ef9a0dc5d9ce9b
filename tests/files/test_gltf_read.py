"""What the glTF reader makes of files built here by hand, beside a plain evaluation of the node tree."""

import base64
import json
import struct

import numpy as np
import pytest

from kinestitch.core.kinematics import rest_pose, world_pose
from kinestitch.core.rotation import quat_about_axis, quat_distance, quat_multiply, quat_slerp, quat_to_matrix
from kinestitch.errors import FormatError, KinestitchWarning, ParameterError
from kinestitch.files.gltf import list_takes, read_gltf
from kinestitch.testing import check_motion

UP = [0.0, 0.0, 0.0, 1.0]


class Maker:
    """A glTF document under construction."""

    def __init__(self, nodes, **top):
        self.data = b""
        self.json = {"asset": {"version": "2.0"}, "nodes": nodes, "accessors": [], "bufferViews": [], **top}

    def add(self, values, kind, dtype="<f4", component=5126, **extra):
        raw = np.ascontiguousarray(values, dtype=dtype).tobytes()
        self.data += b"\0" * (-len(self.data) % 4)
        self.json["bufferViews"].append({"buffer": 0, "byteOffset": len(self.data), "byteLength": len(raw)})
        self.data += raw
        entry = {"bufferView": len(self.json["bufferViews"]) - 1, "componentType": component, "count": len(values)}
        self.json["accessors"].append(entry | {"type": kind} | extra)
        return len(self.json["accessors"]) - 1

    def animate(self, *channels, name=None):
        """Channels are (node, path, times, values, interpolation or None)."""
        entry = {"samplers": [], "channels": []} | ({"name": name} if name else {})
        for node, path, times, values, interpolation in channels:
            kind = {"rotation": "VEC4", "weights": "SCALAR"}.get(path, "VEC3")
            sampler = {"interpolation": interpolation} if interpolation else {}
            sampler |= {"input": self.add(times, "SCALAR"), "output": self.add(values, kind)}
            entry["channels"].append({"sampler": len(entry["samplers"]), "target": {"node": node, "path": path}})
            entry["samplers"].append(sampler)
        self.json.setdefault("animations", []).append(entry)
        return self

    def skin(self, joints, **extra):
        self.json.setdefault("skins", []).append({"joints": joints, **extra})
        return self

    def glb(self, path):
        document = {**self.json, "buffers": [{"byteLength": len(self.data)}]}
        text = json.dumps(document).encode()
        text += b" " * (-len(text) % 4)
        data = self.data + b"\0" * (-len(self.data) % 4)
        chunks = struct.pack("<II", len(text), 0x4E4F534A) + text + struct.pack("<II", len(data), 0x004E4942) + data
        path.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
        return path


@pytest.fixture
def load(tmp_path):
    def load(maker, **options):
        motion = read_gltf(maker.glb(tmp_path / "clip.glb"), **options)
        check_motion(motion)
        return motion

    return load


def about(axis, degrees):
    return quat_about_axis(axis, np.radians(degrees))


def matrix(node):
    if "matrix" in node:
        return np.array(node["matrix"], dtype=float).reshape(4, 4).T
    m = np.eye(4)
    turn, scale = (np.array(node.get(key, usual)) for key, usual in (("rotation", UP), ("scale", [1.0, 1, 1])))
    m[:3, :3] = quat_to_matrix(turn) * scale
    m[:3, 3] = node.get("translation", [0, 0, 0])
    return m


def plain_positions(nodes, joints, change=None):
    """World positions of the joints by 4×4 matrices; `change` maps a node to properties that replace its own."""
    parents = {below: above for above, node in enumerate(nodes) for below in node.get("children", [])}
    result = []
    for joint in joints:
        m = np.eye(4)
        node = joint
        while node is not None:
            m = matrix(nodes[node] | (change or {}).get(node, {})) @ m
            node = parents.get(node)
        result.append(m[:3, 3])
    return np.array(result)


def chain_nodes():
    return [
        {"name": "Hips", "children": [1], "translation": [0, 1, 0]},
        {"name": "Spine", "children": [2], "translation": [0, 0.5, 0], "rotation": about(2, 30).tolist()},
        {"name": "Head", "translation": [0, 0.3, 0.1]},
    ]


TIMES = np.arange(4) / 30
TURNS = np.array([about(0, angle) for angle in (0, 40, 90, 170)])


def test_linear_rotation(load):
    motion = load(Maker(chain_nodes()).skin([0, 1, 2]).animate((1, "rotation", TIMES, TURNS, None)))
    assert motion.skeleton.names == ("Hips", "Spine", "Head")
    assert motion.skeleton.parents == (-1, 0, 1)
    assert (motion.fps, motion.frames, motion.name) == (30.0, 4, "clip")
    assert quat_distance(motion.rotations[:, 1], TURNS).max() < 1e-7
    assert np.allclose(motion.skeleton.offsets, [[0, 1, 0], [0, 0.5, 0], [0, 0.3, 0.1]], atol=1e-7)
    assert quat_distance(motion.skeleton.rest[1], about(2, 30)) < 1e-12
    assert np.allclose(motion.translations, motion.skeleton.offsets, atol=1e-7)


def test_slow_keys_beside_fast_ones_are_slerped(load):
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    maker.animate(
        (1, "rotation", TIMES[[0, 3]], TURNS[[0, 3]], "LINEAR"), (0, "translation", TIMES, np.eye(4, 3), None)
    )
    motion = load(maker)
    for frame in range(4):
        assert quat_distance(motion.rotations[frame, 1], quat_slerp(TURNS[0], TURNS[3], frame / 3)) < 1e-6
    assert np.allclose(motion.translations[:, 0], np.eye(4, 3), atol=1e-7)


def test_rotations_take_the_short_way(load):
    keys = np.array([TURNS[0], -TURNS[1]])
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    maker.animate((1, "rotation", [0, 2 / 30], keys, None), (0, "translation", TIMES[:3], np.eye(3), None))
    assert quat_distance(load(maker).rotations[1, 1], about(0, 20)) < 1e-6


def test_step_holds(load):
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    maker.animate((1, "rotation", TIMES[[0, 2]], TURNS[[0, 2]], "STEP"), (0, "translation", TIMES, np.eye(4, 3), None))
    motion = load(maker)
    assert quat_distance(motion.rotations[:, 1], TURNS[[0, 0, 2, 2]]).max() < 1e-7


def test_cubic_spline(load):
    rng = np.random.default_rng(3)
    values = rng.normal(size=(2, 3, 3)).astype(np.float32)
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    maker.animate(
        (0, "translation", [0.0, 0.1], values.reshape(-1, 3), "CUBICSPLINE"),
        (1, "rotation", TIMES, TURNS, "LINEAR"),
    )
    motion = load(maker)
    for frame in range(4):
        s = frame / 3
        start, stop = values[0, 1], values[1, 1]
        leave, arrive = 0.1 * values[0, 2], 0.1 * values[1, 0]
        expected = (2 * s**3 - 3 * s**2 + 1) * start + (s**3 - 2 * s**2 + s) * leave
        expected = expected + (3 * s**2 - 2 * s**3) * stop + (s**3 - s**2) * arrive
        assert np.allclose(motion.translations[frame, 0], expected, atol=1e-6)


def test_cubic_rotations_have_unit_norm(load):
    keys = np.zeros((2, 3, 4))
    keys[:, 1] = TURNS[[0, 2]]
    keys[:, 0] = keys[:, 2] = [0.5, 0, 0, -0.3]
    maker = Maker(chain_nodes()).skin([0, 1, 2]).animate((1, "rotation", [0, 1.0], keys.reshape(-1, 4), "CUBICSPLINE"))
    motion = load(maker)
    assert motion.fps == 24.0
    assert motion.frames == 25


def character(**armature):
    """A skeleton below nodes that are no joints."""
    return [
        {"name": "Scene", "children": [1], "translation": [0.2, 0, 0.1], "rotation": about(1, 20).tolist()},
        {"name": "Armature", "children": [2, 5], **armature},
        {"name": "Hips", "children": [3], "translation": [0, 100, 3], "rotation": about(0, 10).tolist()},
        {"name": "between", "children": [4], "translation": [0, 20, 0], "rotation": about(2, 35).tolist()},
        {"name": "Spine", "translation": [5, 20, 0]},
        {"name": "mesh", "mesh": 0, "skin": 0},
    ]


@pytest.mark.parametrize(
    "armature",
    [
        {},
        {"scale": [0.01] * 3, "rotation": about(0, -90).tolist()},
        {"scale": [0.01, 0.02, 0.03], "rotation": about(0, -45).tolist()},
        {"scale": [-0.01, 0.01, 0.01]},
        {"scale": [0, 0, 0]},
        {"matrix": [0, 0, -0.01, 0, 0, 0.01, 0, 0, 0.01, 0, 0, 0, 1, 2, 3, 1]},
        {"matrix": [0, 0, -0.01, 0, 0.004, 0.01, 0, 0, 0.01, 0, 0, 0, 1, 2, 3, 1]},
    ],
)
def test_nodes_above_and_between_are_baked_in(load, armature):
    nodes = character(**armature)
    moves = [[0, 100 + i, 3 * i] for i in range(4)]
    maker = Maker(nodes, meshes=[{"primitives": []}]).skin([2, 4])
    maker.animate((3, "rotation", TIMES, TURNS, None), (2, "translation", TIMES, moves, None))
    motion = load(maker)
    assert motion.skeleton.names == ("Hips", "Spine")
    positions = world_pose(motion).positions
    for frame in range(4):
        change = {3: {"rotation": TURNS[frame].tolist()}, 2: {"translation": moves[frame]}}
        assert np.allclose(positions[frame], plain_positions(nodes, [2, 4], change), atol=1e-5)


def test_mirrored_and_scaled_bones_keep_their_offsets(load):
    nodes = chain_nodes()
    nodes[0]["scale"] = [-0.5, 0.5, 0.5]
    motion = load(Maker(nodes).skin([0, 1, 2]).animate((1, "rotation", TIMES, TURNS, None)))
    assert np.allclose(motion.translations[:, 2], motion.translations[0, 2], atol=1e-6)
    assert np.linalg.norm(motion.translations[0, 2]) == pytest.approx(0.5 * np.hypot(0.3, 0.1), abs=1e-6)


def test_animated_parent_and_animated_scale(load):
    nodes = character()
    sizes = np.linspace(1, 2, 4)[:, None] * np.ones(3)
    maker = Maker(nodes).skin([2, 4])
    maker.animate((1, "rotation", TIMES, TURNS, None), (2, "scale", TIMES, sizes, None))
    positions = world_pose(load(maker)).positions
    for frame in range(4):
        change = {1: {"rotation": TURNS[frame].tolist()}, 2: {"scale": sizes[frame].tolist()}}
        assert np.allclose(positions[frame], plain_positions(nodes, [2, 4], change), atol=2e-5)


def test_several_roots_share_an_ancestor(load):
    nodes = [{"name": "top", "children": [1]}, {"name": "body", "children": [2, 3], "translation": [0, 1, 0]}]
    nodes += [{"name": name, "translation": [x, 0, 0]} for name, x in (("left", 1), ("right", -1))]
    motion = load(Maker(nodes).skin([2, 3]).animate((2, "rotation", TIMES, TURNS, None)))
    assert motion.skeleton.names == ("body", "left", "right")
    assert motion.skeleton.parents == (-1, 0, 0)
    assert np.allclose(motion.translations[0], [[0, 1, 0], [1, 0, 0], [-1, 0, 0]], atol=1e-7)


def test_figures_apart_are_counted(load):
    nodes = [*chain_nodes(), {"name": "other"}]
    maker = Maker(nodes).skin([3]).skin([0, 1, 2]).animate((1, "rotation", TIMES, TURNS, None))
    with pytest.warns(KinestitchWarning, match=r"^1 joint\(s\) of other figures"):
        assert load(maker).skeleton.joint_count == 3


def test_joints_listed_children_first(load):
    motion = load(Maker(chain_nodes()).skin([2, 1, 0]).animate((1, "rotation", TIMES, TURNS, None)))
    assert motion.skeleton.names == ("Hips", "Spine", "Head")


def test_without_a_skin_animated_nodes_and_all_above_are_joints(load):
    motion = load(Maker(character()).animate((3, "rotation", TIMES, TURNS, None)))
    assert motion.skeleton.names == ("Scene", "Armature", "Hips", "between")


def test_neither_skin_nor_animation(load):
    with pytest.raises(FormatError, match="skin or animated nodes"):
        load(Maker(chain_nodes()))


def test_skin_without_animation_is_one_frame(load):
    motion = load(Maker(chain_nodes()).skin([0, 1, 2]))
    assert (motion.frames, motion.fps) == (1, 30.0)


def test_morph_targets_are_left_alone(load):
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    maker.animate((1, "rotation", TIMES, TURNS, None), (2, "weights", [0, 9.0], [0, 1.0], None))
    assert load(maker).frames == 4


def test_takes(load, tmp_path):
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    maker.animate((1, "rotation", TIMES, TURNS, None), name="short")
    maker.animate((1, "rotation", TIMES * 2, TURNS, None), name="long")
    maker.animate((1, "weights", TIMES, [0, 1, 2, 3.0], None))
    motion = load(maker)
    assert (motion.name, motion.fps) == ("long", 15.0)
    assert load(maker, take="short").fps == 30.0
    assert load(maker, take="animation 2").frames == 1
    assert list_takes(tmp_path / "clip.glb") == ("short", "long", "animation 2")
    with pytest.raises(ParameterError, match=r"'short', 'long', 'animation 2'.*'run'"):
        load(maker, take="run")


def test_repeated_and_missing_names(load):
    nodes = chain_nodes()
    nodes[1]["name"] = "Hips"
    del nodes[2]["name"]
    with pytest.warns(KinestitchWarning, match="1 joint name"):
        motion = load(Maker(nodes).skin([0, 1, 2]).animate((1, "rotation", TIMES, TURNS, None)))
    assert motion.skeleton.names == ("Hips", "Hips_2", "node 2")


@pytest.mark.parametrize(
    ("times", "fps", "frames"),
    [
        ([0, 1 / 24, 2 / 24], 24, 3),
        ([1 / 30, 2 / 30, 6 / 30], 30, 6),
        ([0, 1001 / 30000, 2002 / 30000], 30000 / 1001, 3),
        ([0, 0.5, 1.5], 2, 4),
        ([0, 0.27, 0.54], 1 / 0.27, 3),
        ([0, 2 / 24, 5 / 24, 7 / 24], 24, 8),
        ([0, 0.013, 0.1], 90, 10),
        ([0, 0.0001234, 1.0], 24, 25),
        ([0, 0.0031, 0.0047, 1.0], 120, 121),
        ([5.0], 30, 1),
    ],
)
def test_rate_of_the_keys(load, times, fps, frames):
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    motion = load(maker.animate((1, "rotation", times, np.tile(TURNS[0], (len(times), 1)), None)))
    assert motion.fps == pytest.approx(fps, rel=1e-5)
    assert motion.frames == frames


def bind(world):
    return np.linalg.inv(world).swapaxes(-1, -2).reshape(-1, 16)


@pytest.mark.parametrize("way", [np.eye(4), np.diag([0.01, 0.01, 0.01, 1.0]) + np.outer([0, 0, 1, 0], [0, 0, 0, 2.0])])
def test_rest_is_the_bind_pose(load, way):
    """Two joints stand as bound, the third is bent in the file's own pose; `way` leads from the mesh to the world."""
    nodes = chain_nodes()
    bound = [matrix(nodes[0])]
    bound.append(bound[0] @ matrix(nodes[1]))
    bound.append(bound[1] @ matrix(nodes[2] | {"rotation": about(0, 50).tolist()}))
    maker = Maker(nodes)
    inverse = maker.add(bind(np.linalg.inv(way) @ np.array(bound)), "MAT4")
    motion = load(maker.skin([0, 1, 2], inverseBindMatrices=inverse).animate((1, "rotation", TIMES, TURNS, None)))
    positions, _ = rest_pose(motion.skeleton)
    assert np.allclose(positions, [m[:3, 3] for m in bound], atol=1e-5)
    assert quat_distance(motion.skeleton.rest[2], about(0, 50)) < 1e-5
    assert quat_distance(motion.skeleton.rest[0], UP) < 1e-5
    assert quat_distance(motion.rotations[0, 2], UP) < 1e-6


@pytest.mark.parametrize(("dtype", "component"), [("<i1", 5120), ("<u1", 5121), ("<i2", 5122), ("<u2", 5123)])
def test_normalised_integers(load, dtype, component):
    top = np.iinfo(dtype).max
    keys = np.array([[0, 0, 0, 1.0], [0.6, 0, 0, 0.8], [0, 0.8, 0.6, 0]])
    maker = Maker(chain_nodes()).skin([0, 1, 2])
    maker.animate((1, "rotation", TIMES[:3], keys, None))
    output = maker.add(np.rint(keys * top), "VEC4", dtype, component, normalized=True)
    maker.json["animations"][0]["samplers"][0]["output"] = output
    assert quat_distance(load(maker).rotations[:, 1], keys).max() < 2.0 / top


def test_interleaved_and_sparse_accessors(load):
    maker = Maker(chain_nodes()).skin([0, 1, 2]).animate((1, "rotation", TIMES, TURNS, None))
    rows = np.concatenate([TURNS, TIMES[:, None]], axis=1)
    maker.add(rows, "SCALAR")
    maker.json["bufferViews"][-1]["byteStride"] = 20
    view = len(maker.json["bufferViews"]) - 1
    plain = {"bufferView": view, "componentType": 5126, "count": 4}
    maker.json["accessors"][0] = plain | {"type": "SCALAR", "byteOffset": 16}
    maker.json["accessors"][1] = plain | {"type": "VEC4"}
    where, patch = maker.add([1, 3], "SCALAR", "<u2", 5123), maker.add(TURNS[[2, 0]], "VEC4")
    maker.json["accessors"][1]["sparse"] = {
        "count": 2,
        "indices": {"bufferView": maker.json["accessors"][where]["bufferView"], "componentType": 5123},
        "values": {"bufferView": maker.json["accessors"][patch]["bufferView"]},
    }
    assert quat_distance(load(maker).rotations[:, 1], TURNS[[0, 2, 2, 0]]).max() < 1e-7


def test_text_files_with_base64_and_with_a_buffer_beside(tmp_path):
    maker = Maker(chain_nodes()).skin([0, 1, 2]).animate((1, "rotation", TIMES, TURNS, None))
    inside = "data:application/octet-stream;base64," + base64.b64encode(maker.data).decode()
    (tmp_path / "my data.bin").write_bytes(maker.data)
    for uri in (inside, "my%20data.bin"):
        document = {**maker.json, "buffers": [{"uri": uri, "byteLength": len(maker.data)}]}
        (tmp_path / "a.gltf").write_text("\ufeff" + json.dumps(document), encoding="utf-8")
        assert quat_distance(read_gltf(tmp_path / "a.gltf").rotations[:, 1], TURNS).max() < 1e-7
    strange = dict.fromkeys(("https://example.org/a.bin", "/etc/passwd"), "a file beside this one")
    strange |= {"gone.bin": "'gone.bin' beside this one", "data:;base64,%%": "base64"}
    for uri, message in strange.items():
        document = {**maker.json, "buffers": [{"uri": uri, "byteLength": 8}]}
        (tmp_path / "a.gltf").write_text(json.dumps(document))
        with pytest.raises(FormatError, match=message):
            read_gltf(tmp_path / "a.gltf")


def test_quaternions_off_unit_norm_are_normalised(load):
    maker = Maker(chain_nodes()).skin([0, 1, 2]).animate((1, "rotation", TIMES, TURNS * 1.01, None))
    assert quat_distance(load(maker).rotations[:, 1], TURNS).max() < 1e-7


def test_scales_upon_scales_are_refused(load):
    nodes = [{"name": str(i), "children": [i + 1], "scale": [1e11] * 3, "translation": [1, 1, 1]} for i in range(40)]
    with pytest.raises(FormatError, match="overflow"):
        load(Maker([*nodes, {"name": "end"}]).skin(list(range(41))))


def test_order_of_products():
    """The plain evaluation of this file turns as the core does."""
    a, b = TURNS[1], about(2, 5)
    apart = matrix({"rotation": quat_multiply(a, b)}) - matrix({"rotation": a}) @ matrix({"rotation": b})
    assert np.abs(apart).max() < 1e-12
