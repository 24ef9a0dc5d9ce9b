"""What is written as glTF comes back to float32's precision; files show the rest pose and carry no needless keys."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from kinestitch.core.motion import Motion
from kinestitch.core.rotation import quat_distance, quat_identity
from kinestitch.core.skeleton import Skeleton
from kinestitch.errors import OutputError
from kinestitch.files import read, write
from kinestitch.files.glb import BINARY_CHUNK, parse_glb, serialise_glb
from kinestitch.files.gltf import read_gltf, write_gltf
from kinestitch.testing import assert_motion_close, motions, random_motion


@settings(max_examples=40, deadline=None)
@given(motions(joints=7, frames=25, bend=3.0), st.sampled_from([".glb", ".gltf"]))
def test_round_trip(tmp_path_factory, motion, suffix):
    path = tmp_path_factory.getbasetemp() / f"round{suffix}"
    write_gltf(motion, path)
    back = read_gltf(path)
    assert_motion_close(back, motion, degrees=1e-4, metres=1e-6)
    assert np.abs(back.skeleton.offsets - motion.skeleton.offsets).max() < 1e-6
    assert np.degrees(quat_distance(back.skeleton.rest, motion.skeleton.rest)).max() < 1e-4


@pytest.mark.parametrize("fps", [24, 30, 15, 37.3, 119.88, 120000 / 1001, 240, 0.5])
@pytest.mark.parametrize("frames", [1, 2, 500])
def test_rate_and_frames(tmp_path, fps, frames):
    motion = replace(random_motion(1, frames=frames), fps=fps)
    write_gltf(motion, tmp_path / "a.glb")
    assert_motion_close(read_gltf(tmp_path / "a.glb"), motion, degrees=1e-4, metres=1e-6)
    assert read_gltf(tmp_path / "a.glb").fps == motion.fps


@pytest.mark.parametrize("fps", [30.0, 60.0, 120.0, 120000 / 1001])
def test_a_long_clip_whose_key_times_are_coarse(tmp_path, fps):
    motion = replace(random_motion(2, joints=1, frames=100_000, bend=3.0), fps=fps)
    write_gltf(motion, tmp_path / "a.glb")
    data = (tmp_path / "a.glb").read_bytes()
    (tmp_path / "b.glb").write_bytes(data.replace(b'"fps"', b'"FPS"'))
    for name in ("a.glb", "b.glb"):
        back = read_gltf(tmp_path / name)
        assert back.fps == pytest.approx(fps, rel=1e-6)
        assert_motion_close(back, motion, degrees=1e-4, metres=1e-3)  # metres: it walks for kilometres


def document_and_paths(path):
    document = parse_glb(path.read_bytes()).document
    channels = document["animations"][0]["channels"]
    return document, [(channel["target"]["node"], channel["target"]["path"]) for channel in channels]


def test_only_what_leaves_the_rest_pose_has_keys(tmp_path):
    motion = random_motion(4, joints=4, frames=20)
    rotations = motion.rotations.copy()
    translations = motion.translations.copy()
    rotations[:, 1] = -motion.skeleton.rest[1]
    rotations[:, 2] = rotations[0, 2]
    translations[:, 3] += [0, 0.1, 0]
    motion = replace(motion, rotations=rotations, translations=translations)
    write_gltf(motion, tmp_path / "a.glb")
    document, paths = document_and_paths(tmp_path / "a.glb")
    expected = {(0, "translation"), (0, "rotation"), (2, "rotation"), (3, "rotation"), (3, "translation")}
    assert set(paths) == expected
    assert np.allclose(document["nodes"][1]["rotation"], motion.skeleton.rest[1], atol=1e-6)
    assert np.allclose(document["nodes"][3]["translation"], motion.skeleton.offsets[3], atol=1e-6)
    assert_motion_close(read_gltf(tmp_path / "a.glb"), motion, degrees=1e-4, metres=1e-6)


def test_a_motion_that_rests(tmp_path):
    skeleton = Skeleton(("a", "b"), (-1, 0), [[0, 1, 0], [0, 1, 0]])
    motion = Motion(skeleton, np.broadcast_to(skeleton.offsets, (7, 2, 3)), quat_identity((7, 2)), 30.0, "rest")
    write_gltf(motion, tmp_path / "a.glb")
    assert document_and_paths(tmp_path / "a.glb")[1] == [(0, "translation"), (0, "rotation")]
    assert read_gltf(tmp_path / "a.glb").frames == 7


def test_written_rotations_are_continuous(tmp_path):
    motion = random_motion(5, frames=60)
    signs = np.where(np.random.default_rng(1).random((60, 4, 1)) < 0.5, -1.0, 1.0)
    write_gltf(replace(motion, rotations=motion.rotations * signs), tmp_path / "a.glb")
    container = parse_glb((tmp_path / "a.glb").read_bytes())
    for accessor in container.document["accessors"]:
        if accessor["type"] == "VEC4":
            view = container.document["bufferViews"][accessor["bufferView"]]
            q = np.frombuffer(container.binary, "<f4", accessor["count"] * 4, view["byteOffset"]).reshape(-1, 4)
            assert (np.einsum("fi,fi->f", q[1:], q[:-1]) > 0).all()


def test_names_survive(tmp_path):
    names = ("mixamorig:Hips", "Linke Hüfte", 'quote"\\{', "日本")
    motion = random_motion(6)
    motion = replace(motion, skeleton=replace(motion.skeleton, names=names))
    write_gltf(motion, tmp_path / "a.glb")
    assert read_gltf(tmp_path / "a.glb").skeleton.names == names


def test_container_keeps_every_byte_of_its_chunks(tmp_path):
    path = tmp_path / "a.glb"
    write_gltf(random_motion(7), path)
    container = parse_glb(path.read_bytes())
    other = 0x12345678
    parts = [(kind, [data]) for kind, data in container.chunks] + [(other, [b"abc"])]
    data = b"".join(serialise_glb(container.document, parts))
    again = parse_glb(data)
    assert again.document == container.document
    assert [(kind, bytes(chunk)) for kind, chunk in again.chunks] == [
        (BINARY_CHUNK, bytes(container.binary)),
        (other, b"abc\0"),
    ]
    assert len(data) % 4 == 0


def test_text_file_holds_everything(tmp_path):
    write_gltf(random_motion(8), tmp_path / "a.gltf")
    document = json.loads((tmp_path / "a.gltf").read_text())
    assert document["buffers"][0]["uri"].startswith("data:")
    assert [entry.name for entry in tmp_path.iterdir()] == ["a.gltf"]


def test_front_door(tmp_path):
    motion = random_motion(9)
    write(motion, tmp_path / "A.GLB")
    assert read(tmp_path / "A.GLB").frames == motion.frames
    with pytest.raises(OutputError):
        write(motion, tmp_path / "no" / "a.glb")
