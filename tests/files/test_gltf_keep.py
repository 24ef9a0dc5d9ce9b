"""like=: a file's animation is replaced and read back; everything else is the source's, byte for byte."""

import json
import os
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from kinestitch.core.kinematics import with_joint_axes, world_pose
from kinestitch.core.rotation import quat_distance, quat_normalize
from kinestitch.errors import FormatError, KinestitchWarning, ParameterError, SkeletonMismatchError
from kinestitch.files import has_character, read, write
from kinestitch.files.glb import parse_glb
from kinestitch.files.gltf import list_takes, read_gltf
from kinestitch.testing import random_motion

CHANGED = ("accessors", "bufferViews", "buffers", "animations")
DATA = os.environ.get("KINESTITCH_DATA")


@pytest.fixture(scope="module")
def characters():
    """The module of this folder that makes characters, whatever the import mode."""
    import importlib.util

    spec = importlib.util.spec_from_file_location("gltf_character", Path(__file__).parent / "gltf_character.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture(params=["plain", "awkward"])
def source(request, characters, tmp_path):
    return getattr(characters, f"{request.param}_character")().save(tmp_path / "source.glb")


def other_motion(skeleton, frames=33, fps=30.0, seed=5):
    """A random motion of a skeleton, all joints turning, all a little out of place."""
    wild = random_motion(seed, joints=skeleton.joint_count, frames=frames, fps=fps, bend=2.0)
    drift = wild.translations - wild.translations[:1]
    return replace(wild, skeleton=skeleton, translations=skeleton.offsets + drift + 0.01)


def assert_same_world(actual, expected, *, degrees=0.01, metres=1e-4):
    assert actual.skeleton.names == expected.skeleton.names
    assert (actual.frames, actual.fps) == (expected.frames, expected.fps)
    a, b = world_pose(actual), world_pose(expected)
    assert np.degrees(quat_distance(a.rotations, b.rotations)).max() < degrees
    assert np.linalg.norm(a.positions - b.positions, axis=-1).max() < metres


def assert_same_rest(actual, expected):
    assert np.abs(actual.offsets - expected.offsets).max() < 1e-12
    assert np.degrees(quat_distance(actual.rest, expected.rest)).max() < 1e-9


@pytest.mark.parametrize("frames", [1, 3, 50])
def test_read_back_it_is_the_motion(source, tmp_path, frames):
    motion = other_motion(read(source).skeleton, frames)
    write(motion, tmp_path / "out.glb", like=source)
    back = read(tmp_path / "out.glb")
    assert_same_world(back, motion, degrees=1e-3, metres=1e-5)
    assert_same_rest(back.skeleton, read(source).skeleton)


def test_nothing_else_changes(source, tmp_path):
    write(other_motion(read(source).skeleton), tmp_path / "out.glb", like=source)
    old, new = parse_glb(source.read_bytes()), parse_glb((tmp_path / "out.glb").read_bytes())
    assert bytes(new.binary).startswith(bytes(old.binary))
    assert [(kind, bytes(data)) for kind, data in new.chunks[1:]] == [(0x12345678, b"abcd")]
    assert list(new.document) == list(old.document)
    for key, value in old.document.items():
        if key not in CHANGED:
            for place, entry in enumerate(value if isinstance(value, list) else [value]):
                told = new.document[key][place] if isinstance(value, list) else new.document[key]
                assert told == entry or "matrix" in entry
    for key in ("accessors", "bufferViews"):
        assert new.document[key][: len(old.document[key])] == old.document[key]
    assert len(new.document["bufferViews"]) == len(old.document["bufferViews"]) + 1
    assert len(new.document["animations"]) == 1


def test_a_matrix_becomes_what_can_be_animated(characters, tmp_path):
    source = characters.awkward_character().save(tmp_path / "source.glb")
    rest = read(source)
    write(other_motion(rest.skeleton), tmp_path / "out.glb", like=source)
    new = parse_glb((tmp_path / "out.glb").read_bytes()).document["nodes"]
    assert sum("matrix" in node for node in new) == 1  # the armature's, which has no keys
    assert_same_rest(read(tmp_path / "out.glb").skeleton, rest.skeleton)


def test_morph_keys_stay_as_far_as_the_motion_reaches(characters, tmp_path):
    source = characters.awkward_character().save(tmp_path / "source.glb")
    for frames, keys in ((60, 5), (6, 3)):
        write(other_motion(read(source).skeleton, frames), tmp_path / "out.glb", like=source)
        document = parse_glb((tmp_path / "out.glb").read_bytes()).document
        animation = document["animations"][0]
        channel = next(c for c in animation["channels"] if c["target"]["path"] == "weights")
        sampler = animation["samplers"][channel["sampler"]]
        counts = [document["accessors"][sampler[key]]["count"] for key in ("input", "output")]
        assert counts == [keys, 3 * keys]
        assert sampler["interpolation"] == "CUBICSPLINE"


def two_takes(characters, path):
    character = characters.plain_character(frames=40)
    second = {"name": "second", "samplers": [], "channels": [], "extras": {"mood": "glad"}}
    character.document["animations"].append(second)
    for joint in range(3):
        turns = quat_normalize(np.random.default_rng(joint).normal(size=(10, 4)))
        character.channel(joint, "rotation", np.arange(10) / 30, turns, animation=1)
    return character.save(path)


def test_only_the_take_that_was_read_is_replaced(characters, tmp_path):
    source = two_takes(characters, tmp_path / "source.glb")
    assert read(source).name == "first"
    for take in ("first", "second"):
        motion = other_motion(read(source, take=take).skeleton, frames=12)
        for out, told, options in (("a.glb", motion, {"take": take}), ("b.glb", replace(motion, name=take), {})):
            write(told, tmp_path / out, like=source, **options)
            assert list_takes(tmp_path / out) == ("first", "second")
            assert_same_world(read(tmp_path / out), motion)  # the newest is the one to read
            other = {"first": "second", "second": "first"}[take]
            assert_same_world(read(tmp_path / out, take=other), read(source, take=other), degrees=1e-9, metres=1e-12)
    assert parse_glb((tmp_path / "b.glb").read_bytes()).document["animations"][1]["extras"]["mood"] == "glad"
    write(motion, tmp_path / "c.glb", like=tmp_path / "b.glb", take="first")
    assert read(tmp_path / "c.glb").name == "first"
    with pytest.raises(ParameterError, match="'first', 'second'"):
        write(motion, tmp_path / "d.glb", like=source, take="third")


def test_a_file_without_animation_gets_one(characters, tmp_path):
    character = characters.plain_character()
    del character.document["animations"]
    source = character.save(tmp_path / "source.glb")
    motion = replace(other_motion(read(source).skeleton), name="new one")
    write(motion, tmp_path / "out.glb", like=source)
    assert list_takes(tmp_path / "out.glb") == ("new one",)
    assert_same_world(read(tmp_path / "out.glb"), motion)


def test_figures_without_a_skin(characters, tmp_path):
    character = characters.awkward_character()
    del character.document["skins"]
    for node in character.document["nodes"]:
        node.pop("skin", None)
    source = character.save(tmp_path / "source.glb")
    motion = other_motion(read(source).skeleton)
    write(motion, tmp_path / "out.glb", like=source)
    assert_same_world(read(tmp_path / "out.glb"), motion)


def test_a_file_may_be_written_over_itself(source):
    motion = other_motion(read(source).skeleton)
    write(motion, source, like=source)
    assert_same_world(read(source), motion)


@pytest.mark.parametrize(("start", "stop"), [(".glb", ".gltf"), (".gltf", ".glb"), (".gltf", ".gltf")])
@pytest.mark.parametrize("folder", ["here", "there"])
def test_from_text_to_binary_and_back(characters, tmp_path, start, stop, folder):
    character = characters.plain_character()
    (tmp_path / "a b.png").write_bytes(characters.PICTURE)
    character.document["images"] = [{"uri": "a%20b.png"}]
    source = character.save(tmp_path / f"source{start}")
    (tmp_path / "there").mkdir()
    out = (tmp_path if folder == "here" else tmp_path / folder) / f"out{stop}"
    motion = other_motion(read(source).skeleton)
    write(motion, out, like=source)
    assert_same_world(read(out), motion)
    document = parse_glb(out.read_bytes()).document if stop == ".glb" else json.loads(out.read_text())
    assert document["images"][0]["uri"].startswith("a%20b" if folder == "here" else "data:image/png;base64,")


def test_a_lost_picture_is_told(characters, tmp_path):
    character = characters.plain_character()
    character.document["images"] = [{"uri": "none.png"}, {"uri": "../secret.txt"}]
    (tmp_path / "secret.txt").write_text("mine")
    (tmp_path / "in").mkdir()
    source = character.save(tmp_path / "in" / "source.glb")
    with pytest.warns(KinestitchWarning, match=r"2 picture\(s\)"):
        write(read(source), tmp_path / "out.glb", like=source)


@pytest.mark.parametrize(
    ("change", "refused"),
    [
        (lambda d: d.update(extras={"x": 1e999}), True),
        (lambda d: d.update(images=[{"uri": "%00.png"}, {"uri": "/etc/a.png"}, {"uri": "a" * 300 + ".png"}]), False),
        (lambda d: d["animations"][0]["channels"].append({"sampler": 0, "target": {"node": [], "path": "odd"}}), False),
    ],
)
def test_odd_documents(characters, tmp_path, change, refused):
    character = characters.plain_character()
    change(character.document)
    (tmp_path / "in").mkdir()
    source = tmp_path / "in" / "source.gltf"
    character.save(source)
    source.write_text(source.read_text().replace("Infinity", "1e999"))
    with warnings.catch_warnings(action="ignore", category=KinestitchWarning):
        if not refused:
            write(read(source), tmp_path / "out.gltf", like=source)
            return
        with pytest.raises(FormatError, match=r"JSON can hold.*source\.gltf"):
            write(read(source), tmp_path / "out.glb", like=source)
    assert not (tmp_path / "out.glb").exists()


def test_other_axes_prefixes_and_fewer_joints(source, tmp_path):
    skeleton = read(source).skeleton
    motion = other_motion(skeleton)
    turned = with_joint_axes(motion, [0.0, 0.0, 0.0, 1.0])
    names = tuple(f"rig7:{name}" for name in skeleton.names)
    write(replace(turned, skeleton=replace(turned.skeleton, names=names)), tmp_path / "out.glb", like=source)
    assert_same_world(read(tmp_path / "out.glb"), motion)
    leaf = max(set(range(skeleton.joint_count)) - set(skeleton.parents))
    left = [joint for joint in range(skeleton.joint_count) if joint != leaf]
    parents = tuple(left.index(skeleton.parents[j]) if j else -1 for j in left)
    fewer = replace(
        skeleton,
        names=tuple(skeleton.names[j] for j in left),
        parents=parents,
        offsets=skeleton.offsets[left],
        rest=skeleton.rest[left],
        tips=None,
    )
    part = replace(
        motion, skeleton=fewer, translations=motion.translations[:, left], rotations=motion.rotations[:, left]
    )
    write(part, tmp_path / "out.glb", like=source)
    back = read(tmp_path / "out.glb")
    assert np.abs(back.translations[:, leaf] - skeleton.offsets[leaf]).max() < 1e-5
    assert np.degrees(quat_distance(back.rotations[:, leaf], skeleton.rest[leaf])).max() < 1e-3
    assert np.abs(world_pose(back).positions[:, left] - world_pose(part).positions).max() < 1e-5


def test_what_is_refused(source, tmp_path):
    motion = other_motion(read(source).skeleton)
    strange = tuple(f"{name}x" if joint % 2 else name for joint, name in enumerate(motion.skeleton.names))
    with pytest.raises(SkeletonMismatchError, match=r"'Joint1x', 'Joint3x', 'Joint5x'.*source\.glb"):
        write(replace(motion, skeleton=replace(motion.skeleton, names=strange)), tmp_path / "a.glb", like=source)
    longer = replace(motion.skeleton, offsets=motion.skeleton.offsets * 1.1)
    with pytest.raises(SkeletonMismatchError, match=r"rests .* m elsewhere"):
        write(replace(motion, skeleton=longer), tmp_path / "a.glb", like=source)
    with pytest.raises(ParameterError, match=r"the output's format, FBX, got 'source\.glb'"):
        write(motion, tmp_path / "a.fbx", like=source)
    with pytest.raises(FileNotFoundError):
        write(motion, tmp_path / "a.glb", like=tmp_path / "none.glb")
    assert not list(tmp_path.glob("a.*"))


def test_has_character(source, tmp_path):
    assert has_character(source)
    write(read(source), tmp_path / "bare.glb")
    write(read(source), tmp_path / "bare.bvh")
    (tmp_path / "bad.glb").write_bytes(b"glTF")
    assert not any(has_character(tmp_path / name) for name in ("bare.glb", "bare.bvh", "bad.glb"))


@pytest.mark.skipif(not DATA, reason="KINESTITCH_DATA, the folder of real clips, is not set")
@pytest.mark.parametrize(
    "name",
    [
        *("mixamo_skinned/Michelle", "mixamo_skinned/RobotExpressive", "mixamo_skinned/Soldier", "mixamo_skinned/Xbot"),
        *("gltf/Fox", "gltf/Knight"),
    ],
)
def test_real_characters(name, tmp_path):
    assert DATA
    source = Path(DATA) / f"{name}.glb"
    for take in list_takes(source)[:5]:
        motion = read_gltf(source, take=take)
        back = replace(motion, translations=motion.translations[::-1], rotations=motion.rotations[::-1])
        write(back, tmp_path / "out.glb", like=source, take=take)
        assert_same_world(read(tmp_path / "out.glb"), back)
        old, new = parse_glb(source.read_bytes()), parse_glb((tmp_path / "out.glb").read_bytes())
        assert bytes(new.binary).startswith(bytes(old.binary))
        assert {k: v for k, v in new.document.items() if k not in CHANGED} == {
            k: v for k, v in old.document.items() if k not in CHANGED
        }
